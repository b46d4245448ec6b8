"""Names, folders, disks and terminals as they are elsewhere."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

from benchtwin import command_line
from benchtwin.measure import measured
from benchtwin.vision.measurement import GOOD, Observation, Quantity
from benchtwin.vision.out_folder import file_name
from benchtwin.vision.results import Results

ROOT = Path(__file__).parent.parent.parent
TRACK = "t_s\n0.2\n0.45\n0.6\n"


def bench(folder: Path, name: str = "drop-01", more: str = "") -> Path:
    (folder / name).mkdir(parents=True)
    (folder / name / "recording.toml").write_text(
        f'rig = "drop"\n{more}', encoding="utf8"
    )
    (folder / name / "impacts.csv").write_text(TRACK)
    return folder


def benchtwin(*arguments, **environment) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "benchtwin", *map(str, arguments)]
    return subprocess.run(
        command,
        capture_output=True,
        cwd=ROOT,
        env={**os.environ, **environment},
        check=False,
    )


def test_names_of_all_kinds_on_a_terminal_without_their_letters(tmp_path):
    """Spaces, foreign letters, and bytes that are no text."""
    folder = tmp_path / os.fsdecode("Böhnchen & Co, 試 ".encode() + b"\xff")
    bench(bench(folder, "Fall №1 [kurz]"), os.fsdecode(b"drop-\xff"))
    done = benchtwin(
        "measure", folder, "--out", tmp_path / "Ergebnis 1", PYTHONIOENCODING="ascii"
    )
    assert done.returncode == 0, done.stderr
    assert b"Fall ?1 [kurz]" in done.stdout
    out = tmp_path / "Ergebnis 1"
    assert r"drop-\udcff" in (out / "measurements.csv").read_text(encoding="utf8")
    assert (out / "overlays" / "Fall _1 _kurz_.png").is_file()


@pytest.mark.parametrize(
    "name",
    ["../../evil", "/etc/evil", "..", "a" * 5000, "nul\\..\\x", "CON", "\u202eevil"],
)
def test_an_id_stays_within_the_results(tmp_path, name):
    results = Results(tmp_path / "in" / "out")
    picture = {"p": np.zeros((4, 4, 3), np.uint8)}
    results.add(
        Observation(
            name,
            "drop",
            (Quantity("restitution", 0.5, 0.1, "1", GOOD),),
            pictures=picture,
        )
    )
    results.finish()
    (file,) = (tmp_path / "in" / "out" / "overlays").glob("*.png")
    assert {p.name for p in tmp_path.iterdir()} == {"in"} and {
        p.name for p in (tmp_path / "in").iterdir()
    } == {"out"}
    assert len(file.name.encode()) < 255


def test_two_ids_that_look_alike_as_files_get_two_files():
    assert file_name("a/b", {"a_b"}) == "a_b-2"
    assert file_name("A_b", {"a_b", "a_b-2"}) == "A_b-3"


@pytest.mark.skipif(
    not hasattr(os, "fork"), reason="limits of a process are set as on Unix"
)
def test_a_disk_that_fills_up_costs_the_results_not_the_old_ones(tmp_path):
    """A limit on the size of files stands in for a full disk: writing fails in the
    midst of a file."""
    folder, out = bench(tmp_path / "bench"), tmp_path / "out"
    out.mkdir()
    (out / "measurements.csv").write_text("old")
    limited = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (2000,"
        " 2000)); import benchtwin.command_line as command;sys.argv = ['benchtwin',"
        f" 'measure', {str(folder)!r}, '--out', {str(out)!r}, '--overwrite',"
        " '--quiet']; command.main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", limited], capture_output=True, cwd=ROOT, check=False
    )
    assert (
        done.returncode == 2
        and b"cannot write to" in done.stderr
        and b"Traceback" not in done.stderr
    )
    assert (out / "measurements.csv").read_text() == "old"
    assert [p.name for p in tmp_path.iterdir() if p.name.startswith(".")] == []


def test_two_runs_into_one_folder_leave_one_whole_result(tmp_path):
    both = [Results(tmp_path / "out") for _ in range(2)]
    for k, results in enumerate(both):
        results.add(
            Observation(f"run-{k}", "drop", (Quantity("restitution", 0.5, 0.1, "1"),))
        )
    both[0].finish()
    with pytest.raises(OSError):
        both[1].finish()
    both[1].abandon()
    assert "run-0" in (tmp_path / "out" / "measurements.csv").read_text()
    assert {p.name for p in tmp_path.iterdir()} == {"out"}


@pytest.mark.skipif(
    not hasattr(os, "getuid") or os.getuid() == 0,
    reason="nothing is closed to the superuser",
)
def test_a_folder_that_may_not_be_read_is_named_and_the_rest_measured(tmp_path):
    folder = bench(bench(tmp_path / "bench"), "drop-02")
    (folder / "drop-02").chmod(0)
    try:
        done = benchtwin("measure", folder, "--out", tmp_path / "out")
    finally:
        (folder / "drop-02").chmod(0o700)
    assert done.returncode == 0 and b"no permission" in done.stdout


def test_a_read_only_installation_keeps_its_compiled_code_in_a_folder_of_ones_own(
    tmp_path, monkeypatch
):
    for name, value in (
        ("HOME", "/proc/nobody"),
        ("XDG_CACHE_HOME", ""),
        ("NUMBA_CACHE_DIR", ""),
    ):
        monkeypatch.setenv(name, value)
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(os, "access", lambda *_: False)
    command_line._keep_compiled_code()
    kept = Path(os.environ["NUMBA_CACHE_DIR"])
    assert kept.parent == tmp_path and kept.stat().st_mode & 0o777 == 0o700
    monkeypatch.setattr(os, "getuid", lambda: 4_000_000)
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    (tmp_path / "benchtwin-kernels-4000000").mkdir()
    command_line._keep_compiled_code()
    assert os.environ["NUMBA_CACHE_DIR"] != str(tmp_path / "benchtwin-kernels-4000000")


def test_a_fault_of_ours_is_one_line(tmp_path, monkeypatch):
    def broken(*_, **__):
        raise KeyError("here")

    monkeypatch.setattr(measured, "existing", broken)
    monkeypatch.setattr(
        sys, "argv", ["benchtwin", "measure", ".", "--out", str(tmp_path / "o")]
    )
    with pytest.raises(SystemExit) as ended:
        command_line.main()
    said = (
        ended.value.code
    )  # a text: Python prints it as the last line, and exits with 1
    assert "\n" not in said and "please report it: KeyError('here')" in said


def test_the_front_door_opens_without_what_is_slow():
    """`--help` of the command and of each verb: none of the large packages is imported
    for it."""
    looks = (
        "import sys, benchtwin.command_line as command\nfrom typer.testing import"
        " CliRunner\nfor verb in ('measure', 'simulate', 'calibrate', 'diagnose',"
        " 'export', 'prove'):\n    assert CliRunner().invoke(command.app, [verb,"
        " '--help']).exit_code == 0\nprint(sorted({'numpy', 'pandas', 'scipy', 'numba',"
        " 'cv2', 'plotly', 'dask', 'benchtwin.measure.batch'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", looks],
        capture_output=True,
        cwd=ROOT,
        check=False,
        text=True,
    )
    assert done.stdout.strip() == "[]", done.stdout + done.stderr
