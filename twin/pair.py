"""A recording from the bench and one of the twin, read by the same code and laid over
each other."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from benchtwin.measure.observed import Observed
from benchtwin.twin.piles import SeenPile, read_piles
from benchtwin.twin.roll_tracks import read_rolls
from benchtwin.twin.slides import read_slides
from benchtwin.twin.tracks import track_of
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import Recording as Recording

LEAST_OVERLAP = 0.5  # of the shorter curve
SHIFTS = 801


@dataclass(frozen=True, eq=False)
class Curve:
    """What a recording shows: y (n,) over x (n,), ascending; where x begins is the
    recording's own, unless `fixed`; frame (n,): numbers of the pictures, None of what
    is not over time."""

    x_name: str
    y_name: str
    x: np.ndarray
    y: np.ndarray
    fixed: bool = False
    frame: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class Pair:
    """x (n,) with what both show there, (n,) each; pictures: what the measuring code
    found on either, PNG, b"" for none; frames: the number of either's picture at x,
    (n,) each, None of what is not over time; folder: the twin's recording."""

    rig: str
    recording: str
    x_name: str
    y_name: str
    x: np.ndarray
    bench: np.ndarray
    twin: np.ndarray
    pictures: tuple[bytes, bytes]
    frames: tuple[np.ndarray | None, np.ndarray | None]
    folder: Path


def recordings(folder: Path | Observed) -> dict[str, Recording]:
    """Every readable recording under `folder` by its name, each photo of a pile one of
    its own."""
    entries = Observed.under(folder).entries
    return {r.id: r for r in entries if isinstance(r, Recording)}


def pair(
    bench: Recording,
    twin: Recording,
    *,
    alike: bool = True,
    timed: bool = False,
    observed: Observed | None = None,
) -> Pair:
    """Both read and laid over each other. alike: of one size; else a pile is shown over
    its crest's height; timed: a slide over time, whatever is known of its tilt;
    observed: what was seen on the bench's recordings before.

    Raises MeasurementError where one of them shows no curve, or they do not overlap.
    """
    on_bench = observed or Observed(bench.path, (bench,))
    both = ((bench, on_bench), (twin, Observed(twin.path, (twin,))))
    seen, simulated = (curve(*r, relative=not alike, timed=timed) for r in both)
    # the bench's slide has no tilt sensor: both over time
    if seen.x_name != simulated.x_name:
        seen, simulated = (curve(*r, relative=not alike, timed=True) for r in both)
    if seen.y_name != simulated.y_name:
        said = f"{seen.y_name} cannot be laid over {simulated.y_name}"
        raise MeasurementError(f"{bench.toml}: [camera] mm_per_px is missing; {said}")
    x, y, other = laid_over(seen, simulated)
    later = best_shift(seen, simulated)
    frames = tuple(
        c.frame if c.frame is None else np.interp(x, c.x + by, c.frame)
        for c, by in ((seen, 0.0), (simulated, later))
    )
    drawn = (_picture(*both[0]), _picture(*both[1]))
    return Pair(
        bench.need_rig(),
        bench.id,
        seen.x_name,
        seen.y_name,
        x,
        y,
        other,
        drawn,
        (frames[0], frames[1]),
        twin.path,
    )


