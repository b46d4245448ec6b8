"""Runs of commands on a bench, one at a time: started, followed, stopped, resumed.

A run is a folder, 0003-calibrate, with job.json, state.json and log.txt. It lies with
the page's private things, not in the bench: nothing that a bench holds starts anything,
or says how a run went. Each run has a process of its own (`runner.py`), which holds the
run's lock as long as it lives, waits for its turn and runs the command; what nobody
holds has ended, or was cut off."""

import hashlib
import os
import re
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ValidationError, model_validator

from benchtwin.bench.language import tr
from benchtwin.bench.whole_file import new_folder
from benchtwin.page.folder import (
    CALIBRATED,
    DIAGNOSED,
    MEASURED,
    RESULTS,
    Folder,
    Refused,
)
from benchtwin.page.private import locked, open_lock, private_folder

COMMANDS = {  # what may run: its folder of results, and the options that it may have
    "measure": (MEASURED, ()),
    "calibrate": (CALIBRATED, ("--quick",)),
    "diagnose": (DIAGNOSED, ("--quick",)),
}
WAITING, RUNNING = "waiting", "running"
DONE, FAILED, STOPPED, BROKEN = "done", "failed", "stopped", "broken off"
# -P: nothing is imported from the folder that somebody stands in
PYTHON = (sys.executable, "-P", "-m")
RUNNER = (*PYTHON, "benchtwin.page.runner")
NAME = re.compile(r"(\d{4,9})-\w+", re.ASCII)
SHOWN_LOG = 20_000  # bytes, from its end


class Job(BaseModel):
    """What job.json says."""

    command: Literal["measure", "calibrate", "diagnose"]
    options: tuple[Literal["--quick"], ...] = ()

    @model_validator(mode="after")
    def offered(self) -> "Job":
        """ValueError for options that its command does not have."""
        allowed = COMMANDS[self.command][1]
        if sorted({*self.options} & {*allowed}) != sorted(self.options):
            raise ValueError(tr("{} has no {}", self.command, " ".join(self.options)))
        return self


class State(BaseModel):
    """What state.json says. started: when the command began, ended: when it ended [s
    since 1970]; code: its exit code; progress: its last line of progress."""

    started: float = 0.0
    progress: str = ""
    code: int | None = None
    ended: float | None = None


@dataclass(frozen=True)
class Run:
    """One run as its folder has it. progress: the command's last line of progress; log:
    all else that it printed."""

    folder: Path
    command: str
    options: tuple[str, ...]
    status: str
    progress: str
    log: str
    took_s: float

    @property
    def number(self) -> int:
        return int(self.folder.name.split("-")[0])


def runs_of(bench: Path) -> Path:
    """The folder in which the runs of the bench at this path are kept."""
    path = os.fsencode(bench.resolve())
    folder = private_folder() / "runs" / hashlib.sha256(path).hexdigest()[:32]
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def all_runs(bench: Path) -> list[Run]:
    """The bench's runs, the newest first."""
    runs = runs_of(bench)
    with locked(runs / "reading"):
        return [_read(place) for place in _places(runs)][::-1]


def command_line(job: Job, bench: Path) -> list[str]:
    """What runs: a command of benchtwin on the bench."""
    out = bench / RESULTS / COMMANDS[job.command][0]
    where = [str(bench), "--out", str(out), "--overwrite"]
    return [*PYTHON, "benchtwin", job.command, *where, *job.options]


def read_job(place: Path) -> Job:
    """What a run's job.json asks for."""
    return Job.model_validate_json((place / "job.json").read_bytes())


def enqueue(bench: Path, command: str, options: tuple[str, ...], folder: Folder) -> Run:
    """Have a command run on the bench, when those before it have ended. The run's
    folder appears whole or not at all."""
    try:
        job = Job.model_validate({"command": command, "options": options})
    except ValidationError:
        what = " ".join((command, *options))
        raise Refused(tr("{}: not a command for a bench", what)) from None
    folder.refuse_links(bench)
    folder.results(bench)
    runs = runs_of(bench)
    with locked(runs / "reading"):
        number = max((int(p.name.split("-")[0]) for p in _places(runs)), default=0) + 1
        place = runs / f"{number:04d}-{command}"
        with new_folder(place) as part:
            (part / "job.json").write_text(job.model_dump_json(), encoding="utf8")
        _start(place, bench, folder)
        return _read(place)


def stop(run: Run) -> None:
    """Have a running command interrupted (it stops where it can go on), or a waiting
    one not begun. Its runner looks for this."""
    (run.folder / "stop").touch()


def is_stopped(place: Path) -> bool:
    """Whether a run is to stop."""
    return (place / "stop").exists()


def resume(run: Run, bench: Path, folder: Folder) -> None:
    """Run the same command again; what it had finished it finds."""
    folder.refuse_links(bench)
    with locked(runs_of(bench) / "reading"):
        _start(run.folder, bench, folder)


def wait_for_turn(bench: Path, place: Path, every_s: float) -> int | None:
    """The open lock under which one run of a bench works at a time, in their order;
    None where this one was stopped before."""
    while not is_stopped(place):
        *_, first = [r.folder for r in all_runs(bench) if r.status == WAITING]
        turn = open_lock(place.parent / "turn") if first == place else None
        if turn is not None:
            return turn
        time.sleep(every_s)
    return None


def _start(place: Path, bench: Path, folder: Folder) -> None:
    """Start the runner, which inherits the lock that shows that it is there, and with
    it the command."""
    lock = open_lock(place / "lock")
    if lock is None:  # it works, or waits
        return
    try:
        for name in ("stop", "state.json"):
            (place / name).unlink(missing_ok=True)
        subprocess.Popen(
            [*RUNNER, *map(str, (folder.root.absolute(), bench, place, lock))],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            cwd=place,
            start_new_session=True,
            pass_fds=[lock],
        )
    finally:
        os.close(lock)


def _read(place: Path) -> Run:
    job, log, file = read_job(place), place / "log.txt", place / "state.json"
    state = State.model_validate_json(file.read_bytes()) if file.exists() else State()
    took = (state.ended or time.time()) - state.started if state.started else 0.0
    data = log.read_bytes() if log.exists() else b""
    printed = data[-SHOWN_LOG:].decode("utf8", "replace")
    status = _status(place, state)
    return Run(place, job.command, job.options, status, state.progress, printed, took)


def _status(place: Path, state: State) -> str:
    lock = open_lock(place / "lock")
    if lock is None:
        return RUNNING if state.started else WAITING
    os.close(lock)
    if state.code == 0:
        return DONE
    if is_stopped(place):
        return STOPPED
    return BROKEN if state.code is None else FAILED


def _places(runs: Path) -> list[Path]:
    """The folders of the bench's runs, the oldest first."""
    found = (p for p in runs.iterdir() if NAME.fullmatch(p.name))
    return sorted(found, key=lambda p: int(p.name.split("-")[0]))
