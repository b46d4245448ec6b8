"""The opened folder; nothing outside it is read or written, whatever name a request or
a file brings."""

import itertools
import os
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from benchtwin.bench.language import tr
from benchtwin.vision.recording import RESULTS_MARK as MARK

RESULTS = "results"  # in a bench: what commands left
MEASURED, CALIBRATED, DIAGNOSED = "measured", "calibrated", "diagnosed"  # in results
INCOMING = ".incoming"  # files on their way, of pages that are open
LONGEST_NAME = 100  # characters, each four bytes at most


class Refused(ValueError):
    """What was asked for cannot be done; the message is for the person at the page."""


@dataclass(frozen=True)
class Folder:
    """The folder that the page was opened on."""

    root: Path

    def inside(self, name: str) -> Path:
        """The path that `name` (relative, with forward slashes) means; Refused where it
        leads out of the folder."""
        parts = name.split("/")
        if (
            not name
            or "\\" in name
            or "\0" in name
            or ":" in parts[0]
            or any(map(_no_part, parts))
        ):
            raise Refused(tr("{!r} is not a name inside this folder", name))
        try:
            path = (self.root / name).resolve()
        except (OSError, RuntimeError) as error:  # too long, or links in a circle
            raise Refused(
                tr("{!r} is not a name inside this folder", name[:80])
            ) from error
        if not path.is_relative_to(self.root.resolve()):
            raise Refused(tr("{!r} leads out of this folder", name))
        return path

    def name_of(self, path: Path) -> str:
        """The name by which `inside` finds the path again; "." is the folder itself."""
        return Path(os.path.relpath(path, self.root)).as_posix()

    def benches(self) -> list[Path]:
        """The folder itself if it holds recordings or nothing at all, and the bench
        folders directly in it."""
        inside = sorted(
            p
            for p in self.root.iterdir()
            if p.is_dir() and not p.is_symlink() and not p.name.startswith(".")
        )
        inside = [p for p in inside if not (p / MARK).is_file()]
        if (self.root / "bench.toml").is_file() or any(
            (p / "recording.toml").is_file() for p in inside
        ):
            return [self.root]
        benches = [
            p
            for p in inside
            if (p / "bench.toml").is_file() or any(q.is_dir() for q in p.iterdir())
        ]
        return benches or [self.root]

    def results(self, bench: Path) -> Path:
        """Where commands leave what they found, made if need be and marked as no
        recording."""
        folder = bench / RESULTS
        if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
            raise Refused(
                tr(
                    "{}/{} is to be a folder of its own, and is a link or a file: move"
                    " it away",
                    bench.name,
                    RESULTS,
                )
            )
        folder.mkdir(exist_ok=True)
        mark = folder / MARK
        if not (mark.is_symlink() or mark.exists()):
            mark.touch()
        return folder

    def links_out(self, place: Path) -> list[Path]:
        """The links at `place` or below, and below what they lead to, that lead out of
        the folder. Hidden files, which nothing reads, count in results only."""
        root, out, seen = Path(os.path.realpath(self.root)), [], set()
        pending = [(place, RESULTS in place.parts)]
        while pending:
            path, hidden = pending.pop()
            real = Path(os.path.realpath(path))
            if not real.is_relative_to(root):
                out.append(path)
            elif real.is_dir() and real not in seen:
                seen.add(real)
                pending += _links_and_folders(path, hidden)
        return sorted(out)

    def refuse_links(self, place: Path) -> None:
        """Refused, with its name, where a link at `place` or below leads out."""
        if out := self.links_out(place):
            raise Refused(self.refused_link(out[0]))

    def refused_link(self, link: Path) -> str:
        """Why a link that leads out is not followed, and what to do."""
        return tr(
            "{} is a link out of this folder, which is not followed. Put the file"
            " itself there, or remove the link",
            self.name_of(link),
        )


def _links_and_folders(folder: Path, hidden: bool) -> list[tuple[Path, bool]]:
    """What in a folder may lead somewhere, and whether hidden files count there."""
    try:
        with os.scandir(folder) as entries:
            return [
                (Path(e.path), hidden or e.name == RESULTS)
                for e in entries
                if (hidden or not e.name.startswith("."))
                and (e.is_symlink() or e.is_dir())
            ]
    except OSError:  # nothing that may not be looked into is read either
        return []


def _no_part(part: str) -> bool:
    """Whether this cannot be the name of a file or folder in a folder."""
    return (
        part in ("", "..")
        or part.startswith("~")
        or len(part.encode(errors="replace")) > 255
    )


def clean_name(name: str) -> str:
    """A file's own name as it can stand in any folder: no folders in it, no control
    characters, not hidden, not too long."""
    name = unicodedata.normalize("NFC", name.replace("\\", "/").rsplit("/", 1)[-1])
    name = (
        "".join(c for c in name if c.isprintable() and c not in '/\\:*?"|').strip(" .")
        or "file"
    )
    stem, dot, suffix = name.rpartition(".")
    if dot and len(suffix) < 12:
        return f"{stem[: LONGEST_NAME - len(suffix) - 1]}.{suffix}"
    return name[:LONGEST_NAME]


def numbered(name: str) -> Iterator[str]:
    """`name`, then that with the numbers from 2 on before its suffix."""
    yield name
    stem, suffix = Path(name).stem, Path(name).suffix
    for number in itertools.count(2):
        yield f"{stem}-{number:02d}{suffix}"