def curve(
    recording: Recording,
    observed: Observed,
    *,
    relative: bool = False,
    timed: bool = False,
) -> Curve:
    """Height of a drop over time, travel of a slide over its tilt, way of a roll over
    time, outline of a pile; in mm and s.

    relative: a pile's outline in units of its crest's height; timed: a slide over time,
    whatever is known of its tilt."""
    alone = observed.only([recording])
    if recording.rig == "pile":
        return _outline(_one(read_piles(alone), recording), relative)
    if recording.rig == "roll":
        roll = _one(read_rolls(alone), recording)
        if not len(roll.x_mm):
            raise MeasurementError(
                f"{recording.path}: a run-out that was read off shows no curve"
            )
        start = np.median(roll.x_mm[: max(1, min(5, len(roll.x_mm) // 6))])
        return Curve(
            "time (s)", "way (mm)", roll.time_s, roll.x_mm - start, frame=roll.frame
        )
    if recording.rig == "slide":
        slide = _one(read_slides(alone), recording)
        travel = np.abs(slide.x_mm - np.median(slide.x_mm[:5]))
        if (
            not timed
            and slide.tilt_deg is not None
            and np.isfinite(slide.tilt_deg).all()
        ):
            # the plate stands still at first
            tilt, which = np.unique(slide.tilt_deg, return_inverse=True)
            mean = np.bincount(which, weights=travel) / np.bincount(which)
            return Curve("tilt (°)", "travel (mm)", tilt, mean, fixed=True)
        return Curve("time (s)", "travel (mm)", slide.time_s, travel, frame=slide.frame)
    track = track_of(recording, observed)
    used = track.used()
    if not len(used.t_s):
        raise MeasurementError(f"{recording.path}: no usable row")
    height = used.y - np.nanmin(used.y)
    name = f"height ({track.unit})"
    return Curve("time (s)", name, used.t_s, height, frame=used.frame)


def laid_over(a: Curve, b: Curve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, and both curves there; b shifted along x to where they differ least, unless x
    is fixed.

    Raises MeasurementError without overlap.
    """
    shift = best_shift(a, b)
    both = (a.x >= b.x[0] + shift) & (a.x <= b.x[-1] + shift)
    return a.x[both], a.y[both], np.interp(a.x[both], b.x + shift, b.y)


def best_shift(a: Curve, b: Curve) -> float:
    """What b's x has to be shifted by to lie over a; 0 where x is fixed.
    MeasurementError without overlap."""
    middle = 0.0 if a.fixed and b.fixed else a.x[0] - b.x[0]
    reach = 0.0 if a.fixed and b.fixed else 0.5 * max(np.ptp(a.x), np.ptp(b.x))
    best = (np.inf, 0.0)
    for shift in middle + np.linspace(-reach, reach, SHIFTS if reach else 1):
        both = (a.x >= b.x[0] + shift) & (a.x <= b.x[-1] + shift)
        if both.sum() < 2 or np.ptp(a.x[both]) < LEAST_OVERLAP * min(
            np.ptp(a.x), np.ptp(b.x)
        ):
            continue
        off = float(
            np.sqrt(np.mean((a.y[both] - np.interp(a.x[both], b.x + shift, b.y)) ** 2))
        )
        best = min(best, (off, float(shift)))
    if not np.isfinite(best[0]):
        raise MeasurementError(
            "recording and twin have too little in common to be laid over each other"
            f" ({a.x_name})"
        )
    return best[1]


def _one(seen: list, recording: Recording):
    """The reading of this recording; MeasurementError with its reason where there is
    none."""
    if not seen or seen[0].trouble:
        raise MeasurementError(
            seen[0].trouble if seen else f"{recording.path}: nothing could be read"
        )
    return seen[0]


def _outline(pile: SeenPile, relative: bool) -> Curve:
    """Heights above the plate from the crest's side outwards."""
    height = pile.z - pile.base_z + np.tan(np.radians(pile.base_deg)) * pile.x
    there = np.isfinite(height) & (pile.x >= pile.crest_x)
    x, y = pile.x[there] - pile.crest_x, np.maximum(height[there], 0.0)
    if x.size < 2:
        raise MeasurementError(f"{pile.recording}: no flank to the right of the crest")
    if relative or pile.unit != "mm":
        tall = float(y.max())
        return Curve(
            "distance over the crest's height",
            "height over the crest's height",
            x / tall,
            y / tall,
        )
    return Curve("distance (mm)", "height (mm)", x, y)


def _picture(recording: Recording, observed: Observed) -> bytes:
    """What the measuring code found, drawn on it."""
    drawn = observed.observe(recording).pictures
    if not drawn:
        return b""
    image = next(iter(drawn.values()))
    if image.shape[1] > 900:
        size = (900, round(900 * image.shape[0] / image.shape[1]))
        image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    return cv2.imencode(".png", image[:, :, ::-1] if image.ndim == 3 else image)[
        1
    ].tobytes()
