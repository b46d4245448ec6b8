"""A recording: one run of one rig, measured or simulated, as a folder on disk.

my-bench/bench.toml             defaults for every recording below (same keys; the
                                recording wins)
my-bench/drop-01/recording.toml what is known of this run; an absent key is unknown,
                                never zero
my-bench/drop-01/frames/…       exactly one kind of evidence, looked for in the order
                                of EVIDENCE
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, make_dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import tomli_w

from benchtwin.bench.keys import Air, Camera, Reading, Seed, Tracking
from benchtwin.bench.language import tr
from benchtwin.bench.rigs import RIGS, variant_of
from benchtwin.bench.whole_file import write_whole
from benchtwin.vision.evidence.film_or_photos import (
    FILM,
    LEAST_FRAMES,
    PHOTOS,
    Judgement,
    film_or_photos,
)
from benchtwin.vision.evidence.photo import PHOTO_SUFFIXES
from benchtwin.vision.evidence.read_keys import merge, read_toml, validate
from benchtwin.vision.evidence.sound import SOUND_SUFFIXES, only_sound
from benchtwin.vision.foreign import SUFFIXES as TOOL_SUFFIXES
from benchtwin.vision.foreign import tool_of
from benchtwin.vision.foreign.as_evidence import Evidence, evidence_of
from benchtwin.vision.measurement import MeasurementError, require

VIDEO_SUFFIXES = (".mp4", ".avi", ".mov", ".webm")
TABLES = ("track.csv", "gates.csv", "impacts.csv", "readings.csv")
EVIDENCE = (
    *TABLES,
    "frames",
    "video",
    "sound",
    "photos",
)  # a file of another tool counts as the table that it is converted to
IN_METRES = 1000  # mm_per_px of lengths that are no pixels
CONTRADICTS = 3  # sds between what a photo shows and what is stated beside it
RESULTS_MARK = ".results"  # in a folder of results, in which no recordings are sought
RIG_OF_KIND = {  # evidence that belongs to one rig, and why
    kind: (rig.name, why) for rig in RIGS.values() for kind, why in rig.told_by.items()
}


@dataclass(frozen=True)
class _Recording:
    """One run of one rig: what is known of it (None = unknown) and where its evidence
    lies. `path` is the recording's folder, or the photo itself for a bare photo.
    `evidence` is one of EVIDENCE, `files` the evidence's files in order. `sound` lies
    beside pictures (a video's own track is not named)."""

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

    @property
    def toml(self) -> Path:
        """Where a missing key would have to be written."""
        folder = self.path if self.path.is_dir() else self.path.parent
        return folder / "recording.toml"

    @property
    def variant(self) -> str:
        """The name under which `simulate` knows its rig as it is built; "" without a
        rig."""
        if self.rig is None:
            return ""
        section = getattr(self, self.rig).model_dump(exclude_none=True)
        return variant_of(self.rig, {self.rig: section})

    @property
    def scale_sd(self) -> float:
        """Relative sd that all its lengths share: the camera's scale's; of light gates,
        each of whose places has an sd of its own, 0."""
        return 0.0 if self.evidence == "gates.csv" else self.camera.scale_sd

    @property
    def as_built(self) -> dict[str, float | str]:
        """What is stated of rig and seed that repeats have in common."""
        kind: dict[str, float | str] = {}
        if self.seed.kind:
            kind["kind"] = self.seed.kind
        if self.rig is None:
            return kind
        section = getattr(self, self.rig).model_dump(exclude_none=True)
        return kind | {
            k: float(v) if isinstance(v, (int, float)) else str(v)
            for k, v in RIGS[self.rig].as_built(section).items()
        }

    def sds_beyond_belief(self) -> tuple[str, ...]:
        """Stated standard deviations that are not used as stated, in words."""
        sections = (self.camera, *([getattr(self, self.rig)] if self.rig else []))
        return tuple(line for s in sections for line in s.sds_beyond_belief())

    def need_rig(self) -> str:
        """The rig; MeasurementError naming the file where it is unknown."""
        if self.rig is None:
            raise MeasurementError(
                tr("{}: rig is missing; it is one of {}", self.toml, ", ".join(RIGS))
            )
        return self.rig

    def need(self, key: str, why: str) -> Any:
        """The value of `key` ("section.key"); MeasurementError naming file and key when
        it is unknown."""
        section, name = key.split(".")
        value = getattr(getattr(self, section), name)
        if value is None:
            raise MeasurementError(
                tr(
                    "{}: [{}] {} is missing; it is needed {}",
                    self.toml,
                    section,
                    name,
                    why,
                )
            )
        return value


if TYPE_CHECKING:

    class Recording(_Recording):
        """A recording with the section of each rig: as recording.drop.height_mm."""

        def __init__(self, *known: Any, **sections: Any) -> None: ...
        def __getattr__(self, section: str) -> Any: ...

else:
    Recording = make_dataclass(
        "Recording",
        [
            (rig.name, rig.keys, field(default_factory=rig.keys))
            for rig in RIGS.values()
        ],
        bases=(_Recording,),
        frozen=True,
    )
    Recording.__doc__, Recording.__module__ = _Recording.__doc__, __name__


def read_recording(path: Path, defaults: dict | None = None) -> Recording:
    """Read one recording folder or one bare photo; defaults: the content of bench.toml,
    by default of that beside the folder."""
    path = Path(path)
    if path.is_file():
        return bare_recording(path)
    require(path.is_dir(), tr("{}: no such file or folder", path))
    if defaults is None:
        defaults = _defaults_beside(path)
    toml = path / "recording.toml"
    stated = merge(defaults, read_toml(toml) if toml.is_file() else {})
    evidence, files = _find_evidence(path, validate(stated, toml).rig)
    return _recording(path, path.resolve().name, evidence, files, stated)


def _recording(
    path: Path,
    name: str,
    evidence: str | Evidence,
    files: tuple[Path, ...],
    stated: dict,
) -> Recording:
    """A recording with the keys `stated`; those that a file of another tool states are
    defaults."""
    if isinstance(evidence, Evidence):
        scale = stated.get("camera", {}).get("mm_per_px")
        if evidence.found.unitless and scale not in (None, IN_METRES):
            raise MeasurementError(
                tr(
                    "{}: its lengths have no unit, and [camera] mm_per_px = {} is of"
                    " pixels; write the unit into its heading, such as x (m)",
                    files[0],
                    scale,
                )
            )
        kind, rig = evidence.kind, evidence.rig or None
        stated = merge(evidence.found.keys, stated)
    else:
        kind, (rig, _) = evidence, RIG_OF_KIND.get(evidence, (None, ""))
        if kind == "photos" and _series(files).kind != PHOTOS:
            rig = None
    fields = validate(
        stated, (path if path.is_dir() else path.parent) / "recording.toml"
    )
    filmed = path.is_dir() and kind in ("frames", "video")
    beside = files_in(path, SOUND_SUFFIXES) if filmed else []
    return Recording(
        id=fields.id or name,
        path=path,
        rig=fields.rig or rig,
        evidence=kind,
        files=files,
        sound=_only(path, "sounds", beside) if beside else None,
        session=fields.session,
        provenance=fields.provenance or "measured",
        **{
            name: _seen_of(getattr(fields, name))
            for name in (
                "seed",
                "camera",
                "conditions",
                "reading",
                "air",
                "track",
                *RIGS,
            )
        },
    )


def _seen_of(section: Any) -> Any:
    """A section with what a photo that it names shows: `coverage` of a `plate_photo`.
    MeasurementError where it states another one."""
    file = getattr(section, "plate_photo", None)
    if file is None:
        return section
    from benchtwin.vision.shape.plate_coverage import coverage_of  # loads for .7 s

    seen = coverage_of(Path(file))
    if section.coverage is None:
        told = {"coverage": round(seen.share, 4), "coverage_sd": round(seen.sd, 4)}
        return section.model_copy(update=told)
    off = abs(section.coverage - seen.share)
    stated_sd = section.coverage_sd or 0.0
    require(
        off <= CONTRADICTS * math.hypot(seen.sd, stated_sd),
        tr(
            "{}: seeds cover {:.2f} ± {:.2f} of the plate, and coverage = {:g} is"
            " stated: leave one of both out",
            file,
            seen.share,
            seen.sd,
            section.coverage,
        ),
    )
    return section


def _defaults_beside(path: Path) -> dict:
    file = path.parent / "bench.toml"
    return read_toml(file) if file.is_file() else {}


def write_recording(recording: Recording) -> Path:
    """Write `recording`'s recording.toml into its folder (which holds, or will hold,
    the evidence); returns the file."""
    content: dict = {
        key: getattr(recording, key) for key in ("rig", "id", "session", "provenance")
    } | {"conditions": dict(recording.conditions)}
    own = [recording.rig] if recording.rig else []
    for name in ("seed", "camera", "reading", "air", "track", *own):
        section = getattr(recording, name)
        content[name] = section.model_dump(exclude_none=True, mode="json")
    content = {key: value for key, value in content.items() if value not in (None, {})}
    file = recording.path / "recording.toml"
    recording.path.mkdir(parents=True, exist_ok=True)
    write_whole(file, tomli_w.dumps(content))
    return file


def with_camera(recording: Recording, **keys: Any) -> Recording:
    """The recording with some camera keys replaced (a scale read from a board,
    say)."""
    return replace(recording, camera=recording.camera.model_copy(update=keys))


def among_results(path: Path, bench: Path) -> bool:
    """Whether `path` lies in a folder of `bench` that is marked as results."""
    return any(
        (p / RESULTS_MARK).is_file()
        for p in (path, *path.parents)
        if bench in p.parents
    )


def files_in(folder: Path, suffixes: tuple[str, ...]) -> list[Path]:
    """The files in a folder that end so, by name; none that are hidden."""
    return sorted(
        p
        for p in folder.iterdir()
        if p.suffix.lower() in suffixes and not p.name.startswith(".") and p.is_file()
    )


def bare_recording(path: Path, defaults: dict | None = None) -> Recording:
    """One file by itself, of which nothing is stated but what it says itself and what
    a bench.toml states, by default that beside it; or one inside a recording folder."""
    if (path.parent / "recording.toml").is_file():
        whole = read_recording(path.parent)
        return replace(
            whole, id=f"{whole.id}/{path.stem}", evidence=_kind(path), files=(path,)
        )
    kind = evidence_of(path) if tool_of(path) else _kind(path)
    if kind == "photos":
        return Recording(
            id=path.stem, path=path, rig="pile", evidence="photos", files=(path,)
        )
    stated = _defaults_beside(path) if defaults is None else defaults
    return _recording(path, path.stem, kind, (path,), stated)


def _kind(path: Path) -> str:
    if path.name in EVIDENCE:
        return path.name
    suffix = path.suffix.lower()
    if suffix in VIDEO_SUFFIXES:
        return "sound" if only_sound(path) else "video"
    if suffix in SOUND_SUFFIXES:
        return "sound"
    if suffix in PHOTO_SUFFIXES:
        return "photos"
    if tool_of(path):
        return evidence_of(path).kind
    known = ", ".join((*PHOTO_SUFFIXES, *VIDEO_SUFFIXES, *SOUND_SUFFIXES, *TABLES))
    raise MeasurementError(
        tr(
            "{}: not something to measure (known are {}, and files of other tools)",
            path,
            known,
        )
    )


def tool_files_in(folder: Path) -> list[Path]:
    """The files of other tools in a folder, by name."""
    return [p for p in files_in(folder, TOOL_SUFFIXES) if tool_of(p)]


def _series(photos: Sequence[Path]) -> Judgement:
    """Whether these pictures of one folder are a film, photos, or may be either."""
    return film_or_photos({p.name: p for p in photos})


def _only(folder: Path, what: str, files: list[Path]) -> Path:
    """The one file in a list; MeasurementError where there are several."""
    if len(files) > 1:
        names = ", ".join(file.name for file in files)
        raise MeasurementError(
            tr("{}: {} {}; a recording holds one ({})", folder, len(files), what, names)
        )
    return files[0]


def _find_evidence(
    folder: Path, rig: str | None
) -> tuple[str | Evidence, tuple[Path, ...]]:
    for name in TABLES:
        if (folder / name).is_file():
            return name, (folder / name,)
    if (folder / "frames").is_dir():
        if frames := tuple(files_in(folder / "frames", PHOTO_SUFFIXES)):
            return "frames", frames
        known = ", ".join(PHOTO_SUFFIXES)
        raise MeasurementError(
            tr("{}: the folder holds no frames ({})", folder / "frames", known)
        )
    if videos := files_in(folder, VIDEO_SUFFIXES):
        return _kind(_only(folder, "videos", videos)), tuple(videos)
    if rig != "pile" and (sounds := files_in(folder, SOUND_SUFFIXES)):
        return "sound", (_only(folder, "sounds", sounds),)
    if tools := tool_files_in(folder):
        return evidence_of(_only(folder, tr("files of other tools"), tools)), tuple(
            tools
        )
    if photos := tuple(files_in(folder, PHOTO_SUFFIXES)):
        many = len(photos) >= LEAST_FRAMES
        filmed = _series(photos).kind == FILM if rig is None else rig != "pile"
        return "frames" if many and filmed else "photos", photos
    raise MeasurementError(
        tr(
            "{}: no evidence ({}, frames/, a video, a sound or photos)",
            folder,
            ", ".join(TABLES),
        )
    )
