"""A recording: one run of one rig, from the bench or from its twin, as a folder on disk.

    my-bench/bench.toml               defaults for every recording below (same keys; the recording wins)
    my-bench/drop-01/recording.toml   what is known of this run; an absent key is unknown, never zero
    my-bench/drop-01/frames/…         exactly one kind of evidence, looked for in the order of EVIDENCE
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import tomli_w

from vision.evidence.keys import Air, Camera, Drop, Drum, Pile, Reading, Roll, Seed, Slide, Tracking, merge, read_toml, validate
from vision.evidence.photo import PHOTO_SUFFIXES
from vision.evidence.sound import SOUND_SUFFIXES, only_sound
from vision.foreign import tool_of
from vision.foreign.evidence import Evidence, evidence_of
from vision.measurement import MeasurementError

RIGS = ("drop", "slide", "roll", "pile", "drum")
VIDEO_SUFFIXES = (".mp4", ".avi", ".mov")
TABLES = ("track.csv", "gates.csv", "impacts.csv", "readings.csv")
EVIDENCE = (*TABLES, "frames", "video", "sound", "photos")  # a file of another tool is the table that it comes down to
LOT_SUMMARY = "lot.toml"  # in a folder that `benchtwin shape` wrote
RESULTS_MARK = ".results"  # in a folder of results, which holds no recordings of the bench it lies in
BESIDE = (".toml", ".csv", ".md", ".txt", ".json", "")  # what lies beside evidence without being any


@dataclass(frozen=True)
class Recording:
    """One run of one rig: what is known of it (None = unknown) and where its evidence lies.

    `path` is the recording's folder, or the photo itself for a bare photo. `evidence` is one of EVIDENCE,
    `files` the evidence's files in order. `sound` lies beside pictures (a video's own track is not named).
    """

    id: str
    path: Path
    rig: str | None
    evidence: str
    files: tuple[Path, ...]
    sound: Path | None = None
    session: str | None = None
    provenance: str = "measured"
    seed: Seed = field(default_factory=Seed)
    camera: Camera = field(default_factory=Camera)
    conditions: Mapping[str, float | str] = field(default_factory=dict, hash=False)
    reading: Reading = field(default_factory=Reading)
    air: Air = field(default_factory=Air)
    track: Tracking = field(default_factory=Tracking)
    drop: Drop = field(default_factory=Drop)
    slide: Slide = field(default_factory=Slide)
    roll: Roll = field(default_factory=Roll)
    pile: Pile = field(default_factory=Pile)
    drum: Drum = field(default_factory=Drum)

    @property
    def toml(self) -> Path:
        """Where a missing key would have to be written."""
        folder = self.path if self.path.is_dir() else self.path.parent
        return folder / "recording.toml"

    def need_rig(self) -> str:
        """The rig; MeasurementError naming the file where nothing says which."""
        if self.rig is None:
            raise MeasurementError(f"{self.toml}: rig is missing; it is one of {', '.join(RIGS)}")
        return self.rig

    def need(self, key: str, why: str) -> Any:
        """The value of `key` ("section.key"); MeasurementError naming file and key when it is unknown."""
        section, name = key.split(".")
        value = getattr(getattr(self, section), name)
        if value is None:
            raise MeasurementError(f"{self.toml}: [{section}] {name} is missing; it is needed {why}")
        return value


def read_recording(path: Path, defaults: dict | None = None) -> Recording:
    """Read one recording folder (with recording.toml) or one bare photo.

    `defaults` is the content of bench.toml; without it, a bench.toml beside the folder is read.
    Raises MeasurementError naming the file and the field.
    """
    path = Path(path)
    if path.is_file():
        return _bare_file(path)
    if not path.is_dir():
        raise MeasurementError(f"{path}: no such file or folder")
    if defaults is None:
        defaults = _defaults_beside(path)
    known = read_toml(path / "recording.toml") if (path / "recording.toml").is_file() else {}
    rig = validate(merge(defaults, known), path / "recording.toml").rig
    evidence, files = _find_evidence(path, rig)
    return _recording(path, path.resolve().name, evidence, files, merge(defaults, known))


def _recording(path: Path, name: str, evidence: str | Evidence, files: tuple[Path, ...], stated: dict) -> Recording:
    """A recording of what is stated; what a file of another tool states counts where nobody states it."""
    if isinstance(evidence, Evidence):
        if evidence.bare and (scale := stated.get("camera", {}).get("mm_per_px")):
            said = f"its lengths have no unit, and [camera] mm_per_px = {scale} is of pixels"
            raise MeasurementError(f"{files[0]}: {said}; write the unit into its heading, such as x (m)")
        kind, rig, stated = evidence.kind, evidence.rig or None, merge(evidence.keys, stated)
    else:
        kind, rig = evidence, "pile" if evidence == "photos" else None
    fields = validate(stated, (path if path.is_dir() else path.parent) / "recording.toml")
    beside = _sounds(path) if path.is_dir() and kind in ("frames", "video") else []
    if len(beside) > 1:
        raise MeasurementError(f"{path}: {len(beside)} sounds; a recording holds one ({', '.join(s.name for s in beside)})")
    return Recording(
        id=fields.id or name,
        path=path,
        rig=fields.rig or rig,
        evidence=kind,
        files=files,
        sound=beside[0] if beside else None,
        session=fields.session,
        provenance=fields.provenance or "measured",
        **{name: getattr(fields, name) for name in ("seed", "camera", "conditions", "reading", "air", "track", *RIGS)},
    )


def _defaults_beside(path: Path) -> dict:
    file = path.parent / "bench.toml"
    return read_toml(file) if file.is_file() else {}


def find_recordings(path: Path, met: set[Path] | None = None) -> list[Recording | MeasurementError]:
    """Every recording under `path`: a photo, a folder of photos, a recording, a bench folder.

    A recording that cannot be read stands in the list as its error, so that the rest of the batch is still measured.
    met: folders looked into already, by another link; they are not looked into again.
    """
    path = Path(path)
    met = set() if met is None else met
    if path.is_dir():
        if path.resolve() in met:
            return []
        met.add(path.resolve())
    if path.is_file() or not path.is_dir() or _is_recording(path):
        return [_attempt(read_recording, path)]
    if path.name == "frames" and not (path / "recording.toml").is_file():
        return [_attempt(read_recording, path.parent)]
    defaults: dict = {}
    if (path / "bench.toml").is_file():
        try:
            defaults = read_toml(path / "bench.toml")
        except MeasurementError as error:
            error.recording = path.resolve().name
            return [error]
    inside, closed = _folders(path)
    folders = [p for p in inside if _is_candidate(p)]
    found = [_attempt(read_recording, p, defaults) if _is_recording(p) else _attempt(_loose_files, p, defaults) for p in folders]
    photos = [_attempt(_bare_file, p) for p in _photos(path)] + [_attempt(_tool_file, p, defaults) for p in _tool_files(path)]
    found += [find_recordings(p, met) for p in inside if p not in folders and _is_bench(p, {path.resolve()})]
    found += [_attempt(_refuse, p) for p in closed]
    flat = [r for entry in (*found, *photos) for r in (entry if isinstance(entry, list) else [entry])]
    if not flat:
        nothing = MeasurementError(f"{path}: nothing to measure here (no recording.toml, no photo, no video, no sound, no track.csv)")
        nothing.recording = path.resolve().name
        return [nothing]
    return flat


def unread(path: Path, found: list[Recording | MeasurementError]) -> list[tuple[Path, list[str]]]:
    """Files that are not read, by folder: under `path`, in it and in the folders that the recordings `found` came from.

    A table is one of them only beside evidence, where it may have been meant to be read; elsewhere it may be anything.
    """
    used = {f.resolve() for r in found if isinstance(r, Recording) for f in (*r.files, r.sound) if f}
    folders = {path.resolve(): path} if path.is_dir() else {}
    for file in used:
        folders |= {p: p for p in file.parents if p.is_relative_to(path.resolve())}
    known = (*PHOTO_SUFFIXES, *VIDEO_SUFFIXES, *BESIDE)
    missed = []
    for real, folder in sorted(folders.items()):
        names = [f.name for f in sorted(real.iterdir()) if f.is_file() and not f.name.startswith(".") and f not in used]
        meant = any(f.parent == real for f in used)
        if names := [n for n in names if Path(n).suffix.lower() not in known or (meant and Path(n).suffix.lower() == ".csv")]:
            missed.append((folder, names))
    return missed


def write_recording(recording: Recording) -> Path:
    """Write `recording`'s recording.toml into its folder (which holds, or will hold, the evidence); returns the file."""
    content: dict = {"rig": recording.rig, "id": recording.id, "session": recording.session, "provenance": recording.provenance}
    content = {key: value for key, value in content.items() if value is not None}
    if recording.conditions:
        content["conditions"] = dict(recording.conditions)
    for name in ("seed", "camera", "reading", "air", "track", recording.rig):
        if name:
            section = getattr(recording, name).model_dump(exclude_none=True, mode="json")
            if section:
                content[name] = section
    file = recording.path / "recording.toml"
    recording.path.mkdir(parents=True, exist_ok=True)
    part = file.with_suffix(".part")
    part.write_text(tomli_w.dumps(content), encoding="utf8")
    part.replace(file)
    return file


