"""Slides as plain arrays: travel of a block along a tilting plate, or the angles that
somebody read off it."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.rigs.slide.session import ANGLE_MISSING
from benchtwin.twin.pair import Curve
from benchtwin.twin.seen import Observed, no_rows, sections_of, seen_of, track_of
from benchtwin.vision.evidence.tables import read_readings
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.outliers import single_spikes
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording

FRAME_S = 0.01  # of frames of unknown rate: the scale that is fitted then is one of
# length over time squared


@dataclass(frozen=True, eq=False)
class SeenSlide:
    """One slide. Arrays of one length n, outliers left out; none of them (n = 0) where
    only angles were read off.

    x_mm: place along the plate, either way; sd_mm: stated, NaN where not; tilt_deg: of
    the plate at the same time, NaN where not seen, None where nobody looked;
    tilt_sd_deg: of its zero, where a picture shows it; gates: the rows are passages of
    light gates; unit: of places, "px" where a track without a scale is measured.
    angles_deg (m,): readings of the angle at which it slid, a run each. description:
    sections of recording.toml as plain values, `camera.scale_sd` (relative) with what
    holds where nothing is stated. trouble: why there is nothing, "" when there is."""

    recording: str
    session: str
    frame: np.ndarray = field(default_factory=no_rows)
    time_s: np.ndarray = field(default_factory=no_rows)
    x_mm: np.ndarray = field(default_factory=no_rows)
    sd_mm: np.ndarray = field(default_factory=no_rows)
    tilt_deg: np.ndarray | None = None
    angles_deg: np.ndarray = field(default_factory=no_rows)
    description: dict = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    trouble: str = ""
    tilt_sd_deg: float | None = None
    gates: bool = False
    unit: str = "mm"


def read_slides(folder: Path | Observed) -> list[SeenSlide]:
    """Every slide under `folder`; one that cannot be used says why. FileNotFoundError
    without a folder."""
    return list(seen_of(folder, "slide", SeenSlide, _seen, describe))


def _seen(entry: Recording, observed: Observed) -> list[SeenSlide]:
    if entry.evidence == "readings.csv":
        return [readings_of(entry)]
    return [slide_of(track_of(entry, observed), entry)]


def readings_of(recording: Recording) -> SeenSlide:
    """Angles that somebody read off; MeasurementError where there are none."""
    table = read_readings(recording.files[0])
    if "slide_angle_deg" not in table.rows:
        raise MeasurementError(tr("{}: no column slide_angle_deg", recording.files[0]))
    return SeenSlide(
        recording.id,
        recording.session or "",
        angles_deg=table.rows["slide_angle_deg"].dropna().to_numpy(float),
        description=describe(recording),
        notes=table.notes,
    )


def slide_of(track: Track, recording: Recording) -> SeenSlide:
    """A track as a slide; MeasurementError where scale, frame rate or the plate's angle
    is unknown."""
    if track.unit != "mm" or not track.timed:
        missing = (
            tr("scale (mm_per_px)") if track.unit != "mm" else tr("frame rate (fps)")
        )
        raise MeasurementError(
            tr(
                "{}: [camera] {} is missing; a diagnosis needs lengths and times",
                recording.toml,
                missing,
            )
        )
    return seen_slide(without_strays(track), recording)


def without_strays(track: Track) -> Track:
    """The rows that a fit uses."""
    used = track.used()
    return used.marked(single_spikes(used.x)).used()


def seen_slide(track: Track, recording: Recording) -> SeenSlide:
    """A track as it is; MeasurementError where the plate's angle is unknown."""
    stated = recording.slide
    seen = track.tilt_deg is not None and np.isfinite(track.tilt_deg).any()
    if not seen and not stated.tilt_rate_deg_s and stated.start_deg is None:
        raise MeasurementError(f"{recording.toml}: {tr(ANGLE_MISSING)}")
    return SeenSlide(
        recording.id,
        recording.session or "",
        track.frame,
        track.t_s if track.timed else FRAME_S * track.time,
        track.x,
        track.sd,
        track.tilt_deg if seen else None,
        description=describe(recording),
        notes=(*track.notes, *half_stated(recording)),
        tilt_sd_deg=track.tilt_sd_deg,
        gates=recording.evidence == "gates.csv",
        unit=track.unit,
    )


def half_stated(recording: Recording) -> tuple[str, ...]:
    """What is said of a scale's sd without the scale, which tells no share of it."""
    camera = recording.camera
    if camera.mm_per_px_sd is None or camera.mm_per_px:
        return ()
    return (
        tr(
            "[camera] mm_per_px_sd is stated without mm_per_px: lengths are taken as"
            " known to {:g} %",
            100 * camera.scale_sd,
        ),
    )


def describe(recording: Recording) -> dict:
    """Sections of recording.toml as plain values; scale_sd (relative) is always
    there."""
    sections = sections_of(recording, "seed", "camera", "air", "slide")
    sections["camera"] |= {
        "scale_sd": recording.scale_sd,
        "plumb_sd_deg": recording.camera.plumb_sd,
    }
    return sections


def curve(slide: SeenSlide, *, relative: bool, timed: bool) -> Curve:
    """Travel over the plate's tilt, or over time where it is `timed`, or the tilt is
    not known."""
    if not len(slide.x_mm):
        raise MeasurementError(tr("{}: angles read off show no curve", slide.recording))
    travel = np.abs(slide.x_mm - np.median(slide.x_mm[:5]))
    tilts = slide.tilt_deg
    if timed or tilts is None or not np.isfinite(tilts).all():
        return Curve("time (s)", "travel (mm)", slide.time_s, travel, frame=slide.frame)
    # the plate stands still at first
    tilt, which = np.unique(tilts, return_inverse=True)
    mean = np.bincount(which, weights=travel) / np.bincount(which)
    return Curve("tilt (°)", "travel (mm)", tilt, mean, fixed=True)
