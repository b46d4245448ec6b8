"""Who computes what: a claim file a key, with its owner and a heartbeat, so that no two
processes compute one job.

Claims are named KEY.0, KEY.1, …: the highest number counts. Making a file that must not
be there yet is the one operation that every file system does for one of two askers
only; so a claim whose owner has died is not replaced but outnumbered."""

import json
import os
import secrets
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path

BEAT_S = 5.0
# twelve missed beats: a busy machine or a slow network drive delays a few
STALE_S = 60.0


@dataclass(frozen=True)
class Claim:
    """key: what is claimed; number: which claim on it this is; token: names its owner's
    temporary folder."""

    folder: Path
    key: str
    number: int
    token: str

    @property
    def file(self) -> Path:
        return self.folder / f"{self.key}.{self.number}"

    def is_valid(self) -> bool:
        """Whether nobody took this for dead meanwhile and claimed the key anew."""
        return max(_numbers(self.folder, self.key), default=-1) == self.number

    def release(self) -> None:
        # the own one last: until then the key is taken
        for number in sorted(_numbers(self.folder, self.key)):
            if number <= self.number:
                (self.folder / f"{self.key}.{number}").unlink(missing_ok=True)


def take(folder: Path, key: str, *, stale_s: float = STALE_S) -> Claim | None:
    """Claim a key for this process; None when a live process has it. OSError when the
    folder cannot be written."""
    highest = max(_numbers(folder, key), default=-1)
    if highest >= 0 and is_live(folder / f"{key}.{highest}", stale_s):
        return None
    claim = Claim(folder, key, highest + 1, secrets.token_hex(8))
    try:
        handle = os.open(claim.file, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)
    except FileExistsError:  # another was quicker
        return None
    try:
        with os.fdopen(handle, "w") as file:
            json.dump({"token": claim.token, **_this_process(os.getpid())}, file)
    except OSError:
        claim.file.unlink(missing_ok=True)
        raise
    # Where dead claims are cleared away at this very moment two may get numbers of
    # their own: then both step back.
    others = [n for n in _numbers(folder, key) if n != claim.number]
    if any(is_live(folder / f"{key}.{n}", stale_s) for n in others):
        claim.file.unlink(missing_ok=True)
        return None
    return claim


@contextmanager
def beating(claim: Claim, every_s: float = BEAT_S) -> Iterator[None]:
    """Renew the claim's time stamp as long as the block runs."""
    over = threading.Event()

    def beat() -> None:
        while not over.wait(every_s):
            try:
                os.utime(claim.file)
            # taken over, or a drive that is away for a while: the job goes on,
            # publishing decides
            except OSError:
                continue

    thread = threading.Thread(target=beat, name=f"claim {claim.key}", daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()


def is_live(file: Path, stale_s: float = STALE_S) -> bool:
    """Whether a claim's owner is at work: its process lives, where that can be seen,
    and its heart beat lately."""
    try:
        age_s = clock(file.parent) - file.stat().st_mtime
        owner = _owner(file)
    except FileNotFoundError:
        return False
    if abs(age_s) > stale_s:  # a beat that is still to come was not one either
        return False
    # An owner that is just writing its name down, or that works on another machine, is
    # judged by its heartbeat alone.
    return owner.get("machine") != _machine() or _runs(owner["pid"], owner["started"])


def holder(folder: Path, key: str, *, stale_s: float = STALE_S) -> bool:
    """Whether a live process has this key."""
    highest = max(_numbers(folder, key), default=-1)
    return highest >= 0 and is_live(folder / f"{key}.{highest}", stale_s)


def live_tokens(folder: Path, *, stale_s: float = STALE_S) -> set[str]:
    """Tokens of all claims whose owners are at work."""
    tokens = set()
    for entry in os.scandir(folder):
        file = Path(entry.path)
        try:
            if not entry.name.startswith(".") and is_live(file, stale_s):
                tokens.add(_owner(file).get("token", ""))
        except OSError:
            continue
    return tokens


def remove_dead(folder: Path, *, stale_s: float = STALE_S) -> None:
    """Remove claims whose owners have died, those that were outnumbered included."""
    for entry in sorted(os.scandir(folder), key=lambda e: e.name):
        if not entry.name.startswith(".") and not is_live(Path(entry.path), stale_s):
            Path(entry.path).unlink(missing_ok=True)


def clock(folder: Path) -> float:
    """Time [s] by the clock of the drive, which stamps the heartbeats; that of this
    machine may go wrong beside it."""
    file = folder / f".clock-{os.getpid()}-{threading.get_ident()}"
    try:
        file.touch()
        return file.stat().st_mtime
    finally:
        file.unlink(missing_ok=True)


def _numbers(folder: Path, key: str) -> list[int]:
    start = f"{key}."
    names = [
        entry.name.removeprefix(start)
        for entry in os.scandir(folder)
        if entry.name.startswith(start)
    ]
    return [int(name) for name in names if name.isdigit()]


def _owner(file: Path) -> dict:
    """What a claim's owner wrote down; nothing where that is not whole."""
    try:
        told = json.loads(file.read_text(encoding="utf8"))
        kinds = {"machine": str, "pid": int, "started": float, "token": str}
        whole = all(isinstance(told[name], kind) for name, kind in kinds.items())
    except (ValueError, KeyError, TypeError):
        return {}
    return told if whole else {}


@cache
def _machine() -> str:
    """Where process numbers mean the same: this host, and of its containers this
    one."""
    try:
        return f"{socket.gethostname()} {Path('/proc/self/ns/pid').readlink()}"
    except OSError:
        return socket.gethostname()


@cache
def _this_process(pid: int) -> dict:
    import psutil

    return {
        "machine": _machine(),
        "host": socket.gethostname(),
        "pid": pid,
        "started": psutil.Process(pid).create_time(),
    }


def _runs(pid: int, started: float) -> bool:
    """Whether that very process runs: not another that was given its number later, and
    not one that awaits burial."""
    import psutil

    try:
        process = psutil.Process(pid)
        return (
            abs(process.create_time() - started) < 2.0
            and process.status() != psutil.STATUS_ZOMBIE
        )
    except psutil.Error:
        return False