def with_camera(recording: Recording, **keys: Any) -> Recording:
    """The recording with some camera keys replaced (a scale read from graph paper, say)."""
    return replace(recording, camera=recording.camera.model_copy(update=keys))


def _attempt(read, *args):
    """What `read` gives, or the error in its place, named after the path."""
    try:
        return read(*args)
    except MeasurementError as error:
        trouble = error
    except OSError as error:  # no permission, a broken link, a disk that fails
        trouble = MeasurementError(f"{error.filename or args[0]}: {error.strerror or error}")
    trouble.recording = args[0].name
    return trouble


def _folders(path: Path) -> tuple[list[Path], list[Path]]:
    """Folders in a folder: those that can be looked into, and those that may not; hidden ones, lots of seeds and results left out."""
    inside = sorted(p for p in path.iterdir() if p.is_dir() and not p.name.startswith("."))
    may = {p: os.access(p, os.R_OK | os.X_OK) for p in inside}
    open_ = [p for p in inside if may[p] and not any((p / name).exists() for name in (LOT_SUMMARY, RESULTS_MARK))]
    return open_, [p for p in inside if not may[p]]


def among_results(path: Path, bench: Path) -> bool:
    """Whether `path` lies in a folder of `bench` that is marked as results."""
    return any((p / RESULTS_MARK).is_file() for p in (path, *path.parents) if bench in p.parents)


