"""What was followed, drawn in its own picture: crosses on the seed, fitted flights,
impacts, the plate."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from benchtwin.vision.overlay.canvas import WHITE, Canvas

CROSS = (0, 200, 255)
BAD = (255, 60, 60)
CURVE = (255, 220, 0)
MARK = (255, 0, 255)
LINE = (0, 230, 90)
MOST_CROSSES = 160


def on_picture(
    pixels: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    outlier: np.ndarray,
    *,
    curves: Sequence[tuple[ArrayLike, ArrayLike]] = (),
    marks: Sequence[tuple[float, float]] = (),
    lines: Sequence[tuple[Sequence[float], Sequence[float]]] = (),
    caption: str = "",
) -> np.ndarray:
    """uint8 RGB. x, y: columns and rows [px] of the seed; curves: (columns, rows)
    polylines; marks: (column, row) points; lines: ((column, row), (column, row))
    segments."""
    canvas = Canvas(pixels)
    for ends in lines:
        canvas.curve(*np.array(ends).T, LINE, 1.0)
    for columns, rows in curves:
        canvas.curve(columns, rows, CURVE, 1.0)
    for i in _spread(np.asarray(x), np.asarray(y)):
        canvas.cross(x[i], y[i], BAD if outlier[i] else CROSS, 4.0, 1.0)
    for column, row in marks:
        canvas.ring(column, row, MARK)
    if caption:
        canvas.legend([(caption, WHITE)])
    return canvas.pixels


def _spread(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Rows to draw a cross for: MOST_CROSSES at most, evenly along the way; rests count
    once."""
    if len(x) <= MOST_CROSSES:
        return np.arange(len(x))
    path = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    ways = np.linspace(0, path[-1], MOST_CROSSES)
    return np.unique(np.searchsorted(path, ways).clip(0, len(x) - 1))
