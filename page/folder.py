"""The opened folder; nothing outside it is read or written, whatever name a request or
a file brings."""

import json
import os
import secrets
import shutil
import unicodedata
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from benchtwin.vision.recording import RESULTS_MARK as MARK

RESULTS = "results"  # in a bench: what commands left
INCOMING = ".incoming"  # files on their way, of this page or of one that was killed
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
            raise Refused(f"{name!r} is not a name inside this folder")
        try:
            path = (self.root / name).resolve()
        except (OSError, RuntimeError) as error:  # too long, or links in a circle
            raise Refused(f"{name[:80]!r} is not a name inside this folder") from error
        if not path.is_relative_to(self.root.resolve()):
            raise Refused(f"{name!r} leads out of this folder")
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
        folder.mkdir(exist_ok=True)
        (folder / MARK).touch()
        return folder

    def clear_incoming(self) -> None:
        """Throw away what a page that was killed had not finished copying."""
        shutil.rmtree(self.root / INCOMING, ignore_errors=True)


def _no_part(part: str) -> bool:
    """Whether this cannot be the name of a file or folder in a folder."""
    return (
        part in ("", "..")
        or part.startswith("~")
        or len(part.encode(errors="replace")) > 255
    )


def read_json(path: Path) -> dict:
    """A JSON file's content; nothing where it cannot be read."""
    try:
        return json.loads(path.read_text(encoding="utf8"))
    except (OSError, json.JSONDecodeError):
        return {}


def clean_name(name: str) -> str:
    """A file's own name as it can stand in any folder: no folders in it, no control
    characters, not hidden, not too long."""
    name = unicodedata.normalize("NFC", name.replace("\\", "/").rsplit("/", 1)[-1])
    name = (
        "".join(c for c in name if c.isprintable() and c not in '/\\:*?"|').strip(" .")
        or "file"
    )
    stem, dot, suffix = name.rpartition(".")
    return (
        f"{stem[: LONGEST_NAME - len(suffix) - 1]}.{suffix}"
        if dot and len(suffix) < 12
        else name[:LONGEST_NAME]
    )


@contextmanager
def whole_folder(target: Path, root: Path) -> Iterator[Path]:
    """A folder to fill, which takes the place `target` when all is in it, or never
    appears; an existing one is not replaced."""
    part = root / INCOMING / f"folder-{secrets.token_hex(8)}"
    part.mkdir(parents=True)
    try:
        yield part
        if target.exists():
            raise Refused(f"{target.name} exists already; nothing was replaced")
        target.parent.mkdir(parents=True, exist_ok=True)
        part.rename(target)
    finally:
        shutil.rmtree(part, ignore_errors=True)


def write_whole(path: Path, data: bytes) -> None:
    """Replace a file's content at once: whoever reads it, or kills us, finds the old or
    the new one whole."""
    part = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        with part.open("wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
