"""Runs are queued one at a time, outlive the page, show progress, stop, go on, and are
found again as they were left."""

import itertools
import json
import shutil
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import psutil
import pytest

from benchtwin.page import runs
from benchtwin.page.folder import Folder, Refused
from benchtwin.page.private import locked
from benchtwin.twin.bench_folder import hashes
from benchtwin.vision.find_recordings import find_recordings

RUNNER = """
# The runner, with a command that shows progress until the file `done` is in the bench.
import sys
from pathlib import Path
from benchtwin.page import runner, runs

sleeper = str(Path(__file__).with_name("sleeper.py"))
runs.command_line = lambda job, bench: [sys.executable, sleeper, str(bench / "done")]
root, bench, place = map(Path, sys.argv[1:4])
sys.exit(runner.main(root, bench, place, int(sys.argv[4])))
"""
SLEEPER = """
import signal, sys, time, pathlib
# tests in the background ignore it
signal.signal(signal.SIGINT, signal.default_int_handler)
done = pathlib.Path(sys.argv[1])
try:
    for i in range(600):
        print(f"\\rpart {i}/600", end="", flush=True)
        time.sleep(0.05)
        if done.exists():
            break
    else:
        sys.exit(3)
    print("\\nfinished")
except KeyboardInterrupt:
    print("\\nstopped; the same command goes on where it stopped")
    sys.exit(1)
"""


@pytest.fixture
def bench(tmp_path):
    (tmp_path / "soy").mkdir()
    return tmp_path / "soy"


@pytest.fixture
def folder(tmp_path):
    return Folder(tmp_path)


@pytest.fixture
def slow(tmp_path_factory, monkeypatch):
    """Commands that show progress until the file `done` is in the bench."""
    place = tmp_path_factory.mktemp("runner")
    (place / "runner.py").write_text(RUNNER)
    (place / "sleeper.py").write_text(SLEEPER)
    monkeypatch.setattr(runs, "RUNNER", (sys.executable, str(place / "runner.py")))


def queued(bench, folder) -> Path:
    return runs.enqueue(bench, "measure", (), folder).folder


def read_run(place: Path) -> runs.Run:
    """A run as its folder stands, as a page reads it among others."""
    with locked(place.parent / "reading"):
        return runs._read(place)


def until(condition, seconds: float = 90.0):
    end = time.time() + seconds
    while not condition():
        assert time.time() < end, "it took too long"
        time.sleep(0.05)


def test_one_at_a_time_with_progress_and_log(bench, folder, slow):
    first, second = queued(bench, folder), queued(bench, folder)
    until(lambda: "/600" in read_run(first).progress)
    assert (read_run(first).status, read_run(second).status) == (
        runs.RUNNING,
        runs.WAITING,
    )
    (bench / "done").touch()
    until(lambda: read_run(first).status == runs.DONE)
    assert (
        read_run(first).log == "part" + read_run(first).log[4:]
        and "finished" in read_run(first).log
    )
    until(lambda: read_run(second).status == runs.DONE)
    assert [r.number for r in runs.all_runs(bench)] == [2, 1]


def test_stopped_it_says_so_and_goes_on(bench, folder, slow):
    place = queued(bench, folder)
    until(lambda: "/600" in read_run(place).progress)
    runs.stop(read_run(place))
    until(lambda: read_run(place).status == runs.STOPPED)
    assert "goes on where it stopped" in read_run(place).log
    (bench / "done").touch()
    runs.resume(read_run(place), bench, folder)
    until(lambda: read_run(place).status == runs.DONE)


def test_the_next_run_begins_though_no_page_is_open(bench, folder, slow):
    first, second = queued(bench, folder), queued(bench, folder)
    (bench / "done").touch()
    until(lambda: read_run(second).status == runs.DONE)  # nobody asked again
    before, after = (
        json.loads((place / "state.json").read_text()) for place in (first, second)
    )
    assert before["code"] == 0 and before["ended"] <= after["started"]
    assert "finished" in read_run(second).log


def test_a_waiting_run_is_taken_from_the_queue(bench, folder, slow):
    first, second = queued(bench, folder), queued(bench, folder)
    runs.stop(read_run(second))
    (bench / "done").touch()
    until(lambda: read_run(first).status == runs.DONE)
    until(lambda: read_run(second).status == runs.STOPPED)
    assert read_run(second).log == ""


def processes(place: Path) -> list[psutil.Process]:
    """The runner of a run, and its command."""
    (runner,) = [
        p
        for p in psutil.process_iter(["cmdline"])
        if str(place) in (p.info["cmdline"] or ())
    ]
    return [runner, *runner.children()]


