"""Runs are queued one at a time, outlive the page, show progress, stop, go on, and are
found again as they were left."""

import json
import os
import shutil
import signal
import sys
import time
from pathlib import Path

import pytest
from benchtwin.page import runs
from benchtwin.page.folder import Folder, Refused
from benchtwin.twin.bench_folder import hashes
from benchtwin.vision.find_recordings import find_recordings

SLEEPER = """
import signal, sys, time, pathlib
# tests in the background ignore it
signal.signal(signal.SIGINT, signal.default_int_handler)
done = pathlib.Path(sys.argv[1])
try:
    for i in range(100):
        print(f"\\rpart {i}/100", end="", flush=True)
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


def sleeper(bench, folder, number: int):
    """A run in the queue that prints progress until the file `done` is there."""
    place = folder.results(bench) / "runs" / f"{number:04d}-measure"
    place.mkdir(parents=True)
    arguments = [sys.executable, "-c", SLEEPER, str(bench / "done")]
    (place / "job.json").write_text(
        json.dumps({"command": "measure", "options": [], "arguments": arguments})
    )
    return place


def until(condition, seconds: float = 20.0):
    end = time.time() + seconds
    while not condition():
        assert time.time() < end, "it took too long"
        time.sleep(0.05)


def test_one_at_a_time_with_progress_and_log(bench, folder):
    first, second = sleeper(bench, folder, 1), sleeper(bench, folder, 2)
    runs.advance(bench, folder)
    until(lambda: "/100" in runs.read_run(first).progress)
    runs.advance(bench, folder)
    assert (runs.read_run(first).status, runs.read_run(second).status) == (
        runs.RUNNING,
        runs.WAITING,
    )
    (bench / "done").touch()
    until(lambda: runs.read_run(first).status == runs.DONE)
    assert (
        runs.read_run(first).log == "part" + runs.read_run(first).log[4:]
        and "finished" in runs.read_run(first).log
    )
    runs.advance(bench, folder)
    until(lambda: runs.read_run(second).status == runs.DONE)
    assert [r.number for r in runs.all_runs(bench, folder)] == [2, 1]


def test_stopped_it_says_so_and_goes_on(bench, folder):
    place = sleeper(bench, folder, 1)
    runs.advance(bench, folder)
    until(lambda: "/100" in runs.read_run(place).progress)
    runs.stop(runs.read_run(place))
    until(lambda: runs.read_run(place).status == runs.STOPPED)
    assert "goes on where it stopped" in runs.read_run(place).log
    (bench / "done").touch()
    runs.resume(runs.read_run(place), bench, folder)
    until(lambda: runs.read_run(place).status == runs.DONE)


def test_the_next_run_begins_though_no_page_is_open(bench, folder):
    first, second = sleeper(bench, folder, 1), sleeper(bench, folder, 2)
    runs.advance(bench, folder)
    (bench / "done").touch()
    until(lambda: runs.read_run(second).status == runs.DONE)  # nobody asked again
    before, after = (
        json.loads((place / "state.json").read_text()) for place in (first, second)
    )
    assert before["code"] == 0 and before["ended"] <= after["started"]
    assert "finished" in runs.read_run(second).log


def test_a_waiting_run_is_taken_from_the_queue(bench, folder):
    first, second = sleeper(bench, folder, 1), sleeper(bench, folder, 2)
    runs.advance(bench, folder)
    runs.stop(runs.read_run(second))
    (bench / "done").touch()
    until(lambda: runs.read_run(first).status == runs.DONE)
    assert (runs.read_run(second).status, runs.read_run(second).log) == (
        runs.STOPPED,
        "",
    )


def test_a_run_can_be_resumed_after_the_machine_was_switched_off(bench, folder):
    place = sleeper(bench, folder, 1)
    runs.advance(bench, folder)
    until(lambda: "/100" in runs.read_run(place).progress)
    state = json.loads((place / "state.json").read_text())
    os.kill(state["pid"], signal.SIGKILL)
    os.kill(state["child"], signal.SIGKILL)
    until(lambda: runs.read_run(place).status == runs.BROKEN)
    assert "finished" not in runs.read_run(place).log
    (bench / "done").touch()
    runs.resume(runs.read_run(place), bench, folder)
    until(lambda: runs.read_run(place).status == runs.DONE)
    assert "finished" in runs.read_run(place).log
    assert json.loads((place / "state.json").read_text())["pid"] != state["pid"]


def test_an_ordinary_command_runs(bench, folder):
    (bench / "drop-01").mkdir()
    (bench / "drop-01" / "recording.toml").write_text(
        'rig = "drop"\n[drop]\nheight_mm = 310\n'
    )
    (bench / "drop-01" / "readings.csv").write_text("rebound_height_mm\n70\n72\n")
    run = runs.enqueue(bench, "measure", (), folder)
    until(
        lambda: runs.read_run(run.folder).status not in (runs.RUNNING, runs.WAITING), 60
    )
    assert runs.read_run(run.folder).status == runs.DONE
    assert (bench / "results" / "measured" / "summary.csv").is_file()
    with pytest.raises(Refused):
        runs.enqueue(bench, "rm", (), folder)


def test_a_diagnosis_is_left_in_the_bench_and_is_no_recording_of_it(tmp_path):
    """A run of the page writes below the bench: the command takes the folder, and finds
    no recordings in it the next time."""
    bench, folder = tmp_path / "bench", Folder(tmp_path)
    shutil.copytree(Path(__file__).parents[2] / "samples" / "heard-drop", bench)
    run = runs.enqueue(bench, "diagnose", ("--quick",), folder)
    until(
        lambda: runs.read_run(run.folder).status not in (runs.RUNNING, runs.WAITING),
        120,
    )
    assert runs.read_run(run.folder).status == runs.DONE, runs.read_run(run.folder).log
    left = bench / "results" / "diagnosed"
    assert (left / "report.html").is_file()
    shutil.copytree(bench / "drop-01", left / "twin" / "drop-01-old")
    assert [r.path.parent for r in find_recordings(bench)] == [bench] * 3
    assert not any(name.startswith("results") for name in hashes(bench))
