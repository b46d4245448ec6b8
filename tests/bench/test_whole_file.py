"""Temporary files and folders: by names that nobody can guess, through no link, gone
after a stop, and after a kill with the next run."""

import os
import signal
import subprocess
import sys
import time

import pytest

from benchtwin.bench.whole_file import folder_beside, new_folder, own_folder, whole

KILLED = """
import sys, time
from pathlib import Path
from benchtwin.bench.whole_file import folder_beside, whole
here = Path(sys.argv[1])
with whole(here / "file"), folder_beside(here / "out") as part:
    (part / "half").write_text("half")
    print("there", flush=True)
    time.sleep(60)
"""


def hidden(folder):
    return [p for p in folder.iterdir() if p.name.startswith(".")]


def test_what_a_killed_run_left_goes_with_the_next_and_what_a_live_one_has_stays(
    tmp_path,
):
    runs = [
        subprocess.Popen(
            [sys.executable, "-c", KILLED, str(tmp_path)], stdout=subprocess.PIPE
        )
        for _ in range(2)
    ]
    for run in runs:
        assert run.stdout.readline()
    runs[0].kill()
    runs[0].wait()
    assert len(hidden(tmp_path)) == 4
    for part in hidden(tmp_path):  # a while ago
        os.utime(part, (time.time() - 60,) * 2)
    with whole(tmp_path / "file") as part:
        part.write_text("whole")
    with folder_beside(tmp_path / "out"):
        pass
    assert len(hidden(tmp_path)) == 2 and (tmp_path / "file").read_text() == "whole"
    runs[1].kill()
    runs[1].wait()


def test_a_link_by_that_name_is_not_followed(tmp_path):
    """Nor removed through: it is not ours."""
    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs" / "file").write_text("theirs")
    link = tmp_path / ".out-guessed.part"
    link.symlink_to(tmp_path / "theirs")
    os.utime(link, (0, 0), follow_symlinks=False)
    with new_folder(tmp_path / "out") as part:
        assert part.stat().st_mode & 0o077 == 0
    assert (tmp_path / "theirs" / "file").read_text() == "theirs"
    assert link.is_symlink() and not hidden(tmp_path / "out")


def test_a_file_that_is_written_whole_can_be_read_by_whom_the_umask_lets(tmp_path):
    before = os.umask(0o022)
    try:
        with whole(tmp_path / "file") as part:
            part.write_text("x")
        assert (tmp_path / "file").stat().st_mode & 0o777 == 0o644
    finally:
        os.umask(before)


def test_the_longest_name_can_be_written(tmp_path):
    with whole(tmp_path / ("x" * 255)) as part:
        part.write_text("x")
    assert [p.name for p in tmp_path.iterdir()] == ["x" * 255]


@pytest.mark.parametrize("how", ["link", "open to others"])
def test_a_folder_that_is_not_ours_alone_is_not_taken(tmp_path, how):
    folder = tmp_path / "locks"
    if how == "link":
        (tmp_path / "theirs").mkdir(mode=0o700)
        folder.symlink_to(tmp_path / "theirs")
    else:
        folder.mkdir()
        folder.chmod(0o777)
    with pytest.raises(PermissionError, match="not a folder of this user's alone"):
        own_folder(folder)
    assert own_folder(tmp_path / "new").stat().st_mode & 0o077 == 0


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_command_that_is_asked_to_end_leaves_nothing_half_written(tmp_path, number):
    bench = tmp_path / "bench"
    for n in range(400):
        (bench / f"drop-{n}").mkdir(parents=True)
        (bench / f"drop-{n}" / "recording.toml").write_text(
            'rig = "drop"\n[drop]\nheight_mm = 100.0\nrebound_height_mm = [30.0]\n'
        )
    out = tmp_path / "out"
    words = [
        sys.executable,
        "-m",
        "benchtwin",
        "measure",
        str(bench),
        "--out",
        str(out),
    ]
    run = subprocess.Popen(
        words,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    until = time.monotonic() + 60
    while not hidden(tmp_path) and time.monotonic() < until and run.poll() is None:
        time.sleep(0.01)
    assert hidden(tmp_path), run.communicate()
    run.send_signal(number)
    run.communicate(timeout=60)
    assert run.returncode > 0 and not hidden(tmp_path) and not out.exists()
