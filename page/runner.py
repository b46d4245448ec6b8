"""One run of a command, in a process that outlives the page.

    python -m benchtwin.page.runner FOLDER

FOLDER/job.json says what to run; beside it this keeps log.txt (what the command
printed) and state.json (its last line of progress, its exit code). The command runs on
a terminal of its own, so that it shows its progress as to a person. An interrupt
(SIGINT, SIGTERM) is handed to the command, which stops where it can go on. When it has
ended, the next run in the queue is started."""

import json
import os
import pty
import re
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

from benchtwin.page.folder import Folder, write_whole
from benchtwin.page.runs import advance

SPINNER = r"[\u2800-\u28ff] ?"  # what turns while something runs
CONTROLS = re.compile(
    rf"\x1b\[[0-9;?]*[A-Za-z]|\x1b\][^\x07]*\x07|[\x00-\x08\x0b-\x1f]|{SPINNER}"
)
BARS = re.compile(r"[━╸╺─]{4,}")
EVERY_S = 0.3  # state.json is written at most so often
WIDTH = "160"


def main(folder: Path) -> int:
    """Run what job.json says; returns the command's exit code."""
    arguments = json.loads((folder / "job.json").read_text(encoding="utf8"))[
        "arguments"
    ]
    terminal, its_end = pty.openpty()
    environment = {
        **os.environ,
        "TERM": "xterm",
        "COLUMNS": WIDTH,
        "LINES": "50",
        "NO_COLOR": "1",
    }
    child = subprocess.Popen(
        arguments,
        stdin=subprocess.DEVNULL,
        stdout=its_end,
        stderr=its_end,
        env=environment,
        start_new_session=True,
    )
    os.close(its_end)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: child.send_signal(signal.SIGINT))
    state = State(folder, child.pid)
    state.write()
    with (folder / "log.txt").open("a", encoding="utf8") as log:
        for text in _output(terminal):
            state.add(text, log)
    code = child.wait()
    state.finish(code)
    if (bench := folder.parents[2]).is_dir():
        advance(
            bench, Folder(bench)
        )  # what waits is not to wait for a page to be opened
    return code


class State:
    """What state.json says: pid, when it began, the last line of progress, when it
    ended and how."""

    def __init__(self, folder: Path, child: int):
        self.file = folder / "state.json"
        self.content: dict = {
            "pid": os.getpid(),
            "child": child,
            "started": time.time(),
            "progress": "",
            "code": None,
            "ended": None,
        }
        self.written, self.rest = 0.0, ""

    def add(self, text: str, log) -> None:
        """Whole lines go into the log; a line that the terminal overwrites is
        progress."""
        *lines, self.rest = (self.rest + text).split("\n")
        for line in lines:
            last = CONTROLS.sub("", line.rstrip("\r").rpartition("\r")[2]).rstrip()
            if last and not BARS.search(last):
                log.write(last + "\n")
            elif last:
                self.content["progress"] = BARS.sub(" ", last)
        if shown := CONTROLS.sub(
            "", self.rest.rstrip("\r").rpartition("\r")[2]
        ).strip():
            self.content["progress"] = re.sub(r"\s{2,}", "  ", BARS.sub(" ", shown))
        log.flush()
        if time.time() - self.written > EVERY_S:
            self.write()

    def finish(self, code: int) -> None:
        self.content |= {"code": code, "ended": time.time(), "progress": ""}
        self.write()

    def write(self) -> None:
        write_whole(self.file, json.dumps(self.content).encode())
        self.written = time.time()


def _output(terminal: int):
    """What the command prints, until it has ended."""
    while True:
        ready, _, _ = select.select([terminal], [], [], 1.0)
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
    sys.exit(main(Path(sys.argv[1])))