def _refuse(folder: Path) -> Recording:
    raise MeasurementError(f"{folder}: no permission to look into this folder")


def _photos(folder: Path) -> list[Path]:
    return _files_ending(folder, PHOTO_SUFFIXES)


def _videos(folder: Path) -> list[Path]:
    return _files_ending(folder, VIDEO_SUFFIXES)


def _sounds(folder: Path) -> list[Path]:
    return _files_ending(folder, SOUND_SUFFIXES)


def _files_ending(folder: Path, suffixes: tuple[str, ...]) -> list[Path]:
    return sorted(p for p in folder.iterdir() if p.suffix.lower() in suffixes and not p.name.startswith(".") and p.is_file())


def _is_recording(folder: Path) -> bool:
    named = any((folder / name).exists() for name in ("recording.toml", "track.csv", "impacts.csv", "readings.csv", "frames"))
    heard = bool(_sounds(folder)) and not _photos(folder)
    return named or ((heard or bool(_videos(folder))) and not (folder / "bench.toml").exists())


def _is_candidate(folder: Path) -> bool:
    return _is_recording(folder) or bool(_photos(folder) or _tool_files(folder))


def _is_bench(folder: Path, met: set[Path]) -> bool:
    """A folder with recordings, not results, in it; links back to what was `met` are not followed."""
    if (folder / "measurements.csv").is_file() or folder.resolve() in met:
        return False
    met.add(folder.resolve())
    if (folder / "bench.toml").is_file():
        return True
    return any(_is_recording(p) or _is_bench(p, met) for p in _folders(folder)[0])


