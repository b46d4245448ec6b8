"""Finds all recordings under a folder, and the files that are not read."""

import os
from pathlib import Path

from benchtwin.bench.language import tr
from benchtwin.vision.evidence.film_or_photos import (
    FILM,
    PHOTOS,
    Judgement,
    film_or_photos,
    numbered_runs,
)
from benchtwin.vision.evidence.photo import PHOTO_SUFFIXES
from benchtwin.vision.evidence.read_keys import read_toml
from benchtwin.vision.evidence.sound import SOUND_SUFFIXES
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import (
    RESULTS_MARK,
    VIDEO_SUFFIXES,
    Recording,
    bare_recording,
    files_in,
    read_recording,
    tool_files_in,
)

LOT_SUMMARY = "lot.toml"  # in a folder that `benchtwin shape` wrote
BESIDE = (
    ".toml",
    ".csv",
    ".md",
    ".txt",
    ".json",
    ".vtkhdf",
    "",
)  # files that may lie beside evidence


class NothingHere(MeasurementError):
    """No recording lies where one was looked for."""


def find_recordings(
    path: Path, visited: set[Path] | None = None
) -> list[Recording | MeasurementError]:
    """All recordings under `path`: a photo, a folder of photos, a recording, a bench
    folder. In place of a recording that cannot be read there is its error, so that the
    others are still measured. visited: folders visited already, by another link."""
    path = Path(path)
    visited = set() if visited is None else visited
    if path.resolve() in visited:
        return []
    visited.add(path.resolve())
    if not path.is_dir() or _is_recording(path):
        return [_attempt(read_recording, path)]
    if path.name == "frames":
        return [_attempt(read_recording, path.parent)]
    defaults: dict = {}
    if (path / "bench.toml").is_file():
        try:
            defaults = read_toml(path / "bench.toml")
        except MeasurementError as error:
            error.recording = path.resolve().name
            return [error]
    inside, closed = _folders(path)
    found: list[Recording | MeasurementError] = []
    others = []
    for folder in inside:
        if _is_recording(folder):
            found.append(_attempt(read_recording, folder, defaults))
        elif files_in(folder, PHOTO_SUFFIXES) or tool_files_in(folder):
            found += _loose_files(folder, defaults)
        else:
            others.append(folder)
    for folder in others:
        if _is_bench(folder, {path.resolve()}):
            found += find_recordings(folder, visited)
    found += [
        MeasurementError(tr("{}: no permission to look into this folder", p), p.name)
        for p in closed
    ]
    found += _loose_files(path, defaults)
    if _is_named_bench(path):
        for suffixes in (VIDEO_SUFFIXES, SOUND_SUFFIXES):
            found += [_attempt(bare_recording, p) for p in files_in(path, suffixes)]
    nothing = tr(
        "{}: nothing to measure here (no recording.toml, no photo, no"
        " video, no sound, no track.csv)",
        path,
    )
    return found or [NothingHere(nothing, path.resolve().name)]


def unread_files(
    path: Path, found: list[Recording | MeasurementError]
) -> list[tuple[Path, list[str]]]:
    """(folder, names) of the files that are not read, in `path` and in the folders of
    the recordings `found`. A table counts only beside evidence, where it may have been
    meant as such."""
    used = {
        f.resolve()
        for r in found
        if isinstance(r, Recording)
        for f in (*r.files, r.sound)
        if f
    }
    folders = {path.resolve(): path} if path.is_dir() else {}
    for file in used:
        folders |= {p: p for p in file.parents if p.is_relative_to(path.resolve())}
    known = (*PHOTO_SUFFIXES, *VIDEO_SUFFIXES, *BESIDE)
    missed = []
    for real, folder in sorted(folders.items()):
        names = [
            f.name
            for f in sorted(real.iterdir())
            if f.is_file() and not f.name.startswith(".") and f not in used
        ]
        meant = any(f.parent == real for f in used)
        if names := [
            n
            for n in names
            if Path(n).suffix.lower() not in known
            or (meant and Path(n).suffix.lower() == ".csv")
        ]:
            missed.append((folder, names))
    return missed


def _attempt(read, *args):
    """`read(*args)`, or its error with the name of the path."""
    try:
        return read(*args)
    except MeasurementError as error:
        error.recording = args[0].name
        return error
    except OSError as error:  # no permission, a broken link, a disk that fails
        return MeasurementError(
            f"{error.filename or args[0]}: {error.strerror or error}", args[0].name
        )


def _folders(path: Path) -> tuple[list[Path], list[Path]]:
    """Readable and unreadable folders in a folder, without hidden ones, lots of seeds
    and results."""
    inside = sorted(
        p for p in path.iterdir() if p.is_dir() and not p.name.startswith(".")
    )
    may = {p: os.access(p, os.R_OK | os.X_OK) for p in inside}
    outputs = (LOT_SUMMARY, RESULTS_MARK)
    open_ = [
        p for p in inside if may[p] and not any((p / name).exists() for name in outputs)
    ]
    return open_, [p for p in inside if not may[p]]


def _is_recording(folder: Path) -> bool:
    files = ("recording.toml", "track.csv", "impacts.csv", "readings.csv", "frames")
    named = any((folder / name).exists() for name in files)
    media = bool(files_in(folder, VIDEO_SUFFIXES)) or (
        bool(files_in(folder, SOUND_SUFFIXES)) and not files_in(folder, PHOTO_SUFFIXES)
    )
    return named or (media and not _is_named_bench(folder))


def _is_bench(folder: Path, visited: set[Path]) -> bool:
    """Whether a folder contains recordings and is no folder of results; folders in
    `visited` are not followed."""
    if (folder / "measurements.csv").is_file() or folder.resolve() in visited:
        return False
    visited.add(folder.resolve())
    if (folder / "bench.toml").is_file():
        return True
    return any(_is_recording(p) or _is_bench(p, visited) for p in _folders(folder)[0])


def _loose_files(folder: Path, defaults: dict) -> list[Recording | MeasurementError]:
    """A recording for each photo and each file of another tool in a folder; for the
    frames of a film that fill it, one."""
    photos, tools = files_in(folder, PHOTO_SUFFIXES), tool_files_in(folder)
    found: list[Recording | MeasurementError] = []
    for stem, names in numbered_runs(p.name for p in photos).items():
        judged = film_or_photos({name: folder / name for name in names})
        if judged.kind == PHOTOS:
            continue
        if len(names) == len(photos) and not tools and not _is_named_bench(folder):
            return [_attempt(read_recording, folder, defaults)]
        photos = [p for p in photos if p.name not in names]
        found.append(MeasurementError(_series_in_words(folder, names, judged), stem))
    found += [_attempt(bare_recording, p) for p in photos]
    return found + [_attempt(bare_recording, p, defaults) for p in tools]


def _is_named_bench(folder: Path) -> bool:
    return (folder / "bench.toml").is_file()


def _series_in_words(folder: Path, names: list[str], judged: Judgement) -> str:
    """What to do with a film's frames, or what may be such, among other files."""
    first, last = names[0], names[-1]
    be = (
        tr("are one film")
        if judged.kind == FILM
        else tr("may be one film or as many photos")
    )
    return tr(
        "{}: {} to {}, {} pictures, {} ({}); put them into a folder of"
        " their own, with a recording.toml that says the rig",
        folder,
        first,
        last,
        len(names),
        be,
        judged.why,
    )
