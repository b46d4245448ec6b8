"""Way against time of a seed that slides or rolls, as a picture."""

from collections.abc import Sequence

import numpy as np

from benchtwin.vision.measurement import Quantity
from benchtwin.vision.motion.track import Track
from benchtwin.vision.overlay.plot import plot

Curve = tuple[np.ndarray, np.ndarray]
SHOWN = 2  # quantities in a caption


def caption(quantities: Sequence[Quantity]) -> str:
    """The first quantities in words."""
    known = [q for q in quantities if np.isfinite(q.value)]
    said = "; ".join(q.in_words for q in known[:SHOWN])
    return said or "nothing could be measured"


def plot_travel(
    track: Track,
    fitted: Curve | None,
    at: float | None,
    quantities: Sequence[Quantity],
    place: float | None = None,
) -> np.ndarray:
    """A track's x against time with the fitted curve (time, x), marked at a time and
    at a place."""
    marks = []
    if fitted is not None and at is not None:
        marks.append((at, float(np.interp(at, *fitted))))
    if fitted is not None and place is not None:
        marks.append((float(fitted[0][np.argmin(np.abs(fitted[1] - place))]), place))
    return plot(
        track.time,
        track.x,
        track.outlier,
        labels=(f"t [{track.time_unit}]", f"travel [{track.unit}]"),
        curves=[] if fitted is None else [fitted],
        marks=marks,
        caption=caption(quantities),
    )