def _loose_files(folder: Path, defaults: dict) -> list[Recording | MeasurementError]:
    photos, tools = _photos(folder), _tool_files(folder)
    return [_attempt(_bare_file, p) for p in photos] + [_attempt(_tool_file, p, defaults) for p in tools]


def _tool_file(path: Path, defaults: dict) -> Recording:
    """A file of another tool without a recording.toml beside it: what the bench states, and what it says itself."""
    recording = _recording(path, path.stem, evidence_of(path), (path,), defaults)
    if recording.rig is None:
        raise MeasurementError(_WHICH_RIG.format(path))
    return recording


def _bare_file(path: Path) -> Recording:
    """A photo (a pile unless a recording.toml beside it says otherwise), or one file inside a recording folder."""
    if (path.parent / "recording.toml").is_file():
        whole = read_recording(path.parent)
        return replace(whole, id=f"{whole.id}/{path.stem}", evidence=_kind(path), files=(path,))
    if _kind(path) == "photos":
        return Recording(id=path.stem, path=path, rig="pile", evidence="photos", files=(path,))
    if tool_of(path):
        return _tool_file(path, _defaults_beside(path))
    raise MeasurementError(_WHICH_RIG.format(path))


_WHICH_RIG = '{}: which rig is this? Put it into a folder of its own with a recording.toml that says rig = "drop" (slide, roll)'


def _kind(path: Path) -> str:
    if path.name in EVIDENCE:
        return path.name
    if path.suffix.lower() in VIDEO_SUFFIXES:
        return "sound" if only_sound(path) else "video"
    if path.suffix.lower() in SOUND_SUFFIXES:
        return "sound"
    if path.suffix.lower() in PHOTO_SUFFIXES:
        return "photos"
    if tool_of(path):
        return evidence_of(path).kind
    known = (*PHOTO_SUFFIXES, *VIDEO_SUFFIXES, *SOUND_SUFFIXES, *TABLES)
    raise MeasurementError(f"{path}: not something to measure (known are {', '.join(known)}, and files of other tools)")


def _tool_files(folder: Path) -> list[Path]:
    return sorted(p for p in folder.iterdir() if not p.name.startswith(".") and p.is_file() and tool_of(p))


def _find_evidence(folder: Path, rig: str | None) -> tuple[str | Evidence, tuple[Path, ...]]:
    for name in TABLES:
        if (folder / name).is_file():
            return name, (folder / name,)
    if (folder / "frames").is_dir():
        frames = tuple(_photos(folder / "frames"))
        if not frames:
            raise MeasurementError(f"{folder / 'frames'}: the folder holds no frames ({', '.join(PHOTO_SUFFIXES)})")
        return "frames", frames
    if videos := _videos(folder):
        if len(videos) > 1:
            raise MeasurementError(f"{folder}: {len(videos)} videos; a recording holds one ({', '.join(v.name for v in videos)})")
        return _kind(videos[0]), tuple(videos)
    if rig != "pile" and (sounds := _sounds(folder)):
        if len(sounds) > 1:
            raise MeasurementError(f"{folder}: {len(sounds)} sounds; a recording holds one ({', '.join(s.name for s in sounds)})")
        return "sound", tuple(sounds)
    if tools := _tool_files(folder):
        if len(tools) > 1:
            names = ", ".join(f.name for f in tools)
            raise MeasurementError(f"{folder}: {len(tools)} files of other tools; a recording holds one ({names})")
        return evidence_of(tools[0]), tuple(tools)
    if photos := _photos(folder):
        return "photos", tuple(photos)
    raise MeasurementError(f"{folder}: no evidence ({', '.join(TABLES)}, frames/, a video, a sound or photos)")
