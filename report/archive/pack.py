"""Packs a bench and its results."""

import hashlib
import json
import os
import shutil
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from io import SEEK_END, BufferedIOBase, BytesIO
from pathlib import Path

from benchtwin.bench.exits import Misuse
from benchtwin.bench.whole_file import new_folder, whole
from benchtwin.report.archive import (
    ABOUT,
    FORMAT,
    MANIFEST,
    MOST_LISTED,
    some,
    stays_within,
)
from benchtwin.report.archive.about import about
from benchtwin.report.archive.machine import Machine
from benchtwin.report.template import PAGE, PRINTED
from benchtwin.twin.bench_folder import among_results
from benchtwin.twin.versions import versions

RUNS = "runs"  # of simulations: large, and computed again by the same command
ZIP = ".zip"
WRITTEN_AT = (1980, 1, 1, 0, 0, 0)  # of every file in a zip: the same content, one file


@dataclass
class Packed:
    """files: {name in the pack: content's path, or its text where it was changed};
    left_out: links, by name; located: photos that say where they were taken."""

    files: dict[str, Path | str] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)
    located: list[str] = field(default_factory=list)

    def in_words(self, out: Path) -> list[str]:
        """What stands in `out` now, and what does not."""
        held = (p for p in (out, *out.rglob("*")) if p.is_file())
        size = sum(p.stat().st_size for p in held) / 1e6
        lines = [f"{out}: {len(self.files)} files, {size:.1f} MB"]
        if self.left_out:
            why = "links, and prints of pages that name folders of this machine"
            lines.append(f"left out ({why}): {some(self.left_out)}")
        if self.located:
            where = "where they were taken is in photos (EXIF)"
            lines.append(f"{where}: {some(self.located)}")
        return lines


def pack(bench: Path, results: Sequence[Path], out: Path, runs: bool = False) -> Packed:
    """Write bench/NAME, results/NAME for each folder of results, README.md and
    pack.json into the folder `out`, or the zip where its name ends so; it appears whole
    or not at all.

    runs: the simulations of results, too. Raises FileNotFoundError for a folder that
    is not there, FileExistsError where `out` is, Misuse for a bench whose own files
    name folders of this machine, OSError where it cannot be written."""
    for folder in (bench, *results):
        if not folder.is_dir():
            raise FileNotFoundError(f"{folder}: no such folder")
    if os.path.lexists(out):
        raise FileExistsError(f"{out}: is there already; choose another --out")
    for folder in (bench, *results):
        if folder.resolve() in (out.resolve(), *out.resolve().parents):
            raise Misuse(f"--out {out}: lies within {folder}, which is packed")
    gathered = _gathered(bench, results, runs)
    out.parent.mkdir(parents=True, exist_ok=True)
    if out.suffix == ZIP:
        with whole(out) as part:
            _as_zip(part, gathered.files)
    else:
        with new_folder(out) as part:
            _as_folder(part, gathered.files)
    return gathered


def _gathered(bench: Path, results: Sequence[Path], runs: bool) -> Packed:
    places = {bench: f"bench/{bench.resolve().name}"}
    for folder in results:
        name = f"results/{folder.resolve().name}"
        if name in places.values():
            raise Misuse(f"two folders of results are called {folder.name}")
        places[folder] = name
    machine, found = Machine(places), Packed()
    for folder, name in places.items():
        for inside, path in _walk(folder, found):
            if folder == bench and among_results(path, bench):
                continue
            if folder != bench and RUNS in inside.parts[:-1] and not runs:
                continue
            at = f"{name}/{inside.as_posix()}"
            if not stays_within(at):
                raise Misuse(f"{path}: a name that not every system can have")
            if path.name == PRINTED and _changed(machine, path.with_name(PAGE)):
                found.left_out.append(str(path))  # a print cannot be changed
                continue
            found.files[at] = path if folder == bench else machine.cleaned(path)
            if folder == bench:
                if named := machine.named_in(path):
                    raise Misuse(
                        f"{path}: names {named}, a place on this machine; name it from"
                        " the bench's folder on"
                    )
                found.located += [at] if machine.is_located(path) else []
    found.files[ABOUT] = about(bench.resolve().name, found.files, runs)
    found.files[MANIFEST] = _manifest(found.files)
    return found


def _changed(machine: Machine, page: Path) -> bool:
    return page.is_file() and isinstance(machine.cleaned(page), str)


def _walk(folder: Path, found: Packed) -> Iterator[tuple[Path, Path]]:
    """Files of a folder by their place in it; hidden ones are no part of it, links are
    named."""
    for path in sorted(folder.rglob("*")):
        inside = path.relative_to(folder)
        hidden = any(part.startswith(".") for part in inside.parts)
        if path.is_symlink():
            found.left_out.append(str(path))
        elif path.is_file() and not hidden:
            yield inside, path


def _manifest(files: Mapping[str, Path | str]) -> str:
    rows = {}
    for at, content in sorted(files.items()):
        with stream_of(content) as stream:
            hashed, size = (
                hashlib.file_digest(stream, "sha256").hexdigest(),
                stream.seek(0, SEEK_END),
            )
        rows[at] = {"bytes": size, "sha256": hashed}
    told = {"format": FORMAT, "versions": versions(), "files": rows}
    text = json.dumps(told, indent=1, ensure_ascii=False)
    if len(text.encode()) > MOST_LISTED:
        raise Misuse(f"{len(rows):,} files are too many for one pack")
    return text


def stream_of(content: Path | str) -> BufferedIOBase:
    """A file's bytes, of films too large for the memory, too."""
    return BytesIO(content.encode()) if isinstance(content, str) else content.open("rb")


def _as_folder(part: Path, files: Mapping[str, Path | str]) -> None:
    for at, content in files.items():
        place = part / at
        place.parent.mkdir(parents=True, exist_ok=True)
        with stream_of(content) as source, place.open("wb") as target:
            shutil.copyfileobj(source, target)


def _as_zip(part: Path, files: Mapping[str, Path | str]) -> None:
    with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as held:
        for at, content in sorted(files.items()):
            told = zipfile.ZipInfo(at, WRITTEN_AT)
            told.compress_type = zipfile.ZIP_DEFLATED
            entry = held.open(told, "w", force_zip64=True)
            with stream_of(content) as source, entry as target:
                shutil.copyfileobj(source, target)
