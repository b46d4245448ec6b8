"""Queue of command runs on a bench, one at a time: start, follow, stop, resume.

A run is a folder, BENCH/results/runs/0003-calibrate, with job.json, state.json and
log.txt. They say what was asked for and how it went, never what to execute: the command
line is made by `command_line`, and a run starts or goes on by itself only where
job.json is signed by this user on this machine for this very folder. That a command
runs is known from a lock that it holds, not from a file of the bench."""

import fcntl
import hmac
import json
import os
import re
import secrets
import subprocess
import sys
import time
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, FiniteFloat, ValidationError, model_validator

from benchtwin.bench.whole_file import write_whole
from benchtwin.page.folder import (
    RESULTS,
    RUNS,
    Folder,
    Refused,
    read_json,
    real_folder,
    remove,
)
from benchtwin.page.private import (
    lock_file,
    lock_name,
    locked,
    open_lock,
    private_folder,
    signature,
)

COMMANDS = {  # what may run: its folder of results, and the options that it may have
    "measure": ("measured", ()),
    "calibrate": ("calibrated", ("--quick",)),
    "diagnose": ("diagnosed", ("--quick",)),
}
WAITING = "waiting"
RUNNING = "running"
DONE = "done"
FAILED = "failed"
STOPPED = "stopped"
BROKEN = "broken off"
# on another machine, or in the folder this was copied from
ELSEWHERE = "asked for elsewhere"
UNREADABLE = "cannot be read"
# -P: nothing is imported from the folder that somebody stands in
PYTHON = (sys.executable, "-P", "-m")
RUNNER = (*PYTHON, "benchtwin.page.runner")
NAME = re.compile(r"(\d{4,9})-\S+", re.ASCII)
SHOWN_LOG = 20_000  # bytes, from its end
SHOWN_PROGRESS = 300  # characters


class Job(BaseModel):
    """What job.json says. launched: when [s since 1970], 0 if not yet."""

    command: Literal["measure", "calibrate", "diagnose"]
    options: tuple[Literal["--quick"], ...] = ()
    launched: FiniteFloat = 0.0
    stopped: bool = False
    signature: str = ""

    @model_validator(mode="after")
    def offered(self) -> "Job":
        """ValueError for options that its command does not have."""
        allowed = COMMANDS[self.command][1]
        if sorted({*self.options} & {*allowed}) != sorted(self.options):
            raise ValueError(f"{self.command} has no {' '.join(self.options)}")
        return self


class State(BaseModel):
    """What state.json says. code: the command's exit code, None until it has ended."""

    started: FiniteFloat = 0.0
    progress: str = ""
    code: int | None = None
    ended: FiniteFloat | None = None


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


def all_runs(bench: Path, folder: Folder) -> list[Run]:
    """The bench's runs, the newest first."""
    with _queue(bench):
        current = _current(bench)
        return [_read(p, current) for p in _places(bench, folder)][::-1]


def read_job(place: Path) -> Job | None:
    """What a run's job.json asks for; None where that is nothing a page asks for."""
    try:
        return Job.model_validate(read_json(place / "job.json"))
    except ValidationError:
        return None


def is_ours(job: Job, place: Path) -> bool:
    """Whether this user asked for the run on this machine, and in this very folder."""
    signed = signature(_signed_content(job, place, place))
    return hmac.compare_digest(signed.encode(), job.signature.encode())


def command_line(job: Job, bench: Path) -> list[str]:
    """What runs: a command of benchtwin on the bench that is open."""
    out = bench / RESULTS / COMMANDS[job.command][0]
    where = [str(bench), "--out", str(out), "--overwrite"]
    return [*PYTHON, "benchtwin", job.command, *where, *job.options]


def enqueue(bench: Path, command: str, options: tuple[str, ...], folder: Folder) -> Run:
    """Put a run into the bench's queue, and start it if nothing else runs there. The
    run's folder appears whole or not at all."""
    try:
        job = Job.model_validate({"command": command, "options": options})
    except ValidationError:
        what = " ".join((command, *options))
        raise Refused(f"{what}: not a command for a bench") from None
    folder.refuse_links(bench)
    with _queue(bench):
        runs = real_folder(folder.results(bench) / RUNS)
        for left in runs.glob(".part-*"):  # by a page that was killed here
            remove(left)
        place = runs / f"{_next_number(runs):04d}-{command}"
        part = runs / f".part-{secrets.token_hex(8)}"
        try:
            part.mkdir()
            _write(job, part, place)
            part.rename(place)
        finally:
            remove(part)
        _advance(bench, folder)
        return _read(place, _current(bench))


def stop(run: Run) -> None:
    """Have a running command interrupted (it stops where it can go on), or take a
    waiting one from the queue. Its runner looks for this in job.json."""
    with _queue(run.folder.parents[2]):
        job = read_job(run.folder)
        if job is None or not is_ours(job, run.folder):
            raise Refused("this run was not started here")
        _write(job.model_copy(update={"stopped": True}), run.folder, run.folder)


