"""y against x as a picture, for tracks and times that come without one: points, fitted curves, marks. OpenCV only."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import ArrayLike

from vision.overlay.canvas import FONT, plain

CURVE, MARK, POINT, BAD = (220, 120, 0), (255, 0, 255), (90, 140, 200), (255, 0, 0)
INK, GRID = (40, 40, 40), (225, 225, 225)


def plot(
    x: ArrayLike, y: ArrayLike, outlier: ArrayLike, *, labels: tuple[str, str],
    curves: Sequence[tuple[ArrayLike, ArrayLike]] = (), marks: Sequence[tuple[float, float]] = (), caption: str = "",
    size: tuple[int, int] = (1200, 700),
) -> np.ndarray:  # fmt: skip
    """y against x as a picture: points, fitted curves (x, y), marked points."""
    wide, high = size
    left, right, top, bottom = 90, 20, 46, 60
    image = np.full((high, wide, 3), 255, np.uint8)
    x, y, outlier = np.asarray(x, float), np.asarray(y, float), np.asarray(outlier, bool)
    good = ~outlier if (~outlier).any() else np.ones(len(x), bool)
    ends = [np.asarray(u, float)[[0, -1]] for u, _ in curves]
    (x0, x1), (y0, y1) = _range(np.concatenate([x[good], *ends])), _range(y[good])

    def place(u, v):
        column = left + (np.asarray(u, float) - x0) / (x1 - x0) * (wide - left - right)
        row = high - bottom - (np.asarray(v, float) - y0) / (y1 - y0) * (high - top - bottom)
        return np.column_stack([np.clip(column, -4000, 8000), np.clip(row, -4000, 8000)])

    for value in ticks(x0, x1):
        at = round(float(place(value, y0)[0, 0]))
        cv2.line(image, (at, top), (at, high - bottom), GRID, 1)
        _text(image, f"{value:.6g}", (at - 18, high - bottom + 20))
    for value in ticks(y0, y1):
        at = round(float(place(x0, value)[0, 1]))
        cv2.line(image, (left, at), (wide - right, at), GRID, 1)
        _text(image, f"{value:.6g}", (14, at + 4))
    for i, (column, row) in enumerate(place(x, y)):
        if 0 <= column <= wide and 0 <= row <= high:
            cv2.circle(image, (round(column * 16), round(row * 16)), 40, BAD if outlier[i] else POINT, -1, cv2.LINE_AA, 4)
    for u, v in curves:
        path = place(u, v)
        path = path[np.isfinite(path).all(axis=1)]
        cv2.polylines(image, [np.round(path * 16).astype(np.int32)], False, CURVE, 2, cv2.LINE_AA, 4)
    for column, row in (place(u, v)[0] for u, v in marks):
        if np.isfinite([column, row]).all():
            cv2.circle(image, (round(column * 16), round(row * 16)), 7 * 16, MARK, 2, cv2.LINE_AA, 4)
    cv2.rectangle(image, (left, top), (wide - right, high - bottom), INK, 1)
    _text(image, labels[0], (wide // 2 - 40, high - 14))
    _text(image, labels[1], (14, top - 6))
    _text(image, caption, (10, 23), 0.55)
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


def _text(image: np.ndarray, text: str, at: tuple[int, int], size: float = 0.45) -> None:
    cv2.putText(image, plain(text), at, FONT, size, INK, 1, cv2.LINE_AA)
