"""y against x as a picture, for tracks and times that come without one: points, fitted curves, marks. OpenCV only."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import ArrayLike

from vision.overlay.canvas import LINE_PX, SHOWN_PX, text_width, wrapped, write

CURVE, MARK, POINT, BAD = (220, 120, 0), (255, 0, 255), (90, 140, 200), (255, 0, 0)
INK, GRID = (40, 40, 40), (225, 225, 225)


def plot(
    x: ArrayLike, y: ArrayLike, outlier: ArrayLike, *, labels: tuple[str, str],
    curves: Sequence[tuple[ArrayLike, ArrayLike]] = (), marks: Sequence[tuple[float, float]] = (), caption: str = "",
    size: tuple[int, int] = (960, 620),
) -> np.ndarray:  # fmt: skip
    """y against x as a picture: points, fitted curves (x, y), marked points."""
    wide, high = size
    shown = max(size) / SHOWN_PX
    line = round(LINE_PX * shown)
    image = np.full((high, wide, 3), 255, np.uint8)
    x, y, outlier = np.asarray(x, float), np.asarray(y, float), np.asarray(outlier, bool)
    good = ~outlier if (~outlier).any() else np.ones(len(x), bool)
    ends = [np.asarray(u, float)[[0, -1]] for u, _ in curves]
    (x0, x1), (y0, y1) = _range(np.concatenate([x[good], *ends])), _range(y[good])

    across, up = ticks(x0, x1), ticks(y0, y1)
    gap = round(6 * shown)
    said = wrapped(caption, wide - 2 * gap, shown)
    left = max((text_width(f"{value:.6g}", shown) for value in up), default=0) + 2 * gap
    right, top, bottom = 4 * gap, (len(said) + 1) * line + gap, 2 * line + gap

    def place(u, v):
        column = left + (np.asarray(u, float) - x0) / (x1 - x0) * (wide - left - right)
        row = high - bottom - (np.asarray(v, float) - y0) / (y1 - y0) * (high - top - bottom)
        return np.column_stack([np.clip(column, -4000, 8000), np.clip(row, -4000, 8000)])

    for value in across:
        at = round(float(place(value, y0)[0, 0]))
        cv2.line(image, (at, top), (at, high - bottom), GRID, round(shown))
        write(image, f"{value:.6g}", at, high - bottom + line, INK, shown, anchor=0.5)
    for value in up:
        at = round(float(place(x0, value)[0, 1]))
        cv2.line(image, (left, at), (wide - right, at), GRID, round(shown))
        write(image, f"{value:.6g}", left - gap, at + 0.25 * line, INK, shown, anchor=1.0)
    fine = round(16 * shown)  # a pixel as shown, in sixteenths of one of the picture
    for i, (column, row) in enumerate(place(x, y)):
        if 0 <= column <= wide and 0 <= row <= high:
            cv2.circle(image, (round(column * 16), round(row * 16)), 2 * fine, BAD if outlier[i] else POINT, -1, cv2.LINE_AA, 4)
    for u, v in curves:
        path = place(u, v)
        path = path[np.isfinite(path).all(axis=1)]
        cv2.polylines(image, [np.round(path * 16).astype(np.int32)], False, CURVE, round(shown), cv2.LINE_AA, 4)
    for column, row in (place(u, v)[0] for u, v in marks):
        if np.isfinite([column, row]).all():
            cv2.circle(image, (round(column * 16), round(row * 16)), 5 * fine, MARK, round(1.5 * shown), cv2.LINE_AA, 4)
    cv2.rectangle(image, (left, top), (wide - right, high - bottom), INK, 1)
    write(image, labels[0], (left + wide - right) / 2, high - gap, INK, shown, anchor=0.5)
    write(image, labels[1], gap, top - gap, INK, shown)
    for k, text in enumerate(said):
        write(image, text, gap, (k + 1) * line - 0.25 * line, INK, shown)
    return image


def ticks(low: float, high: float) -> np.ndarray:
    """Round values between low and high, about six."""
    rough = (high - low) / 6
    power = 10 ** np.floor(np.log10(rough))
    step = min((s * power for s in (1, 2, 5, 10) if s * power >= rough), default=10 * power)
    return np.arange(np.ceil(low / step), np.floor(high / step) + 0.5) * step + 0.0


def _range(values: np.ndarray) -> tuple[float, float]:
    shown = np.clip(values[np.isfinite(values)], -1e15, 1e15)  # beyond, a picture has no use for it
    low, high = (float(shown.min()), float(shown.max())) if shown.size else (0.0, 0.0)
    pad = 0.04 * (high - low) or max(1.0, 0.04 * abs(high))
    return low - pad, high + pad
