"""Files and folders that appear whole or not at all. Until then they lie beside their
place under names that nobody can guess, made new so that no link is followed; what was
left by a process that was killed is removed by the next that writes to that place."""

import os
import secrets
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

PART = ".part"
HELD_AFTER_S = 5.0  # a part that is made is held within this
LONGEST = 40  # characters of the name of what is written, in that of its part


@contextmanager
def whole(file: Path) -> Iterator[Path]:
    """A new file beside `file` to write to, which takes the place of `file` at once
    when all is written: whoever reads it, or stops us, finds the old or the new one.
    OSError where it cannot be written."""
    _remove_left(file)
    part = _part(file)
    try:
        os.close(os.open(part, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        with _holding(part):
            yield part
            part.replace(file)
    finally:
        part.unlink(missing_ok=True)


def write_whole(file: Path, content: str | bytes) -> None:
    """Write a file, whole or not at all: whoever reads it, or kills us, or cuts the
    power, finds the old or the new one."""
    data = content.encode("utf8") if isinstance(content, str) else content
    with whole(file) as part, part.open("wb") as out:
        out.write(data)
        out.flush()
        os.fsync(out.fileno())


@contextmanager
def folder_beside(out: Path) -> Iterator[Path]:
    """A new folder beside `out`, to be renamed to it when all is written, that nobody
    else can look into; it is removed at the end where it is still there."""
    out.parent.mkdir(parents=True, exist_ok=True)
    _remove_left(out)
    part = _part(out)
    try:
        part.mkdir(mode=0o700)
        with _holding(part):
            yield part
    finally:
        shutil.rmtree(part, ignore_errors=True)


@contextmanager
def new_folder(out: Path) -> Iterator[Path]:
    """A folder to write into that becomes `out`, where nothing may be yet.
    FileExistsError where something is."""
    with folder_beside(out) as part:
        yield part
        if os.path.lexists(out):
            raise FileExistsError(f"{out}: is there already; choose another")
        part.chmod(0o755)
        part.rename(out)


def own_folder(folder: Path) -> Path:
    """A folder under a name that others know, made if need be. PermissionError unless
    it is this user's, no link, and closed to others."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    told = folder.lstat()
    if hasattr(os, "getuid") and (
        folder.is_symlink() or told.st_uid != os.getuid() or told.st_mode & 0o022
    ):
        raise PermissionError(f"{folder}: not a folder of this user's alone")
    return folder


def _part(out: Path) -> Path:
    """A name beside `out` that nothing has: chosen before anything is made, so that a
    signal at any moment leaves nothing behind."""
    return out.with_name(f"{_start(out)}{secrets.token_hex(16)}{PART}")


def _start(out: Path) -> str:
    return f".{out.name[:LONGEST]}-"


def _remove_left(out: Path) -> None:
    """Remove parts of `out` whose makers have died: nobody holds them, and they are
    older than it takes to."""
    with suppress(OSError):
        for entry in [*os.scandir(out.parent)]:
            name, old = entry.name, time.time() - HELD_AFTER_S
            ours = name.startswith(_start(out)) and name.endswith(PART)
            if ours and entry.stat(follow_symlinks=False).st_mtime < old:
                with suppress(OSError), _holding(Path(entry.path)) as held:
                    _remove(Path(entry.path), held)


def _remove(left: Path, held: bool) -> None:
    if held and left.is_dir():
        shutil.rmtree(left, ignore_errors=True)
    elif held:
        left.unlink()


@contextmanager
def _holding(part: Path) -> Iterator[bool]:
    """Hold a part until the block, or this process, ends; whether nobody else does.
    False where the system knows no locks; OSError for a link."""
    try:
        import fcntl
    except ImportError:
        yield False
        return
    handle = os.open(part, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            held = True
        except OSError:  # another holds it, or a drive without locks
            held = False
        yield held
    finally:
        os.close(handle)
