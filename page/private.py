"""What the page keeps outside every bench, in a folder that only its user can read: the
secret that signs runs, and locks.

A bench may come from anybody; what stands here was done on this machine by this
user."""

import fcntl
import hmac
import json
import os
import secrets
import socket
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

SECRET_BYTES = 32


def private_folder() -> Path:
    """$XDG_STATE_HOME/benchtwin, by default ~/.local/state/benchtwin, made if need
    be."""
    state = os.environ.get("XDG_STATE_HOME") or "~/.local/state"
    folder = Path(state).expanduser() / "benchtwin"
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    return folder


def signature(content: Any) -> str:
    """What only this user on this machine can write beside `content`:
    HMAC-SHA256(secret, content, host), in hexadecimal digits."""
    text = json.dumps([content, socket.gethostname()], sort_keys=True)
    return hmac.digest(_secret(), text.encode(), "sha256").hex()


def _secret() -> bytes:
    """The secret, made when it is not there or others could have read or changed it."""
    file = private_folder() / "secret"
    if _is_ours_alone(file):
        return file.read_bytes()
    with locked("secret"):
        if not _is_ours_alone(file):
            part = file.with_name(f".secret.{secrets.token_hex(8)}")
            part.touch(0o600, exist_ok=False)
            part.write_bytes(secrets.token_bytes(SECRET_BYTES))
            part.replace(file)
        return file.read_bytes()


def _is_ours_alone(file: Path) -> bool:
    try:
        found = file.lstat()
    except FileNotFoundError:
        return False
    return (
        stat.S_ISREG(found.st_mode)
        and found.st_uid == os.getuid()
        and not found.st_mode & 0o077
        and found.st_size == SECRET_BYTES
    )


def lock_name(folder: Path, use: str) -> str:
    """A lock's name by the folder itself: it stays when the folder is moved, a copy has
    another."""
    found = folder.stat()
    return f"{found.st_dev}-{found.st_ino}.{use}"


def lock_file(name: str) -> Path:
    """Where a lock's file lies."""
    folder = private_folder() / "locks"
    folder.mkdir(exist_ok=True, mode=0o700)
    return folder / name


def open_lock(name: str, how: int) -> int | None:
    """The lock's open file, held until it and what inherited it is closed; None where
    it is held elsewhere. how: fcntl.LOCK_…; without LOCK_NB it is waited for."""
    handle = os.open(lock_file(name), os.O_CREAT | os.O_RDWR, 0o600)
    try:
        fcntl.flock(handle, how)
    except OSError as error:
        os.close(handle)
        if isinstance(error, BlockingIOError):
            return None
        raise
    return handle


@contextmanager
def locked(name: str) -> Iterator[None]:
    """Hold a lock for the length of a block."""
    handle = open_lock(name, fcntl.LOCK_EX)
    assert handle is not None  # it was waited for
    try:
        yield
    finally:
        os.close(handle)


def take_part(name: str, alone: Callable[[], None]) -> None:
    """Count as one of the processes that use `name` until this process ends; `alone` is
    called first where there is no other."""
    handle = os.open(lock_file(name), os.O_CREAT | os.O_RDWR, 0o600)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        alone()
    except BlockingIOError:
        pass
    fcntl.flock(handle, fcntl.LOCK_SH)
