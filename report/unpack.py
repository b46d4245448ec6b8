"""Opens a pack: checks every file against its hash, and says by what it was made."""

import json
import os
import zipfile
import zlib
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from errno import ENOSPC
from hashlib import sha256
from io import BufferedIOBase
from pathlib import Path, PurePosixPath
from shutil import disk_usage
from typing import cast

from benchtwin.bench.exits import Misuse
from benchtwin.bench.whole_file import new_folder
from benchtwin.report.pack import FORMAT, MANIFEST, MOST_LISTED, some, stays_within
from benchtwin.twin.versions import versions

Reader = Callable[[str], BufferedIOBase]
AS_PACKED, CHANGED, LONGER = "as packed", "changed", "longer"
PIECE = 1 << 20  # bytes that are read at a time


@dataclass(frozen=True)
class Opened:
    """changed, missing, longer, unlisted: names of files that are not as they were
    packed, longer ones with more in them than the pack says; version: of benchtwin,
    that made it; other_versions: {library: (then, here)}."""

    changed: tuple[str, ...]
    missing: tuple[str, ...]
    longer: tuple[str, ...]
    unlisted: tuple[str, ...]
    version: str
    other_versions: dict[str, tuple[str, str]]

    @property
    def whole(self) -> bool:
        """Whether every file is as it was packed."""
        return not (self.changed or self.missing or self.longer)

    def in_words(self) -> list[str]:
        """What a reader of a pack has to know."""
        differing = {
            "missing": self.missing,
            "not as packed": self.changed,
            "longer than packed, and not copied": self.longer,
            "not listed, and not copied": self.unlisted,
        }
        lines = [f"{what}: {some(names)}" for what, names in differing.items() if names]
        if self.whole:
            lines.append("every file is as it was packed")
        here = versions()["benchtwin"]
        if self.version != here:
            lines.append(
                f"packed by benchtwin {self.version}; this is {here}: its numbers"
                " stand, computed again they may differ"
            )
        others = [
            f"{name} {then} (here {now})"
            for name, (then, now) in self.other_versions.items()
            if name != "benchtwin"
        ]
        return [*lines, *([f"made with {', '.join(others)}"] if others else [])]


def unpack(packed: Path, out: Path | None) -> Opened:
    """Check a pack, a folder or a zip, and copy what it lists into the folder `out`;
    None: only check. What has changed is copied as it is, but for what is longer than
    the pack says.

    Raises Misuse for what is none, FileExistsError where `out` is, OSError where it
    cannot be written: nothing half-written is left."""
    if out is not None and os.path.lexists(out):
        raise FileExistsError(f"{out}: is there already; choose another --out")
    with _opened(packed) as (names, read):
        manifest = _manifest(packed, names, read)
        listed = manifest["files"]
        there = {name: row for name, row in listed.items() if name in names}
        if out is None:
            found = {n: _found(read(n), row) for n, row in there.items()}
        else:
            found = _copied(there, read, out)
    here, then = versions(), manifest.get("versions", {})
    return Opened(
        tuple(n for n, how in found.items() if how == CHANGED),
        tuple(n for n in listed if n not in names),
        tuple(n for n, how in found.items() if how == LONGER),
        tuple(sorted(names - set(listed) - {MANIFEST})),
        str(then.get("benchtwin", "an unknown version")),
        {n: (str(v), here[n]) for n, v in then.items() if n in here and v != here[n]},
    )


@contextmanager
def _opened(packed: Path) -> Iterator[tuple[set[str], Reader]]:
    """Names in a pack, and what reads one of them."""
    if packed.is_dir():
        files = {p.relative_to(packed).as_posix() for p in packed.rglob("*") if _own(p)}
        yield files, lambda name: (packed / name).open("rb")
        return
    if not packed.exists():
        raise Misuse(f"{packed}: no such file or folder")
    try:
        with zipfile.ZipFile(packed) as held:
            names = {n for n in held.namelist() if not n.endswith("/")}
            yield names, lambda name: cast(BufferedIOBase, held.open(name))
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError) as error:
        raise Misuse(f"{packed}: a damaged zip, or none ({error})") from None


def _own(path: Path) -> bool:
    return path.is_file() and not path.is_symlink()


def _manifest(packed: Path, names: set[str], read: Reader) -> dict:
    """What a pack lists; Misuse where it lists nothing that can be followed."""
    if MANIFEST not in names:
        raise Misuse(
            f"{packed}: {MANIFEST} is not in it: `benchtwin pack` did not make it"
        )
    with read(MANIFEST) as stream:
        text = stream.read(MOST_LISTED + 1)
    if len(text) > MOST_LISTED:
        raise Misuse(f"{packed}: {MANIFEST} in it is larger than {MOST_LISTED:,} bytes")
    try:
        told = json.loads(text)
        made, written = told["format"], told["files"]
        names_safe = all(map(stays_within, written)) and not _nested(written)
        whole = all(
            isinstance(row.get("sha256"), str) and type(row.get("bytes")) is int
            for row in written.values()
        )
        by = told.setdefault("versions", {}).get("benchtwin", "?")
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise Misuse(f"{packed}: {MANIFEST} in it is damaged") from None
    if not isinstance(made, int) or made > FORMAT:
        raise Misuse(
            f"{packed}: packed by benchtwin {by} in format {made}; this is benchtwin"
            f" {versions()['benchtwin']}, which reads up to {FORMAT}"
        )
    if not names_safe:
        raise Misuse(
            f"{packed}: {MANIFEST} lists names outside the pack, or a file in a file"
        )
    if not whole:
        raise Misuse(f"{packed}: {MANIFEST} in it is damaged")
    return told


def _nested(names: Collection[str]) -> bool:
    """Whether a name is that of a folder of another."""
    places = [PurePosixPath(name) for name in names]
    return not {p for place in places for p in place.parents}.isdisjoint(places)


def _copied(listed: dict, read: Reader, out: Path) -> dict[str, str]:
    """What was found of each file, all but longer ones copied."""
    out.parent.mkdir(parents=True, exist_ok=True)
    size, free = (
        sum(row["bytes"] for row in listed.values()),
        disk_usage(out.parent).free,
    )
    if size > free:
        raise OSError(ENOSPC, f"{size / 1e9:.1f} GB in it, {free / 1e9:.1f} GB free")
    found = {}
    with new_folder(out) as part:
        for name, row in listed.items():
            place = part / name
            place.parent.mkdir(parents=True, exist_ok=True)
            with place.open("xb") as target:
                found[name] = _found(read(name), row, target.write)
            if found[name] == LONGER:
                place.unlink()
    return found


def _found(
    stream: BufferedIOBase, row: dict, write: Callable[[bytes], object] = len
) -> str:
    """How a file compares with its row; at most what that allows is handed to
    `write`."""
    digest, left = sha256(), row["bytes"]
    with stream:
        while piece := stream.read(PIECE):
            if (left := left - len(piece)) < 0:
                return LONGER
            digest.update(piece)
            write(piece)
    return AS_PACKED if digest.hexdigest() == row["sha256"] else CHANGED
