"""Film of a draw-down → how long the middle of its flow took.

Seeds above the shelf cover A(t) pixels of the part of the picture in which the box is;
their share that is out is (A₀ − A(t))/(A₀ − A_end). What is timed is the way of that
share from `TIMED`[0] to `TIMED`[1]."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.sim.rigs.drawdown import TIMED
from benchtwin.vision.evidence.frames import Frame
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.pile.surface import binarise

EDGE = 3  # frames at either end over whose median the area at rest is taken
LEAST_FRAMES = 12  # of which the flow has some
LEAST_OUT = 0.1  # of the area; less is no flow
# of all that comes out: more than this, out after the first frames or before the last,
# is a flow that the film has not whole
CUT_OFF = TIMED[0] / 2
# separability of seeds and background by grey (Otsu); noise alone gives 0.64
SEPARABLE = 0.7


@dataclass(frozen=True)
class Flow:
    """time_s, and its sd: a frame's length at either end; last: the picture at the
    end."""

    time_s: float
    sd_s: float
    last: np.ndarray


def flow_of(
    frames: Iterable[Frame], region: tuple[int, int, int, int], name: str
) -> Flow:
    """The flow in a film; region: where the box is (left, top, width, height).
    MeasurementError, for the recording `name`, where it cannot be timed."""
    left, top, width, height = region
    threshold, bright = 0.0, True
    times, areas, last = [], [], None
    for frame in frames:
        grey = _grey(frame.pixels)[top : top + height, left : left + width]
        if last is None:
            threshold, separable = binarise(grey)
            if separable < SEPARABLE:
                raise MeasurementError(
                    tr(
                        "{}: seeds and background are too alike in [drawdown] upper_px",
                        name,
                    )
                )
            # the box is filled from below
            low = grey[-max(height // 4, 1) :] > threshold
            bright = bool(low.mean() > 0.5)
        areas.append(float(((grey > threshold) == bright).sum()))
        times.append(frame.t_s)
        last = frame.pixels
    if last is None or len(areas) < LEAST_FRAMES:
        raise MeasurementError(
            tr("{}: {} frames are too few for a flow", name, len(areas))
        )
    if not np.isfinite(times).all():
        raise MeasurementError(
            tr("{}: [camera] fps is missing: a flow needs times", name)
        )
    return _timed(np.array(times), np.array(areas), last, name)


def _timed(t: np.ndarray, area: np.ndarray, last: np.ndarray, name: str) -> Flow:
    begin, end = (
        float(np.median(area[part])) for part in (slice(EDGE), slice(-EDGE, None))
    )
    if begin - end < LEAST_OUT * begin:
        raise MeasurementError(
            tr("{}: nothing flows out of the box in this film", name)
        )
    share = np.maximum.accumulate((begin - area) / (begin - end))
    if share[EDGE] > CUT_OFF:
        raise MeasurementError(
            tr(
                "{}: the film begins when the flow runs already: {:.0%} are out after"
                " {} frames",
                name,
                share[EDGE],
                EDGE,
            )
        )
    if share[-2 * EDGE] < 1 - CUT_OFF:
        raise MeasurementError(tr("{}: the film ends before the flow does", name))
    first, final = (float(np.interp(s, share, t)) for s in TIMED)
    step = float(np.median(np.diff(t)))
    return Flow(final - first, step * float(np.sqrt(2 / 12)), last)


def _grey(pixels: np.ndarray) -> np.ndarray:
    return pixels.mean(axis=2) if pixels.ndim == 3 else pixels.astype(float)
