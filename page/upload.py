"""Sorts files dropped on the page into recordings of a bench; each recording is made
whole or not at all."""

import itertools
import shutil
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from benchtwin.bench.language import tr
from benchtwin.bench.rigs import READING_COLUMNS
from benchtwin.bench.whole_file import new_folder
from benchtwin.page.folder import Folder, Refused, clean_name, numbered
from benchtwin.vision.evidence.film_or_photos import (
    FILM,
    PHOTOS,
    film_or_photos,
    numbered_runs,
)
from benchtwin.vision.evidence.photo import PHOTO_SUFFIXES
from benchtwin.vision.evidence.sound import SOUND_SUFFIXES
from benchtwin.vision.foreign import SUFFIXES as TOOL_SUFFIXES
from benchtwin.vision.recording import TABLES, VIDEO_SUFFIXES, Recording

PHOTO, VIDEO, SOUND, TABLE, KEYS = "photo", "video", "sound", "table", "keys"
KINDS = {  # suffix → what it is and how large one may be [bytes]
    **dict.fromkeys(TOOL_SUFFIXES, (TABLE, 500_000_000)),
    **dict.fromkeys(SOUND_SUFFIXES, (SOUND, 500_000_000)),
    **dict.fromkeys(PHOTO_SUFFIXES, (PHOTO, 200_000_000)),
    **dict.fromkeys(VIDEO_SUFFIXES, (VIDEO, 2_000_000_000)),
    ".toml": (KEYS, 30_000),
}
BROUGHT = "# brought as: "  # in a recording.toml: how a file was called that is renamed
SPARE_BYTES = 100_000_000  # left free on the disk


@dataclass(frozen=True)
class ReceivedFile:
    """An uploaded file: its name (with the folder that was dropped, if any) and where
    it lies now."""

    name: str
    path: Path


@dataclass(frozen=True)
class NewRecording:
    """Files of one recording: its folder, file names in it → files as they arrived, and
    the rig if the kind of file tells it."""

    folder: str
    files: dict[str, ReceivedFile]
    rig: str | None


@dataclass(frozen=True)
class Placed:
    """Folders of the recordings that were made, and in words what could not be."""

    made: list[Path]
    refused: list[str]


def check(name: str, size: int, folder: Folder) -> None:
    """Refused, in words, for a file that is not to be taken: of no known kind, too
    large, or more than the disk holds."""
    kind = KINDS.get(Path(name).suffix.lower())
    if kind is None:
        known = ", ".join(KINDS)
        raise Refused(
            tr("{}: not something that benchtwin reads (it reads {})", name, known)
        )
    if size > kind[1]:
        raise Refused(
            tr(
                "{}: {:,.0f} MB; a {} has {:,.0f} MB at most. Cut or scale it down",
                name,
                size / 1e6,
                tr(kind[0]),
                kind[1] / 1e6,
            )
        )
    if size > shutil.disk_usage(folder.root).free - SPARE_BYTES:
        raise Refused(
            tr(
                "{}: {:,.0f} MB are more than this disk has room for",
                name,
                size / 1e6,
            )
        )


def place_files(arrived: Iterable[ReceivedFile], bench: Path) -> Placed:
    """Move the files into recordings of `bench`; nothing is replaced, and what cannot
    be placed keeps nothing else from its place."""
    arrived, made, refused = list(arrived), [], []
    for keys in [a for a in arrived if Path(a.name).name == "bench.toml"]:
        arrived.remove(keys)
        if (bench / "bench.toml").exists():
            refused.append(tr("bench.toml exists already; it was not replaced"))
        else:
            keys.path.rename(bench / "bench.toml")
    for group in groups(arrived):
        try:
            target = _free(bench, group.folder)
            with new_folder(target) as part:
                _fill(part, group)
            made.append(target)
        except (Refused, OSError) as error:
            refused.append(f"{group.folder}: {getattr(error, 'strerror', '') or error}")
    return Placed(made, refused)


def _fill(part: Path, group: NewRecording) -> None:
    for name, file in group.files.items():
        (part / name).parent.mkdir(exist_ok=True)
        file.path.rename(part / name)
    if (part / "recording.toml").exists():
        return
    rig = '# rig = "drop"             # drop, slide, roll or pile\n'
    if group.rig:
        rig = f'rig = "{group.rig}"\n'
    renamed = [
        file.name.rpartition("/")[2]
        for name, file in group.files.items()
        if file.name.rpartition("/")[2] != Path(name).name
    ]
    brought = "".join(f"{BROUGHT}{name}\n" for name in renamed)
    (part / "recording.toml").write_text(rig + brought, encoding="utf8")