def resume(run: Run, bench: Path, folder: Folder) -> None:
    """Run the same command again; what it had finished it finds. One that was asked for
    elsewhere is asked for anew."""
    job = read_job(run.folder)
    if job is None:
        raise Refused(f"{run.folder.name}: its job.json names no command for a bench")
    if not is_ours(job, run.folder):
        enqueue(bench, job.command, job.options, folder)
        return
    folder.refuse_links(bench)
    with _queue(bench):
        if _read(run.folder, _current(bench)).status in (RUNNING, WAITING):
            return
        again = job.model_copy(update={"launched": 0.0, "stopped": False})
        _write(again, run.folder, run.folder)
        (run.folder / "state.json").unlink(missing_ok=True)
        _advance(bench, folder)


def ended(bench: Path, folder: Folder, lock: int) -> None:
    """A runner's command has ended: give its lock back, and start what waits."""
    with _queue(bench):
        os.close(lock)
        _advance(bench, folder)


def _queue(bench: Path) -> AbstractContextManager[None]:
    """Pages and runners that ask at once wait for each other."""
    return locked(lock_name(bench, "queue"))


def _advance(bench: Path, folder: Folder) -> None:
    """Start the oldest waiting run of the bench if none is running, with the queue
    held. The runner inherits the lock that shows that it
    runs, and with it the command."""
    lock = open_lock(lock_name(bench, "run"), fcntl.LOCK_EX | fcntl.LOCK_NB)
    if lock is None:
        return
    try:
        for place in _places(bench, folder):
            job = read_job(place)
            if job and is_ours(job, place) and not (job.launched or job.stopped):
                _launch(job, place, folder, lock)
                return
    finally:
        os.close(lock)


def _launch(job: Job, place: Path, folder: Folder, lock: int) -> None:
    (place / "state.json").unlink(missing_ok=True)
    _write(job.model_copy(update={"launched": time.time()}), place, place)
    os.ftruncate(lock, 0)
    os.pwrite(lock, place.name.encode(), 0)
    subprocess.Popen(
        [*RUNNER, str(folder.root.absolute()), str(place.absolute()), str(lock)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        cwd=private_folder(),
        start_new_session=True,
        pass_fds=[lock],
    )


def _current(bench: Path) -> str | None:
    """The name of the run that holds the bench's lock, None where none does."""
    name = lock_name(bench, "run")
    lock = open_lock(name, fcntl.LOCK_EX | fcntl.LOCK_NB)
    if lock is None:
        return lock_file(name).read_text(encoding="utf8")
    os.close(lock)
    return None


def _read(place: Path, current: str | None) -> Run:
    job = read_job(place)
    try:
        state = State.model_validate(read_json(place / "state.json"))
    except ValidationError:
        state = State()
    log, status = _end_of(place / "log.txt"), _status(place, job, state, current)
    if job is None:
        return Run(place, place.name.partition("-")[2], (), status, "", log, 0.0)
    began = state.started or job.launched
    took = (state.ended or time.time()) - began if began else 0.0
    progress = state.progress[:SHOWN_PROGRESS]
    return Run(place, job.command, job.options, status, progress, log, took)


def _status(place: Path, job: Job | None, state: State, current: str | None) -> str:
    if job is None:
        return UNREADABLE
    if state.code == 0:
        return DONE
    if not is_ours(job, place):
        return ELSEWHERE
    if state.code is not None:
        return STOPPED if job.stopped else FAILED
    if job.launched and current == place.name:
        return RUNNING
    if job.stopped:
        return STOPPED
    return BROKEN if job.launched or current is None else WAITING


def _end_of(log: Path) -> str:
    """The last SHOWN_LOG bytes of a log, a link's never."""
    if log.is_symlink() or not log.is_file():
        return ""
    with log.open("rb") as file:
        file.seek(max(0, log.stat().st_size - SHOWN_LOG))
        return file.read(SHOWN_LOG).decode("utf8", "replace")


def _places(bench: Path, folder: Folder) -> list[Path]:
    """The folders of the bench's runs, the oldest first."""
    runs = folder.results(bench) / RUNS
    if runs.is_symlink() or not runs.is_dir():
        return []
    found = [
        p
        for p in runs.iterdir()
        if NAME.fullmatch(p.name) and p.is_dir() and not p.is_symlink()
    ]
    return sorted(found, key=lambda p: (int(p.name.split("-")[0]), p.name))


def _next_number(runs: Path) -> int:
    """After the last; whatever has a number, a run or not, keeps it."""
    taken = {int(m[1]) for p in runs.iterdir() if (m := NAME.fullmatch(p.name))}
    number = max((n for n in taken if n < 10**8), default=0) + 1
    while number in taken:
        number += 1
    return number


def _write(job: Job, where: Path, place: Path) -> None:
    """Write job.json into `where`, signed for `place`, to which it may be moved."""
    signed = signature(_signed_content(job, where, place))
    told = job.model_copy(update={"signature": signed}).model_dump(mode="json")
    write_whole(where / "job.json", json.dumps(told))


def _signed_content(job: Job, where: Path, place: Path) -> list:
    """All of the job, and the folder that it stands in: its path, which a copy has not,
    and its number on the disk, which what is unpacked there has not."""
    told = job.model_dump(mode="json", exclude={"signature"})
    return [told, str(place.parent.resolve() / place.name), where.stat().st_ino]
