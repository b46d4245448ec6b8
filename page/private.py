"""What the page keeps outside every bench, in a folder of its user's alone: runs with
their logs, and locks.

A bench may come from anybody; what stands here was done on this machine by this
user."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from benchtwin.bench.whole_file import own_folder


def private_folder() -> Path:
    """$XDG_STATE_HOME/benchtwin, by default ~/.local/state/benchtwin, made if need be.
    PermissionError where others may write to it."""
    state = os.environ.get("XDG_STATE_HOME") or "~/.local/state"
    return own_folder(Path(state).expanduser() / "benchtwin")


def open_lock(file: Path) -> int | None:
    """The lock's open file, held until it and what inherited it is closed; None where
    it is held elsewhere."""
    handle = os.open(file, os.O_CREAT | os.O_RDWR, 0o600)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        os.close(handle)
        if isinstance(error, BlockingIOError):
            return None
        raise
    return handle


@contextmanager
def locked(file: Path) -> Iterator[None]:
    """Hold a lock for the length of a block; it is waited for."""
    with file.open("a") as handle:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield
