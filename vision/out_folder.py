"""Output folders that appear whole or not at all, and that replace nothing but earlier
output of the same command."""

import contextlib
import errno
import itertools
import os
import shutil
from collections.abc import Callable, Collection, Iterator, Sequence
from pathlib import Path

from benchtwin.bench.language import tr
from benchtwin.bench.whole_file import folder_beside
from benchtwin.vision.measurement import require

LONGEST_NAME = 50  # characters of a file name, each four bytes at most


def check_out(
    out: Path,
    what: str,
    is_own: Callable[[Path], bool],
    overwrite: bool,
    inputs: Sequence[Path] = (),
) -> None:
    """Raise MeasurementError unless `out` can be written: absent, empty, or with
    `overwrite` and own output only. what: what the folder may hold, for the message;
    is_own: whether a path in it is output of the command; inputs: paths that are
    read."""
    require(
        not out.exists() or out.is_dir(), tr("{}: is a file; --out names a folder", out)
    )
    there = sorted(out.iterdir()) if out.is_dir() else []
    require(
        not there or overwrite,
        tr(
            "{}: exists and is not empty; choose another --out, or say --overwrite", out
        ),
    )
    for path in there:
        require(
            is_own(path),
            tr(
                "{}: holds something else than {} ({}); it is not overwritten",
                out,
                what,
                path.name,
            ),
        )
    for path in inputs:
        require(
            not there or not path.resolve().is_relative_to(out.resolve()),
            tr("{}: holds {}, which is to be read; choose another --out", out, path),
        )


def put_in_place(
    part: Path, out: Path, is_own: Callable[[Path], bool], overwrite: bool
) -> None:
    """Rename `part` to `out`. Raises OSError, and loses nothing, where something else
    has come into `out` meanwhile."""
    if out.is_dir() and not all(is_own(path) for path in out.iterdir()):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(out))
    part.chmod(0o755)
    old = part.with_name(f"{part.name}-old")
    try:
        if overwrite and out.is_dir():
            out.replace(old)
        part.replace(out)  # fails where `out` is not empty
    finally:
        if old.is_dir() and not out.exists():
            old.replace(out)
        shutil.rmtree(old, ignore_errors=True)


@contextlib.contextmanager
def new_folder(
    out: Path, is_own: Callable[[Path], bool], overwrite: bool
) -> Iterator[Path]:
    """A folder to write into that becomes `out` at the end, and is removed where an
    error comes first."""
    with folder_beside(out) as part:
        yield part
        put_in_place(part, out, is_own, overwrite)


def file_name(name: str, taken: Collection[str]) -> str:
    """A name as a valid file name without folders, different from those `taken` (in
    lower case)."""
    kept = "".join(c if c.isalnum() or c in "-_. " else "_" for c in name)
    stem = kept[:LONGEST_NAME].strip(". ") or "recording"
    numbered = (f"{stem}-{n}" for n in itertools.count(2))
    if stem.lower() not in taken:
        return stem
    return next(other for other in numbered if other.lower() not in taken)