def test_a_run_can_be_resumed_after_the_machine_was_switched_off(bench, folder, slow):
    place, waiting = queued(bench, folder), queued(bench, folder)
    until(lambda: "/600" in read_run(place).progress)
    for process in (*processes(waiting), *processes(place)):
        process.kill()
    until(lambda: read_run(place).status == runs.BROKEN)
    until(lambda: read_run(waiting).status == runs.BROKEN)
    assert "finished" not in read_run(place).log
    (bench / "done").touch()
    for one in (place, waiting):
        runs.resume(read_run(one), bench, folder)
    for one in (place, waiting):
        until(lambda one=one: read_run(one).status == runs.DONE)
        assert "finished" in read_run(one).log


def test_a_command_whose_runner_was_killed_holds_the_bench_until_it_ends(
    bench, folder, slow
):
    place = queued(bench, folder)
    until(lambda: "/600" in read_run(place).progress)
    runner, command = processes(place)
    command.suspend()
    runner.kill()
    until(lambda: not runner.is_running() or runner.status() == "zombie")
    second = queued(bench, folder)
    assert [read_run(p).status for p in (place, second)] == [
        runs.RUNNING,
        runs.WAITING,
    ]
    command.kill()
    until(lambda: read_run(place).status == runs.BROKEN)


def test_two_pages_that_ask_at_once_start_one(bench, folder, slow):
    with ThreadPoolExecutor(6) as pages:
        asked = [pages.submit(queued, bench, folder) for _ in range(6)]
    places = sorted(a.result() for a in asked)
    assert [p.name for p in places] == [f"{n:04d}-measure" for n in range(1, 7)]
    expected = [runs.RUNNING, *[runs.WAITING] * 5]
    until(lambda: sorted(read_run(p).status for p in places) == expected)
    (bench / "done").touch()
    until(lambda: all(r.status == runs.DONE for r in runs.all_runs(bench)), 60)
    ends = [json.loads((p / "state.json").read_text()) for p in places]
    ends.sort(key=lambda state: state["started"])
    assert all(a["ended"] <= b["started"] for a, b in itertools.pairwise(ends))


def test_an_ordinary_command_runs(bench, folder):
    (bench / "drop-01").mkdir()
    (bench / "drop-01" / "recording.toml").write_text(
        'rig = "drop"\n[drop]\nheight_mm = 310\n'
    )
    (bench / "drop-01" / "readings.csv").write_text("rebound_height_mm\n70\n72\n")
    run = runs.enqueue(bench, "measure", (), folder)
    until(lambda: read_run(run.folder).status not in (runs.RUNNING, runs.WAITING), 60)
    assert read_run(run.folder).status == runs.DONE
    assert (bench / "results" / "measured" / "summary.csv").is_file()
    for command, options in (
        ("rm", ()),
        ("measure", ("--quick",)),
        ("calibrate", ("--quick", "--quick")),
        ("calibrate", ("--scheduler", "tcp://evil.example:1")),
        ("calibrate", ("--out",)),
    ):
        with pytest.raises(Refused):
            runs.enqueue(bench, command, options, folder)
    assert len(runs.all_runs(bench)) == 1


def test_runs_are_no_part_of_a_bench(bench, folder, slow):
    """Nothing of them travels with it: a copy has none, and what a bench brings along
    is none."""
    (bench / "done").touch()
    run = runs.enqueue(bench, "measure", (), folder)
    until(lambda: read_run(run.folder).status == runs.DONE)
    assert {p.name for p in bench.rglob("*")} == {"done", "results", ".results"}
    copy = bench.with_name("copy")
    shutil.copytree(bench, copy)
    forged = copy / "results" / "runs" / "0001-measure"
    forged.mkdir(parents=True)
    shutil.copytree(run.folder, forged, dirs_exist_ok=True)
    assert runs.all_runs(copy) == []
    assert not run.folder.stat().st_mode & 0o022


def test_a_diagnosis_is_left_in_the_bench_and_is_no_recording_of_it(tmp_path):
    """A run of the page writes below the bench: the command takes the folder, and finds
    no recordings in it the next time."""
    bench, folder = tmp_path / "bench", Folder(tmp_path)
    shutil.copytree(Path(__file__).parents[2] / "samples" / "heard-drop", bench)
    run = runs.enqueue(bench, "diagnose", ("--quick",), folder)
    until(
        lambda: read_run(run.folder).status not in (runs.RUNNING, runs.WAITING),
        120,
    )
    assert read_run(run.folder).status == runs.DONE, read_run(run.folder).log
    left = bench / "results" / "diagnosed"
    assert (left / "report.html").is_file()
    shutil.copytree(bench / "drop-01", left / "twin" / "drop-01-old")
    assert [r.path.parent for r in find_recordings(bench)] == [bench] * 3
    assert not any(name.startswith("results") for name in hashes(bench))
