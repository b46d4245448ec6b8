"""Least-squares line through one flank of the pile between two heights, with doubts about it."""

from dataclasses import dataclass

import numpy as np

from vision.pile.heap import BaseLine, Flank, Heap
from vision.pile.line import EDGE_FLOOR_PX, Line, fit_line

STEEP_DEG = 50.0  # beyond this an angle is doubtful
# A surface is curved, so that a line is the wrong model, where its local slopes differ by so much within the window and a cubic
# explains this share of the residuals' variance: a curved surface leaves 0.03 of it, grains on a straight one 0.25 and more.
CURVED_DEG, CURVED_SHARE = 8.0, 0.8


@dataclass(frozen=True)
class FlankLine:
    """The line through one flank in the picture [px, y down], and its angle against the horizontal."""

    side: str
    line: Line
    angle_deg: float
    angle_sd_deg: float
    doubts: tuple[str, ...] = ()


def fit_flank(
    surface: np.ndarray, base: BaseLine, heap: Heap, flank: Flank, factor: float, window: tuple[float, float],
    horizontal: float, horizontal_sd: float,
) -> FlankLine | None:  # fmt: skip
    """The line through the flank's surface between the window's heights; None where it is too short, too flat or too rough."""
    x = np.arange(surface.size)
    height = (base.at(x) - surface) / factor
    crest, toe = (heap.crest + 0.5) * factor - 0.5, (flank.toe + 0.5) * factor - 0.5
    side = (x <= crest) & (x >= toe) if flank.side == "left" else (x >= crest) & (x <= toe)
    side &= np.isfinite(height)
    inside = _columns_in_window(x, height, side, heap.height_px, window)
    if inside is None:
        return None
    line = fit_line(x[inside], surface[inside], floor=EDGE_FLOOR_PX)
    doubts = list(_doubts(line))
    margin = 0.01 * surface.size
    if base.source == "toe" and not margin < toe < surface.size - 1 - margin:
        doubts.append(f"the pile is cut by the picture's {flank.side} border: the window is of the height that shows")
    sign = 1 if flank.side == "right" else -1
    angle = sign * (line.angle_deg - horizontal)
    rise = abs(line.slope) * (line.x_high - line.x_low)
    if angle < 3 or line.rms > 0.25 * rise:
        return None
    if angle > STEEP_DEG:
        doubts.append(f"steeper than {STEEP_DEG:.0f}°: is the picture turned, or is this no slope of grains?")
    return FlankLine(flank.side, line, angle, float(np.hypot(line.angle_sd_deg, horizontal_sd)), tuple(doubts))


def _columns_in_window(x, height, side, top, window) -> np.ndarray | None:
    """Columns whose fitted height lies in the window: a cubic through the flank, refitted until it selects the same columns.

    Points are not selected by their own height: that would cut the bumps off at both ends and flatten the line.
    """
    low, high = window[0] * top, window[1] * top
    inside = side & (height > low) & (height < high)
    wider = side & (height > low - 0.1 * top) & (height < high + 0.1 * top)
    for _ in range(5):
        if inside.sum() < 12 or wider.sum() < 12:
            return None
        cubic = np.polynomial.Polynomial.fit(x[wider], height[wider], 3)
        columns = np.flatnonzero(side & (x >= x[wider].min()) & (x <= x[wider].max()))
        fitted = cubic(columns)
        chosen = columns[(fitted > low) & (fitted < high)]
        if chosen.size < 12:
            return None
        columns_now = side & (x >= chosen.min()) & (x <= chosen.max())
        margin = 0.17 * (chosen.max() - chosen.min())
        wider = side & (x >= chosen.min() - margin) & (x <= chosen.max() + margin)
        if (columns_now == inside).all():
            break
        inside = columns_now
    return inside


def _doubts(line: Line):
    bend = np.degrees(np.arctan(line.slope_high) - np.arctan(line.slope_low))
    if bend > CURVED_DEG and line.cubic_share > CURVED_SHARE:
        low, high = sorted(abs(np.degrees(np.arctan([line.slope_low, line.slope_high]))))
        yield f"the surface is bent ({low:.0f}° to {high:.0f}° inside the window): one line is the wrong model"
    if line.outlier_share > 0.1:
        yield f"{100 * line.outlier_share:.0f} % of the surface lies off the line and was left out"
