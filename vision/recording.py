"""A recording: one run of one rig, from the bench or from its twin, as a folder on disk.

    my-bench/bench.toml               defaults for every recording below (same keys; the recording wins)
    my-bench/drop-01/recording.toml   what is known of this run; an absent key is unknown, never zero
    my-bench/drop-01/frames/…         exactly one kind of evidence, looked for in the order of EVIDENCE
"""

import difflib
import math
import tomllib
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Literal

import tomli_w
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from vision.evidence.photo import PHOTO_SUFFIXES
from vision.measurement import MeasurementError

RIGS = ("drop", "slide", "roll", "pile")
VIDEO_SUFFIXES = (".mp4", ".avi", ".mov")
EVIDENCE = ("track.csv", "impacts.csv", "readings.csv", "frames", "video", "photos")

# Ranges catch the wrong unit (a 310 m drop), not the unusual bench.
_Number = Annotated[float, Field(allow_inf_nan=False)]
_SeedSize = Annotated[float, Field(gt=0.05, lt=200, allow_inf_nan=False)]
_Length = Annotated[float, Field(gt=0, lt=100_000, allow_inf_nan=False)]
_Angle = Annotated[float, Field(ge=-90, le=90, allow_inf_nan=False)]
_Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
_NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Seed(_Section):
    length_mm: _SeedSize | None = None
    width_mm: _SeedSize | None = None
    thickness_mm: _SeedSize | None = None
    mass_g: Annotated[float, Field(gt=0, lt=1000, allow_inf_nan=False)] | None = None
    density_kg_m3: Annotated[float, Field(gt=10, lt=30_000, allow_inf_nan=False)] | None = None
    count: Annotated[int, Field(ge=1)] | None = None


class Camera(_Section):
    fps: Annotated[float, Field(gt=0, le=5e6, allow_inf_nan=False)] | None = None
    mm_per_px: Annotated[float, Field(gt=1e-5, lt=1000, allow_inf_nan=False)] | None = None
    mm_per_px_sd: _NotNegative | None = None
    plumb_deg: _Angle | None = None
    plumb_sd_deg: _NotNegative | None = None
    exposure_s: Annotated[float, Field(gt=0, lt=10, allow_inf_nan=False)] | None = None

    @property
    def scale_sd(self) -> float:
        """Relative sd of mm_per_px; a scale without a stated sd is not trusted beyond 1 %."""
        if self.mm_per_px is None or self.mm_per_px_sd is None:
            return 0.01
        return self.mm_per_px_sd / self.mm_per_px

    @property
    def plumb_sd(self) -> float:
        """sd of plumb_deg; a plumb line without a stated sd is not known better than 0.5°."""
        return 0.5 if self.plumb_sd_deg is None else self.plumb_sd_deg


class Air(_Section):
    density_kg_m3: Annotated[float, Field(ge=0, lt=2000, allow_inf_nan=False)] = 1.20
    viscosity_pa_s: Annotated[float, Field(ge=0, lt=10, allow_inf_nan=False)] = 1.81e-5


class Drop(_Section):
    height_mm: _Length | None = None


class Slide(_Section):
    tilt_rate_deg_s: Annotated[float, Field(gt=0, lt=1000, allow_inf_nan=False)] | None = None
    travel_mm: _Length | None = None


class Roll(_Section):
    incline_deg: Annotated[float, Field(gt=0, lt=90, allow_inf_nan=False)] | None = None
    incline_length_mm: _Length | None = None
    direction: Literal["+x", "-x"] | None = None


class Pile(_Section):
    box_mm: tuple[_Length, _Length, _Length] | None = None
    gate_mm: tuple[_Length, _Length] | None = None
    plate_mm: tuple[_Length, _Length] | None = None
    fill_height_mm: _Length | None = None
    gate_speed_mm_s: _Positive | None = None


