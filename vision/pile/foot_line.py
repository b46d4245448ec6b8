"""Base line of a heap from the lower edge of its segmented outline.

The foot is straight for a level camera and the near half of an ellipse for one that looks down on a round heap. On a shiny plate
the base line lies half-way between the heap and its mirror image.
"""

import numpy as np

from vision.pile.heap import MAX_PLATE_SLOPE, BaseLine
from vision.pile.heap_region import Region

UNKNOWN_PLUMB_SD_DEG = 0.5
MOST_SLOPE = np.tan(np.radians(2.0))
LEANING_SAG = 0.05  # of the heap's height: a larger sag of a leaning heap's foot means that the camera looks down
MIRROR_SAG = 0.4  # of the heap's height: a larger sag means a mirror image (a camera 10° high gives 0.35 at 25°)
LEAST_SEEDS = 8.0  # along the foot, whose errors are independent
MOST_SDS = 3.0  # robust; columns farther off are outliers


def foot_line(region: Region, level: float) -> BaseLine | None:
    """The line through the heap's two toes, in px of the picture; None where the outline shows none.

    level: dy/dx of a level line. It is used for the curved foot of a heap that leans on a wall: tilt and curvature look alike there.
    """
    mask = region.mask
    columns = np.flatnonzero(mask.any(axis=0))
    if columns.size < 16:
        return None
    top = mask[:, columns].argmax(axis=0).astype(float)
    bottom = mask.shape[0] - 1.0 - mask[::-1, columns].argmax(axis=0)
    middle, half = _ellipse_span(columns, top)
    leaning = middle in (columns[0], columns[-1])
    heap_height = float(np.median(bottom) - top.min())
    line, source = _fit_line_and_bow(columns, bottom, middle, half), "foot"
    if leaning and (line[2] > LEANING_SAG * heap_height or abs(line[1] - level) > MOST_SLOPE):
        line, source = _fit_line_and_bow(columns, bottom - level * columns, middle, half, tilted=False), "toe"
        line = (line[0], line[1] + level, line[2], np.radians(UNKNOWN_PLUMB_SD_DEG))
    if line[2] > MIRROR_SAG * heap_height:
        line, source = _fit_line_and_bow(columns, (top + bottom) / 2, middle, half), "mirror"
    intercept, slope, _, slope_sd = line
    if abs(slope) > MAX_PLATE_SLOPE:
        return None
    x0, y0 = region.origin
    f = region.factor
    at = (intercept + 1.0) * f - 0.5 + y0  # the lower border of the lowest pixel
    return BaseLine(float(at - slope * (0.5 * f - 0.5 + x0)), float(slope), float(slope_sd), source)


def _ellipse_span(columns: np.ndarray, top: np.ndarray) -> tuple[float, float]:
    """Middle and half width of the ellipse whose near half is the foot; a heap that leans on a wall shows half of it."""
    left, right = float(columns[0]), float(columns[-1])
    high = columns[top < top.min() + 0.1 * np.ptp(top)]
    crest = float((np.median(high) - left) / (right - left))
    if min(crest, 1 - crest) < 0.2:
        return (left if crest < 0.5 else right), right - left
    return (left + right) / 2, (right - left) / 2


def _fit_line_and_bow(
    x: np.ndarray, y: np.ndarray, middle: float, half: float, tilted: bool = True
) -> tuple[float, float, float, float]:
    """Least squares of y = intercept + slope x + sag √(1 − u²), sag ≥ 0, without outliers: intercept, slope, sag, sd of the slope."""
    bow = np.sqrt(np.clip(1 - ((x - middle) / max(half, 1.0)) ** 2, 0, None))
    keep = np.ones(x.size, dtype=bool)
    for _ in range(6):
        terms = np.c_[np.ones(x.size), (x - middle) * tilted, bow]
        found = np.linalg.lstsq(terms[keep], y[keep], rcond=None)[0]
        if found[2] < 0:
            found = np.r_[np.linalg.lstsq(terms[keep, :2], y[keep], rcond=None)[0], 0.0]
        off = np.abs(y - terms @ found)
        inliers = off <= MOST_SDS * max(1.4826 * float(np.median(off[keep])), 0.7)
        if (inliers == keep).all() or inliers.sum() < 0.4 * x.size:
            break
        keep = inliers
    rms = float(np.sqrt(np.mean(off[keep] ** 2)))
    extent = float(np.sqrt(np.sum((x[keep] - x[keep].mean()) ** 2)))
    sd = np.sqrt(x.size / LEAST_SEEDS) * max(rms, 0.5) / extent
    return float(found[0] - found[1] * middle), float(found[1]), float(found[2]), float(sd)