def brought_as(recording: Recording) -> str:
    """How a file was called that was renamed when it was brought; "" where none was."""
    if not recording.toml.is_file():
        return ""
    text = recording.toml.read_text(encoding="utf-8-sig", errors="replace")
    lines = [
        x.removeprefix(BROUGHT) for x in text.splitlines() if x.startswith(BROUGHT)
    ]
    return ", ".join(lines)


def groups(arrived: list[ReceivedFile]) -> list[NewRecording]:
    """What belongs together: a dropped folder, the frames of a film, else each file
    alone (a film and its sound or table of the same name together)."""
    out: list[NewRecording] = []
    folders: dict[str, list[ReceivedFile]] = {}
    for file in arrived:
        folders.setdefault(file.name.rpartition("/")[0], []).append(file)
    frames = {n.rpartition("/")[0]: n for n in folders if Path(n).name == "frames"}
    for name in {**folders, **frames}:
        files = folders.get(name, [])
        if name in frames or any(_is_evidence(f, loose=not name) for f in files):
            film = _named(folders[frames[name]]) if name in frames else {}
            inside = _named(files) | {f"frames/{n}": f for n, f in film.items()}
            out.append(NewRecording(clean_name(name or "film"), inside, None))
        elif name not in frames.values():
            out += _loose(files)
    return out


def _is_evidence(file: ReceivedFile, *, loose: bool) -> bool:
    """Whether this file makes those beside it one recording."""
    name = file.name.rpartition("/")[2]
    films = (*VIDEO_SUFFIXES, *SOUND_SUFFIXES)
    return name == "recording.toml" or (
        not loose and (name in TABLES or Path(name).suffix.lower() in films)
    )


def _named(files: Iterable[ReceivedFile]) -> dict[str, ReceivedFile]:
    """The files by names that can stand in a folder, each of its own."""
    out: dict[str, ReceivedFile] = {}
    for file in files:
        out[next(n for n in numbered(clean_name(file.name)) if n not in out)] = file
    return out


def _loose(files: list[ReceivedFile]) -> list[NewRecording]:
    out: list[NewRecording] = []
    left = _named(files)
    for stem, names in numbered_runs(left).items():
        kind = film_or_photos({name: left[name].path for name in names}).kind
        if kind != PHOTOS:  # where both fit, the recording's page asks
            within = "frames/" if kind == FILM else ""
            run = {f"{within}{name}": left.pop(name) for name in names}
            out.append(NewRecording(stem.strip("-_ ") or "film", run, None))
    named: dict[str, dict[str, ReceivedFile]] = {}
    for name, file in left.items():
        if KINDS[Path(name).suffix.lower()][0] == PHOTO:
            out.append(NewRecording("pile", {name: file}, "pile"))
        else:
            table = name.lower().endswith(".csv")
            known = _table_name(name, file.path) if table else name
            named.setdefault(Path(name).stem, {})[known] = file
    return out + [
        NewRecording(stem, inside, _rig_of(inside)) for stem, inside in named.items()
    ]


def _rig_of(inside: Iterable[str]) -> str | None:
    """What is heard and not seen is a drop."""
    if all(Path(name).suffix.lower() in SOUND_SUFFIXES for name in inside):
        return "drop"
    return None


def _table_name(name: str, path: Path) -> str:
    """The name under which `measure` knows a table with these columns."""
    if name in TABLES:
        return name
    with path.open("rb") as file:
        heading = {
            c.strip() for c in file.readline(2000).decode("utf8", "replace").split(",")
        }
    if {"x_mm", "t_s"} <= heading and "y_mm" not in heading:
        return "gates.csv"
    if {"x_mm", "y_mm"} <= heading or {"x_px", "y_px"} <= heading:
        return "track.csv"
    if heading == {"t_s"}:
        return "impacts.csv"
    return "readings.csv" if heading & set(READING_COLUMNS) else name


def _free(bench: Path, name: str) -> Path:
    """A folder that is not there yet: `name`, or with the next number; piles are
    numbered from the first on."""
    names = numbered(name)
    if name == "pile":
        names = (f"pile-{n:02d}" for n in itertools.count(1))
    return next(bench / one for one in names if not (bench / one).exists())
