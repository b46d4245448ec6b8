"""y against x as a picture, for tracks and times that come without one: points, fitted
curves, marks. OpenCV only."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike

from benchtwin.vision.overlay.canvas import (
    LINE_PX,
    SHOWN_PX,
    text_width,
    wrapped,
    write,
)

CURVE, MARK, POINT, BAD = (220, 120, 0), (255, 0, 255), (90, 140, 200), (255, 0, 0)
INK, GRID = (40, 40, 40), (225, 225, 225)


def plot(
    x: ArrayLike,
    y: ArrayLike,
    outlier: ArrayLike,
    *,
    labels: tuple[str, str],
    curves: Sequence[tuple[ArrayLike, ArrayLike]] = (),
    marks: Sequence[tuple[float, float]] = (),
    caption: str = "",
    size: tuple[int, int] = (960, 620),
) -> np.ndarray:
    """y against x as a picture: points, fitted curves (x, y), marked points."""
    wide, high = size
    shown = max(size) / SHOWN_PX
    line, gap = round(LINE_PX * shown), round(6 * shown)
    image = np.full((high, wide, 3), 255, np.uint8)
    x = np.asarray(x, float)
    y = np.asarray(y, float)
    outlier = np.asarray(outlier, bool)
    good = ~outlier if (~outlier).any() else np.ones(len(x), bool)
    ends = [np.asarray(u, float)[[0, -1]] for u, _ in curves]
    across, up = _range(np.concatenate([x[good], *ends])), _range(y[good])
    caption_lines = wrapped(caption, wide - 2 * gap, shown)
    left = (
        max((text_width(f"{value:.6g}", shown) for value in ticks(*up)), default=0)
        + 2 * gap
    )
    rows = ((len(caption_lines) + 1) * line + gap, high - 2 * line - gap)
    axes = _Axes(across, up, (left, wide - 4 * gap), rows)
    _draw_axes(image, axes, shown)
    fine = round(16 * shown)  # a pixel as shown, in sixteenths of one of the picture
    for i, (column, row) in enumerate(axes.place(x, y)):
        if 0 <= column <= wide and 0 <= row <= high:
            cv2.circle(
                image,
                (round(column * 16), round(row * 16)),
                2 * fine,
                BAD if outlier[i] else POINT,
                -1,
                cv2.LINE_AA,
                4,
            )
    for u, v in curves:
        path = axes.place(u, v)
        path = path[np.isfinite(path).all(axis=1)]
        points = np.round(path * 16).astype(np.int32)
        cv2.polylines(image, [points], False, CURVE, round(shown), cv2.LINE_AA, 4)
    for column, row in (axes.place(u, v)[0] for u, v in marks):
        if np.isfinite([column, row]).all():
            middle = (round(column * 16), round(row * 16))
            cv2.circle(
                image, middle, 5 * fine, MARK, round(1.5 * shown), cv2.LINE_AA, 4
            )
    write(image, labels[0], sum(axes.columns) / 2, high - gap, INK, shown, anchor=0.5)
    write(image, labels[1], gap, axes.rows[0] - gap, INK, shown)
    for k, text in enumerate(caption_lines):
        write(image, text, gap, (k + 0.75) * line, INK, shown)
    return image


@dataclass(frozen=True)
class _Axes:
    """What of x (across) and y (up) is shown, between which columns and rows (top,
    bottom) of the picture."""

    across: tuple[float, float]
    up: tuple[float, float]
    columns: tuple[int, int]
    rows: tuple[int, int]

    def place(self, x: ArrayLike, y: ArrayLike) -> np.ndarray:
        """(column, row) of every point, (n, 2)."""
        (x0, x1), (y0, y1), (left, right), (top, bottom) = (
            self.across,
            self.up,
            self.columns,
            self.rows,
        )
        column = left + (np.asarray(x, float) - x0) / (x1 - x0) * (right - left)
        row = bottom - (np.asarray(y, float) - y0) / (y1 - y0) * (bottom - top)
        return np.column_stack(
            [np.clip(column, -4000, 8000), np.clip(row, -4000, 8000)]
        )


def _draw_axes(image: np.ndarray, axes: _Axes, shown: float) -> None:
    """Grid, its values and a frame."""
    (left, right), (top, bottom), line = axes.columns, axes.rows, LINE_PX * shown
    for value in ticks(*axes.across):
        at = round(float(axes.place(value, axes.up[0])[0, 0]))
        cv2.line(image, (at, top), (at, bottom), GRID, round(shown))
        write(image, f"{value:.6g}", at, bottom + line, INK, shown, anchor=0.5)
    for value in ticks(*axes.up):
        at = round(float(axes.place(axes.across[0], value)[0, 1]))
        cv2.line(image, (left, at), (right, at), GRID, round(shown))
        baseline = at + 0.25 * line
        write(image, f"{value:.6g}", left - 6 * shown, baseline, INK, shown, anchor=1.0)
    cv2.rectangle(image, (left, top), (right, bottom), INK, 1)


def ticks(low: float, high: float) -> np.ndarray:
    """Round values between low and high, about six."""
    rough = (high - low) / 6
    power = 10 ** np.floor(np.log10(rough))
    step = min(
        (s * power for s in (1, 2, 5, 10) if s * power >= rough), default=10 * power
    )
    return np.arange(np.ceil(low / step), np.floor(high / step) + 0.5) * step + 0.0


def _range(values: np.ndarray) -> tuple[float, float]:
    # beyond, a picture has no use for it
    shown = np.clip(values[np.isfinite(values)], -1e15, 1e15)
    low, high = (float(shown.min()), float(shown.max())) if shown.size else (0.0, 0.0)
    pad = 0.04 * (high - low) or max(1.0, 0.04 * abs(high))
    return low - pad, high + pad
