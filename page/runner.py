"""One run of a command, in a process that outlives the page.

    python -m benchtwin.page.runner ROOT FOLDER LOCK

ROOT is the folder that the page is open on; FOLDER the run's, whose job.json says which
command; LOCK the number of the open lock that this process inherits. Beside job.json
this keeps log.txt (what the command printed) and state.json (its last line of progress,
its exit code). The command runs on a terminal of its own, so that it shows its progress
as to a person. Where job.json says that it is to stop, and at SIGINT and SIGTERM, the
command is interrupted, and stops where it can go on. When it has ended, the next run in
the queue is started."""

import json
import os
import pty
import re
import select
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from benchtwin.bench.whole_file import write_whole
from benchtwin.page import runs
from benchtwin.page.folder import Folder, Refused

SPINNER = r"[\u2800-\u28ff] ?"  # what turns while something runs
CONTROLS = re.compile(
    rf"\x1b\[[0-9;?]*[A-Za-z]|\x1b\][^\x07]*\x07|[\x00-\x08\x0b-\x1f]|{SPINNER}"
)
BARS = re.compile(r"[━╸╺─]{4,}")
EVERY_S = 0.3  # state.json is written, and job.json looked at, at most so often
AGAIN_S = 15.0  # a command that has not stopped is interrupted again after that
WIDTH = "160"
MISUSED = 2


def main(root: Path, place: Path, lock: int) -> int:
    """Run what job.json asks for; returns the command's exit code."""
    folder, bench = Folder(root), place.parents[2]
    job, log = runs.read_job(place), Log(place)
    try:
        if job is None or not runs.is_ours(job, place):
            raise Refused("this run was not asked for here")
        folder.refuse_links(bench)
        code = _run(runs.command_line(job, bench), place, log, lock)
    except Refused as error:
        code = MISUSED
        log.add(f"{error}\n")
    log.finish(code)
    if bench.is_dir():
        runs.ended(bench, folder, lock)
    return code


def _run(command: list[str], place: Path, log: "Log", lock: int) -> int:
    terminal, its_end = pty.openpty()
    environment = {
        **os.environ,
        "TERM": "xterm",
        "COLUMNS": WIDTH,
        "LINES": "50",
        "NO_COLOR": "1",
    }
    child = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=its_end,
        stderr=its_end,
        env=environment,
        start_new_session=True,
        pass_fds=[lock],  # as long as the command works, nothing else begins
    )
    os.close(its_end)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: child.send_signal(signal.SIGINT))
    interrupted = 0.0
    for text in _output(terminal):
        if log.add(text) and time.time() - interrupted > AGAIN_S and _is_stopped(place):
            child.send_signal(signal.SIGINT)
            interrupted = time.time()
    return child.wait()


def _is_stopped(place: Path) -> bool:
    job = runs.read_job(place)
    return job is not None and job.stopped and runs.is_ours(job, place)


class Log:
    """log.txt and state.json: when it began, the last line of progress, when it ended
    and how. A disk that is full does not end the command."""

    def __init__(self, place: Path):
        self.place = place
        self.content: dict = {
            "started": time.time(),
            "progress": "",
            "code": None,
            "ended": None,
        }
        self.written, self.rest = 0.0, ""

    def add(self, text: str) -> bool:
        """Whole lines go into the log; a line that the terminal overwrites is progress.
        Returns whether state.json was due, and so written."""
        *lines, self.rest = (self.rest + text).split("\n")
        kept = ""
        for line in lines:
            last = CONTROLS.sub("", line.rstrip("\r").rpartition("\r")[2]).rstrip()
            if last and not BARS.search(last):
                kept += last + "\n"
            elif last:
                self.content["progress"] = BARS.sub(" ", last)
        if shown := CONTROLS.sub(
            "", self.rest.rstrip("\r").rpartition("\r")[2]
        ).strip():
            self.content["progress"] = re.sub(r"\s{2,}", "  ", BARS.sub(" ", shown))
        with (
            suppress(OSError),
            (self.place / "log.txt").open("a", encoding="utf8") as log,
        ):
            log.write(kept)
        due = time.time() - self.written > EVERY_S
        if due:
            self._write()
        return due

    def finish(self, code: int) -> None:
        self.content |= {"code": code, "ended": time.time(), "progress": ""}
        self._write()

    def _write(self) -> None:
        with suppress(OSError):
            write_whole(self.place / "state.json", json.dumps(self.content))
        self.written = time.time()


def _output(terminal: int) -> Iterator[str]:
    """What the command prints, until it has ended; now and then nothing."""
    while True:
        ready, _, _ = select.select([terminal], [], [], EVERY_S)
        if not ready:
            yield ""
            continue
        try:
            data = os.read(terminal, 65536)
        except OSError:  # the other end is closed: the command has ended
            return
        if not data:
            return
        yield data.decode("utf8", "replace")


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3])))
