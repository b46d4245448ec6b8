"""Opens a pack: checks every file against its hash, and says by what it was made."""

import json
import shutil
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import BufferedIOBase
from pathlib import Path, PurePosixPath
from typing import cast

from benchtwin.report.archive import FORMAT, MANIFEST
from benchtwin.report.archive.pack import digest
from benchtwin.twin.versions import versions

Reader = Callable[[str], BufferedIOBase]


class NoPack(ValueError):
    """A folder or file that is no pack, or one that this version cannot read."""


@dataclass(frozen=True)
class Opened:
    """changed, missing, unlisted: names of files that are not as they were packed;
    version: of benchtwin, that made it; other_versions: {library: (then, here)}."""

    changed: tuple[str, ...]
    missing: tuple[str, ...]
    unlisted: tuple[str, ...]
    version: str
    other_versions: dict[str, tuple[str, str]]

    @property
    def whole(self) -> bool:
        """Whether every file is as it was packed."""
        return not (self.changed or self.missing)


def unpack(packed: Path, out: Path | None) -> Opened:
    """Check a pack, a folder or a zip, and copy what it lists into the folder `out`;
    None: only check. What has changed is copied as it is.

    Raises NoPack for what is none, FileExistsError where `out` is, OSError where it
    cannot be written: nothing half-written is left."""
    if out is not None and out.exists():
        raise FileExistsError(f"{out}: is there already; choose another --out")
    with _opened(packed) as (names, read):
        manifest = _manifest(packed, names, read)
        listed = manifest["files"]
        if out is None:
            wrong = [n for n in listed if n in names and _differs(read(n), listed[n])]
        else:
            wrong = _copied(listed, names, read, out)
    here, then = versions(), manifest.get("versions", {})
    return Opened(
        tuple(wrong),
        tuple(n for n in listed if n not in names),
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
        raise NoPack(f"{packed}: no such file or folder")
    try:
        with zipfile.ZipFile(packed) as held:
            names = {n for n in held.namelist() if not n.endswith("/")}
            yield names, lambda name: cast(BufferedIOBase, held.open(name))
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError) as error:
        raise NoPack(f"{packed}: a damaged zip, or none ({error})") from None


def _own(path: Path) -> bool:
    return path.is_file() and not path.is_symlink()


def _manifest(packed: Path, names: set[str], read: Reader) -> dict:
    """What a pack lists; NoPack where it lists nothing that can be followed."""
    if MANIFEST not in names:
        raise NoPack(
            f"{packed}: {MANIFEST} is not in it: `benchtwin pack` did not make it"
        )
    try:
        with read(MANIFEST) as stream:
            told = json.load(stream)
        made, written = told["format"], told["files"]
        names_safe = all(_safe(name) for name in written)
        hashed = all(isinstance(row["sha256"], str) for row in written.values())
    except (ValueError, KeyError, TypeError, AttributeError):
        raise NoPack(f"{packed}: {MANIFEST} in it is damaged") from None
    if not isinstance(made, int) or made > FORMAT:
        by = told.get("versions", {}).get("benchtwin", "?")
        raise NoPack(
            f"{packed}: packed by benchtwin {by} in format {made}; this is benchtwin"
            f" {versions()['benchtwin']}, which reads up to {FORMAT}"
        )
    if not (names_safe and hashed):
        raise NoPack(f"{packed}: {MANIFEST} lists names outside the pack")
    return told


def _safe(name: str) -> bool:
    """Whether a name stays within the folder that it is written into."""
    parts = PurePosixPath(name).parts
    clean = not any(c in name for c in "\\:\0")
    return bool(parts) and clean and ".." not in parts and parts[0] != "/"


def _copied(listed: dict, names: set[str], read: Reader, out: Path) -> list[str]:
    """Files whose content is not what was packed."""
    part, wrong = out.with_name(f".{out.name}.part"), []
    try:
        for name in (n for n in listed if n in names):
            place = part / name
            place.parent.mkdir(parents=True, exist_ok=True)
            with read(name) as source, place.open("wb") as target:
                shutil.copyfileobj(source, target)
            if _differs(place.open("rb"), listed[name]):
                wrong.append(name)
        part.replace(out)
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return wrong


def _differs(stream: BufferedIOBase, row: dict) -> bool:
    with stream:
        return digest(stream) != row["sha256"]
