"""The line on which a heap of seeds stands, from its own outline: straight for a level camera, the near half of an ellipse for one
that looks down on a round heap, and half-way to its mirror image on a plate that shines."""

import numpy as np

from vision.pile.heap import MAX_PLATE_SLOPE, BaseLine
from vision.pile.region import Region

UNKNOWN_PLUMB_SD_DEG = 0.5
LEVEL = np.tan(np.radians(2.0))
CURVED = 0.05  # of the heap's height: a foot that hangs lower than this away from the wall was seen from above
DEEP = 0.4  # of the heap's height: a foot that hangs lower in the middle holds a mirror image (a camera 10° high: 0.35 at 25°)
SEEDS = 8.0  # independent pieces of the foot at least: the seeds along it
TRIM = 3.0  # robust sds beyond which a column does not count


def foot_line(region: Region, level: float) -> BaseLine | None:
    """The line through the heap's two toes, where it is widest, in px of the picture; None where the outline tells none.

    level: dy/dx of a level line, for the curved foot of a heap that leans on a wall, which does not tell it.
    """
    mask = region.mask
    columns = np.flatnonzero(mask.any(axis=0))
    if columns.size < 16:
        return None
    top = mask[:, columns].argmax(axis=0).astype(float)
    bottom = mask.shape[0] - 1.0 - mask[::-1, columns].argmax(axis=0)
    middle, half = _span(columns, top)
    leaning = middle in (columns[0], columns[-1])
    tall = float(np.median(bottom) - top.min())
    line, source = _fitted(columns, bottom, middle, half), "foot"
    if leaning and (line[2] > CURVED * tall or abs(line[1] - level) > LEVEL):  # a tilt or a bow: from here they look alike
        line, source = _fitted(columns, bottom - level * columns, middle, half, tilted=False), "toe"
        line = (line[0], line[1] + level, line[2], np.radians(UNKNOWN_PLUMB_SD_DEG))
    if line[2] > DEEP * tall:
        line, source = _fitted(columns, (top + bottom) / 2, middle, half), "mirror"
    intercept, slope, _, slope_sd = line
    if abs(slope) > MAX_PLATE_SLOPE:
        return None
    x0, y0 = region.origin
    f = region.factor
    at = (intercept + 1.0) * f - 0.5 + y0  # the lower border of the lowest pixel
    return BaseLine(float(at - slope * (0.5 * f - 0.5 + x0)), float(slope), float(slope_sd), source)


def _span(columns: np.ndarray, top: np.ndarray) -> tuple[float, float]:
    """Middle and half width of the ellipse that the foot would be: about the wall, where the heap leans on one."""
    left, right = float(columns[0]), float(columns[-1])
    high = columns[top < top.min() + 0.1 * np.ptp(top)]
    crest = float((np.median(high) - left) / (right - left))
    if min(crest, 1 - crest) < 0.2:
        return (left if crest < 0.5 else right), right - left
    return (left + right) / 2, (right - left) / 2


def _fitted(
    x: np.ndarray, y: np.ndarray, middle: float, half: float, tilted: bool = True
) -> tuple[float, float, float, float]:
    """y = intercept + slope x + depth √(1 − u²), depth ≥ 0, least squares without what lies off: and the slope's sd."""
    bow = np.sqrt(np.clip(1 - ((x - middle) / max(half, 1.0)) ** 2, 0, None))
    keep = np.ones(x.size, dtype=bool)
    for _ in range(6):
        terms = np.c_[np.ones(x.size), (x - middle) * tilted, bow]
        found = np.linalg.lstsq(terms[keep], y[keep], rcond=None)[0]
        if found[2] < 0:
            found = np.r_[np.linalg.lstsq(terms[keep, :2], y[keep], rcond=None)[0], 0.0]
        off = np.abs(y - terms @ found)
        again = off <= TRIM * max(1.4826 * float(np.median(off[keep])), 0.7)
        if (again == keep).all() or again.sum() < 0.4 * x.size:
            break
        keep = again
    rms = float(np.sqrt(np.mean(off[keep] ** 2)))
    extent = float(np.sqrt(np.sum((x[keep] - x[keep].mean()) ** 2)))
    sd = np.sqrt(x.size / SEEDS) * max(rms, 0.5) / extent
    return float(found[0] - found[1] * middle), float(found[1]), float(found[2]), float(sd)
