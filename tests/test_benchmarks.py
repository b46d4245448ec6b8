"""Programs that are started once in months: each is imported and says how to start it,
so that it follows what it measures. (mypy, which `make lint` starts, holds their calls
to the packages.)"""

import runpy
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PLACES = ("benchmarks", "benchmarks/others", "scripts")
FILES = (file for place in PLACES for file in (ROOT / place).glob("*.py"))
PROGRAMS = sorted(
    file for file in FILES if "__main__" in file.read_text(encoding="utf8")
)


def test_there_are_programs():
    assert len(PROGRAMS) > 15


@pytest.mark.parametrize("file", PROGRAMS, ids=lambda file: file.stem)
def test_a_program_imports_and_says_how_to_start_it(
    file, monkeypatch, capsys, tmp_path
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [str(file), "--help"])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(file), run_name="__main__")
    assert ended.value.code == 0
    assert f"usage: {file.name}" in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []  # nothing was begun
