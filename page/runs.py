"""Queue of command runs on a bench, one at a time: start, follow, stop, resume.

A run is a folder, BENCH/results/runs/0003-calibrate, with job.json, state.json and
log.txt. All that is known of it stands there, so that a page opened later finds it as
it is."""

import fcntl
import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from benchtwin.page.folder import Folder, Refused, read_json, write_whole

COMMANDS = ("measure", "calibrate", "diagnose")
RESULT_FOLDERS = {
    "measure": "measured",
    "calibrate": "calibrated",
    "diagnose": "diagnosed",
}
WAITING, RUNNING, DONE, FAILED, STOPPED, BROKEN = (
    "waiting",
    "running",
    "done",
    "failed",
    "stopped",
    "broken off",
)
STARTS_WITHIN_S = 20.0  # a run that was started and has no state after that never began


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
    place = folder.results(bench) / "runs"
    return [
        read_run(p)
        for p in sorted(place.glob("[0-9]*-*"), reverse=True)
        if (p / "job.json").is_file()
    ]


def read_run(place: Path) -> Run:
    """A run's folder as it stands."""
    job = read_json(place / "job.json")
    state = read_json(place / "state.json")
    log = place / "log.txt"
    text = (
        log.read_text(encoding="utf8", errors="replace")[-20_000:]
        if log.is_file()
        else ""
    )
    began = state.get("started") or job.get("launched") or 0.0
    took = (state.get("ended") or time.time()) - began if began else 0.0
    return Run(
        place,
        job["command"],
        tuple(job["options"]),
        _status(job, state),
        state.get("progress", ""),
        text,
        took,
    )


def enqueue(bench: Path, command: str, options: tuple[str, ...], folder: Folder) -> Run:
    """Put a run into the bench's queue, and start it if nothing else runs there."""
    if command not in COMMANDS:
        raise Refused(f"{command}: not a command for a bench")
    runs = folder.results(bench) / "runs"
    runs.mkdir(exist_ok=True)
    number = (
        max(
            (
                read_run(p).number
                for p in runs.glob("[0-9]*-*")
                if (p / "job.json").is_file()
            ),
            default=0,
        )
        + 1
    )
    place = runs / f"{number:04d}-{command}"
    place.mkdir()
    out = folder.results(bench) / RESULT_FOLDERS[command]
    arguments = [
        sys.executable,
        "-m",
        "benchtwin",
        command,
        str(bench),
        "--out",
        str(out),
        "--overwrite",
        *options,
    ]
    write_whole(
        place / "job.json",
        json.dumps(
            {"command": command, "options": options, "arguments": arguments}
        ).encode(),
    )
    advance(bench, folder)
    return read_run(place)


def advance(bench: Path, folder: Folder) -> None:
    """Start the oldest waiting run of the bench if none is running. A page and a run
    that ends may both ask at once: one does it."""
    with (folder.results(bench) / ".queue").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        runs = all_runs(bench, folder)
        if any(r.status == RUNNING for r in runs):
            return
        if waiting := [r for r in runs if r.status == WAITING]:
            _launch(waiting[-1].folder)


def stop(run: Run) -> None:
    """Interrupt a running command (it stops where it can go on), or take a waiting one
    from the queue."""
    job = read_json(run.folder / "job.json")
    write_whole(run.folder / "job.json", json.dumps({**job, "stopped": True}).encode())
    if run.status == RUNNING and (
        pid := read_json(run.folder / "state.json").get("pid")
    ):
        os.kill(pid, signal.SIGINT)


def resume(run: Run, bench: Path, folder: Folder) -> None:
    """Run the same command again; what it had finished it finds."""
    job = read_json(run.folder / "job.json")
    for gone in ("stopped", "launched"):
        job.pop(gone, None)
    (run.folder / "state.json").unlink(missing_ok=True)
    write_whole(run.folder / "job.json", json.dumps(job).encode())
    advance(bench, folder)


def _launch(place: Path) -> None:
    job = read_json(place / "job.json")
    write_whole(
        place / "job.json", json.dumps({**job, "launched": time.time()}).encode()
    )
    (place / "state.json").unlink(missing_ok=True)
    subprocess.Popen(
        [sys.executable, "-m", "benchtwin.page.runner", str(place)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def _status(job: dict, state: dict) -> str:
    if not state:
        if job.get("stopped"):
            return STOPPED
        if "launched" not in job:
            return WAITING
        return RUNNING if time.time() - job["launched"] < STARTS_WITHIN_S else BROKEN
    if state["code"] is None:
        return RUNNING if _is_alive(state["pid"], state["started"]) else BROKEN
    if state["code"] == 0:
        return DONE
    return STOPPED if job.get("stopped") else FAILED


def _is_alive(pid: int, started: float) -> bool:
    """Whether the runner is still there; another process may have got its number
    since."""
    import psutil

    try:
        process = psutil.Process(pid)
        return (
            process.status() != psutil.STATUS_ZOMBIE
            and process.create_time() < started + 5
        )
    except psutil.Error:
        return False