class _File(_Section):
    """All keys of recording.toml; in bench.toml the same."""

    rig: Literal["drop", "slide", "roll", "pile"] | None = None
    id: str | None = None
    session: str | None = None
    provenance: Literal["measured", "simulated", "published"] | None = None
    seed: Seed = Seed()
    camera: Camera = Camera()
    air: Air = Air()
    drop: Drop = Drop()
    slide: Slide = Slide()
    roll: Roll = Roll()
    pile: Pile = Pile()


@dataclass(frozen=True)
class Recording:
    """One run of one rig: what is known of it (None = unknown) and where its evidence lies.

    `path` is the recording's folder, or the photo itself for a bare photo. `evidence` is one of EVIDENCE,
    `files` the evidence's files in order.
    """

    id: str
    path: Path
    rig: str | None
    evidence: str
    files: tuple[Path, ...]
    session: str | None = None
    provenance: str = "measured"
    seed: Seed = field(default_factory=Seed)
    camera: Camera = field(default_factory=Camera)
    air: Air = field(default_factory=Air)
    drop: Drop = field(default_factory=Drop)
    slide: Slide = field(default_factory=Slide)
    roll: Roll = field(default_factory=Roll)
    pile: Pile = field(default_factory=Pile)

    @property
    def toml(self) -> Path:
        """Where a missing key would have to be written."""
        folder = self.path if self.path.is_dir() else self.path.parent
        return folder / "recording.toml"

    def need(self, key: str, why: str):
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
        defaults = _read_toml(path.parent / "bench.toml") if (path.parent / "bench.toml").is_file() else {}
    known = _read_toml(path / "recording.toml") if (path / "recording.toml").is_file() else {}
    fields = _validate(_merge(defaults, known), path / "recording.toml")
    evidence, files = _find_evidence(path)
    return Recording(
        id=fields.id or path.resolve().name,
        path=path,
        rig=fields.rig or ("pile" if evidence == "photos" else None),
        evidence=evidence,
        files=files,
        session=fields.session,
        provenance=fields.provenance or "measured",
        **{name: getattr(fields, name) for name in ("seed", "camera", "air", *RIGS)},
    )


def find_recordings(path: Path) -> list[Recording | MeasurementError]:
    """Every recording under `path`: a photo, a folder of photos, a recording, a bench folder.

    A recording that cannot be read stands in the list as its error, so that the rest of the batch is still measured.
    """
    path = Path(path)
    if path.is_file() or not path.is_dir() or _is_recording(path):
        return [_attempt(read_recording, path)]
    defaults: dict = {}
    if (path / "bench.toml").is_file():
        try:
            defaults = _read_toml(path / "bench.toml")
        except MeasurementError as error:
            return [error]
    folders = sorted(p for p in path.iterdir() if p.is_dir() and not p.name.startswith(".") and _is_candidate(p))
    found = [_attempt(read_recording, p, defaults) if _is_recording(p) else _attempt(_photo_folder, p) for p in folders]
    photos = [_attempt(_bare_file, p) for p in _photos(path)]
    flat = [r for entry in (*found, *photos) for r in (entry if isinstance(entry, list) else [entry])]
    return flat or [MeasurementError(f"{path}: nothing to measure here (no recording.toml, no photo, no video, no track.csv)")]


def write_recording(recording: Recording) -> Path:
    """Write `recording`'s recording.toml into its folder (which holds, or will hold, the evidence); returns the file."""
    content: dict = {"rig": recording.rig, "id": recording.id, "session": recording.session, "provenance": recording.provenance}
    content = {key: value for key, value in content.items() if value is not None}
    for name in ("seed", "camera", "air", recording.rig):
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


def with_camera(recording: Recording, **keys) -> Recording:
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


def _photos(folder: Path) -> list[Path]:
    return _files_ending(folder, PHOTO_SUFFIXES)


def _videos(folder: Path) -> list[Path]:
    return _files_ending(folder, VIDEO_SUFFIXES)


def _files_ending(folder: Path, suffixes: tuple[str, ...]) -> list[Path]:
    return sorted(p for p in folder.iterdir() if p.suffix.lower() in suffixes and not p.name.startswith(".") and p.is_file())


