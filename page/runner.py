"""One run of a command, in a process that outlives the page.

    python -m benchtwin.page.runner ROOT BENCH FOLDER LOCK

ROOT is the folder that the page is open on; FOLDER the run's, whose job.json says which
command; LOCK the number of the open lock that this process inherits. It waits until the
runs before it have ended. Beside job.json it keeps log.txt (what the command printed)
and state.json (its last line of progress, its exit code). The command runs on a
terminal of its own, so that it shows its progress as to a person. Where the run is to
stop, and at SIGINT and SIGTERM, the command is interrupted, and stops where it can go
on."""

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
EVERY_S = 0.3  # state.json is written, and looked whether to stop, so often
AGAIN_S = 15.0  # a command that has not stopped is interrupted again after that
WIDTH = "160"
MISUSED = 2


def main(root: Path, bench: Path, place: Path, lock: int) -> int:
    """Run what job.json asks for; returns the command's exit code."""
    turn = runs.wait_for_turn(bench, place, EVERY_S)
    if turn is None:
        return 0
    log = Log(place)
    try:
        Folder(root).refuse_links(bench)
        command = runs.command_line(runs.read_job(place), bench)
        # as long as the command works, nothing else begins
        code = _run(command, place, log, [lock, turn])
    except Refused as error:
        code = MISUSED
        log.add(f"{error}\n")
    log.finish(code)
    return code


def _run(command: list[str], place: Path, log: "Log", locks: list[int]) -> int:
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
        pass_fds=locks,
    )
    os.close(its_end)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: child.send_signal(signal.SIGINT))
    interrupted = 0.0
    for text in _output(terminal):
        log.add(text)
        if runs.is_stopped(place) and time.time() - interrupted > AGAIN_S:
            child.send_signal(signal.SIGINT)
            interrupted = time.time()
    return child.wait()


class Log:
    """log.txt and state.json: when it began, the last line of progress, when it ended
    and how. A disk that is full does not end the command."""

    def __init__(self, place: Path):
        self.place, self.state = place, runs.State(started=time.time())
        self.written, self.rest = 0.0, ""
        self._write()

    def add(self, text: str) -> None:
        """Whole lines go into the log; a line that the terminal overwrites is
        progress."""
        *lines, self.rest = (self.rest + text).split("\n")
        kept = ""
        for line in map(_last_shown, lines):
            if line and not BARS.search(line):
                kept += line + "\n"
            elif line:
                self.state.progress = BARS.sub(" ", line)
        if shown := _last_shown(self.rest).strip():
            self.state.progress = re.sub(r"\s{2,}", "  ", BARS.sub(" ", shown))
        with (
            suppress(OSError),
            (self.place / "log.txt").open("a", encoding="utf8") as log,
        ):
            log.write(kept)
        if time.time() - self.written > EVERY_S:
            self._write()

    def finish(self, code: int) -> None:
        """The command has ended."""
        self.state.code, self.state.ended, self.state.progress = code, time.time(), ""
        self._write()

    def _write(self) -> None:
        with suppress(OSError):
            write_whole(self.place / "state.json", self.state.model_dump_json())
        self.written = time.time()


def _last_shown(line: str) -> str:
    """What a terminal shows of a line that was overwritten."""
    return CONTROLS.sub("", line.rstrip("\r").rpartition("\r")[2]).rstrip()


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
    root, bench, place = map(Path, sys.argv[1:4])
    sys.exit(main(root, bench, place, int(sys.argv[4])))
