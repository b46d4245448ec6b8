"""A checkout stands alone: its tests run its own code, wherever benchtwin is installed
from."""

import shutil
import subprocess
import sys

from packages import ROOT

TEST = """
import subprocess
import sys

ROOT = {root!r}

def test_its_own_code(tmp_path):
    import benchtwin.bench

    assert benchtwin.bench.__file__.startswith(ROOT)
    code = "import benchtwin.bench; print(benchtwin.bench.__file__)"
    command = [sys.executable, "-c", code]
    told = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert told.stdout.startswith(ROOT)
"""


def test_a_second_checkout_tests_its_own_code(tmp_path):
    second = tmp_path / "second"
    for folder in ("benchtwin", "bench"):
        shutil.copytree(ROOT / folder, second / folder, symlinks=True)
    for file in ("pyproject.toml", "conftest.py"):
        shutil.copy(ROOT / file, second / file)
    (second / "tests").mkdir()
    test = second / "tests" / "test_which.py"
    test.write_text(TEST.format(root=str(second)))
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", str(test)]
    done = subprocess.run(command, cwd=second, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_every_package_is_linked():
    """benchtwin/vision is vision/, and so on: what a tool reads in place is what is
    installed."""
    packages = {
        f.parent.name for f in ROOT.glob("*/__init__.py") if f.parent.name != "tests"
    }
    links = {
        f.name: f.readlink() for f in (ROOT / "benchtwin").iterdir() if f.is_symlink()
    }
    assert set(links) == packages - {"benchtwin"}
    assert all((ROOT / "benchtwin" / n).resolve() == ROOT / n for n in links)
