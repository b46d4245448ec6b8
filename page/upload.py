"""Sorts files dropped on the page into recordings of a bench; each recording is made
whole or not at all."""

import re
import shutil
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from benchtwin.page.folder import Folder, Refused, clean_name, whole_folder
from benchtwin.vision.evidence.photo import PHOTO_SUFFIXES
from benchtwin.vision.evidence.sound import SOUND_SUFFIXES
from benchtwin.vision.foreign import SUFFIXES as TOOL_SUFFIXES
from benchtwin.vision.recording import TABLES, VIDEO_SUFFIXES

PHOTO, VIDEO, SOUND, TABLE, KEYS = "photo", "video", "sound", "table", "keys"
KINDS = {  # suffix → what it is and how large one may be [bytes]
    **dict.fromkeys(TOOL_SUFFIXES, (TABLE, 500_000_000)),
    **dict.fromkeys(SOUND_SUFFIXES, (SOUND, 500_000_000)),
    **dict.fromkeys(PHOTO_SUFFIXES, (PHOTO, 200_000_000)),
    **dict.fromkeys(VIDEO_SUFFIXES, (VIDEO, 2_000_000_000)),
    ".toml": (KEYS, 30_000),
}
LEAST_FRAMES = 12  # numbered pictures of one name are a film from this many on
SPARE_BYTES = 100_000_000  # left free on the disk


@dataclass(frozen=True)
class ReceivedFile:
    """An uploaded file: its name (with the folder that was dropped, if any) and where
    it lies now."""

    name: str
    path: Path


@dataclass(frozen=True)
class NewRecording:
    """Files of one recording: its folder, file names in it → files, and the rig if the
    kind of file tells it."""

    folder: str
    files: dict[str, Path]
    rig: str | None


def check(name: str, size: int, folder: Folder) -> None:
    """Refused, in words, for a file that is not to be taken: of no known kind, too
    large, or more than the disk holds."""
    kind = KINDS.get(Path(name).suffix.lower())
    if kind is None:
        known = ", ".join(KINDS)
        raise Refused(f"{name}: not something that benchtwin reads (it reads {known})")
    if size > kind[1]:
        raise Refused(
            f"{name}: {size / 1e6:,.0f} MB; a {kind[0]} has {kind[1] / 1e6:,.0f} MB at"
            " most. Cut or scale it down"
        )
    if size > shutil.disk_usage(folder.root).free - SPARE_BYTES:
        raise Refused(
            f"{name}: {size / 1e6:,.0f} MB are more than this disk has room for"
        )


def place_files(
    arrived: Iterable[ReceivedFile], bench: Path, folder: Folder
) -> list[Path]:
    """Move the files into recordings of `bench`; returns their folders. Refused where a
    group cannot be placed: those before it are placed, nothing is replaced."""
    arrived = list(arrived)
    made = []
    for keys in [a for a in arrived if Path(a.name).name == "bench.toml"]:
        if (bench / "bench.toml").exists():
            raise Refused("bench.toml exists already; nothing was replaced")
        keys.path.rename(bench / "bench.toml")
        arrived.remove(keys)
    for group in groups(arrived):
        target = _free(bench, group.folder)
        with whole_folder(target, folder.root) as part:
            for name, file in group.files.items():
                (part / name).parent.mkdir(exist_ok=True)
                file.rename(part / name)
            if not (part / "recording.toml").exists():
                rig = (
                    f'rig = "{group.rig}"\n'
                    if group.rig
                    else '# rig = "drop"             # drop, slide, roll or pile\n'
                )
                (part / "recording.toml").write_text(rig, encoding="utf8")
        made.append(target)
    return made


def groups(arrived: list[ReceivedFile]) -> list[NewRecording]:
    """What belongs together: a dropped folder, numbered pictures of one name, else each
    file alone (a film and its sound or table of the same name together)."""
    out: list[NewRecording] = []
    folders: dict[str, list[ReceivedFile]] = {}
    for file in arrived:
        folders.setdefault(file.name.rpartition("/")[0], []).append(file)
    for name, files in folders.items():
        if name and any(_is_evidence(f) for f in files):
            out.append(_dropped_folder(name, files, folders))
        elif not name.endswith("/frames") or name.rpartition("/")[0] not in folders:
            out += _loose(files)
    return out


def _is_evidence(file: ReceivedFile) -> bool:
    name = file.name.rpartition("/")[2]
    return name in (*TABLES, "recording.toml") or Path(name).suffix.lower() in (
        *VIDEO_SUFFIXES,
        *SOUND_SUFFIXES,
    )


def _dropped_folder(
    name: str, files: list[ReceivedFile], folders: dict[str, list[ReceivedFile]]
) -> NewRecording:
    inside = {clean_name(f.name): f.path for f in files}
    inside |= {
        f"frames/{clean_name(f.name)}": f.path
        for f in folders.get(f"{name}/frames", [])
    }
    return NewRecording(clean_name(name), inside, None)


def _loose(files: list[ReceivedFile]) -> list[NewRecording]:
    out, films = [], _films(files)
    for stem, frames in films.items():
        out.append(
            NewRecording(
                stem or "film",
                {f"frames/{clean_name(f.name)}": f.path for f in frames},
                None,
            )
        )
    taken = {id(f) for frames in films.values() for f in frames}
    named: dict[str, dict[str, Path]] = {}
    for file in (f for f in files if id(f) not in taken):
        name = clean_name(file.name)
        kind = KINDS[Path(name).suffix.lower()][0]
        if kind == PHOTO:
            out.append(NewRecording("pile", {name: file.path}, "pile"))
        elif name.lower().endswith(".csv"):
            named.setdefault(Path(name).stem, {})[_table_name(name, file.path)] = (
                file.path
            )
        else:
            named.setdefault(Path(name).stem, {})[name] = file.path
    return out + [
        NewRecording(stem, inside, _rig_of(inside)) for stem, inside in named.items()
    ]


def _rig_of(inside: dict[str, Path]) -> str | None:
    """What is heard and not seen is a drop."""
    return (
        "drop"
        if all(Path(name).suffix.lower() in SOUND_SUFFIXES for name in inside)
        else None
    )


def _films(files: list[ReceivedFile]) -> dict[str, list[ReceivedFile]]:
    """Pictures whose names differ in their number only, LEAST_FRAMES or more, by the
    rest of the name."""
    runs: dict[str, list[ReceivedFile]] = {}
    for file in files:
        name = Path(clean_name(file.name))
        if name.suffix.lower() in PHOTO_SUFFIXES and (
            number := re.fullmatch(r"(.*?)[-_ ]?(\d{2,})", name.stem)
        ):
            runs.setdefault(number[1], []).append(file)
    return {stem: run for stem, run in runs.items() if len(run) >= LEAST_FRAMES}


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
    from benchtwin.vision.evidence.tables import READING_COLUMNS

    return "readings.csv" if heading & set(READING_COLUMNS) else name


def _free(bench: Path, name: str) -> Path:
    """A folder that is not there yet: `name`, or with the next number; piles are
    numbered from the first on."""
    if name != "pile" and not (bench / name).exists():
        return bench / name
    return next(
        bench / f"{name}-{n:02d}"
        for n in range(1, 10_000)
        if not (bench / f"{name}-{n:02d}").exists()
    )
