"""A recording from the bench and one of the twin, read by the same code and laid over
each other."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from benchtwin.bench.rigs import RIGS
from benchtwin.measure.observed import Observed
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import Recording as Recording


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


LEAST_OVERLAP = 0.5  # of the shorter curve
SHIFTS = 801


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
    """What a recording shows: the height of a drop over time, the outline of a pile; in
    mm and s. MeasurementError where nothing can be laid over another.

    relative: a pile's outline in units of its crest's height; timed: a slide over time,
    whatever is known of its tilt."""
    rig = RIGS[recording.need_rig()]
    seen = rig.part("read")(observed.only([recording]))
    if not seen or seen[0].trouble:
        raise MeasurementError(
            seen[0].trouble if seen else f"{recording.path}: nothing could be read"
        )
    return rig.part("curve")(seen[0], relative=relative, timed=timed)


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