def _is_recording(folder: Path) -> bool:
    named = any((folder / name).exists() for name in ("recording.toml", "track.csv", "impacts.csv", "readings.csv", "frames"))
    return named or (bool(_videos(folder)) and not (folder / "bench.toml").exists())


def _is_candidate(folder: Path) -> bool:
    return _is_recording(folder) or bool(_photos(folder))


def _photo_folder(folder: Path) -> list[Recording]:
    return [_bare_file(p) for p in _photos(folder)]


def _bare_file(path: Path) -> Recording:
    """A photo (a pile unless a recording.toml beside it says otherwise), or one file inside a recording folder."""
    if (path.parent / "recording.toml").is_file():
        whole = read_recording(path.parent)
        return replace(whole, id=f"{whole.id}/{path.stem}", evidence=_kind(path), files=(path,))
    if _kind(path) == "photos":
        return Recording(id=path.stem, path=path, rig="pile", evidence="photos", files=(path,))
    raise MeasurementError(
        f'{path}: which rig is this? Put it into a folder of its own with a recording.toml that says rig = "drop" (slide, roll)'
    )


def _kind(path: Path) -> str:
    if path.name in EVIDENCE:
        return path.name
    if path.suffix.lower() in VIDEO_SUFFIXES:
        return "video"
    if path.suffix.lower() in PHOTO_SUFFIXES:
        return "photos"
    known = (*PHOTO_SUFFIXES, *VIDEO_SUFFIXES, "track.csv", "impacts.csv", "readings.csv")
    raise MeasurementError(f"{path}: not something to measure (known are {', '.join(known)})")


def _find_evidence(folder: Path) -> tuple[str, tuple[Path, ...]]:
    for name in ("track.csv", "impacts.csv", "readings.csv"):
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
        return "video", tuple(videos)
    if photos := _photos(folder):
        return "photos", tuple(photos)
    raise MeasurementError(f"{folder}: no evidence (track.csv, impacts.csv, readings.csv, frames/, a video or photos)")


def _read_toml(path: Path) -> dict:
    try:
        content = tomllib.loads(path.read_text(encoding="utf8"))
    except tomllib.TOMLDecodeError as error:
        raise MeasurementError(f"{path}: not valid TOML: {error}") from error
    except UnicodeDecodeError as error:
        raise MeasurementError(f"{path}: not UTF-8 text (byte {error.start})") from error
    _validate(content, path)  # so that the error names this file, not the one it is merged into
    return content


def _merge(base: dict, over: dict) -> dict:
    """`over` wins, section by section and key by key."""
    merged = dict(base)
    for key, value in over.items():
        merged[key] = {**base[key], **value} if isinstance(value, dict) and isinstance(base.get(key), dict) else value
    return merged


def _validate(content: dict, path: Path) -> _File:
    try:
        return _File.model_validate(content)
    except ValidationError as error:
        raise MeasurementError("\n".join(_explain(e, path) for e in error.errors()[:10])) from error


def _explain(error: dict, path: Path) -> str:
    """One pydantic complaint in a bench worker's words: file, field, what it should hold."""
    *section, key = [str(part) for part in error["loc"] if not isinstance(part, int)] or [""]
    place = f"[{section[0]}] {key}" if section else key
    if error["type"] == "extra_forbidden":
        owner = _File.model_fields[section[0]].annotation if section else _File
        if owner in (Seed, Camera, Air, Drop, Slide, Roll, Pile) or owner is _File:
            known = list(owner.model_fields)
            near = difflib.get_close_matches(key, known, n=1, cutoff=0.5)
            hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(known)}"
            return f"{path}: unknown key {place}; {hint}"
    given = error.get("input")
    if isinstance(given, float | int) and not isinstance(given, bool) and key.endswith("_mm") and math.isfinite(given):
        return f"{path}: {place} = {given} means {given / 1000:g} m: {error['msg'].lower()}; is it in millimetres?"
    return f"{path}: {place} = {given!r}: {error['msg'][0].lower()}{error['msg'][1:]}"
