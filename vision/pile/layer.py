"""A layer of single seeds on the plate beside a heap: run-out grains, strewn ones.

Outwards from the crest a heap's surface falls to the plate; where a layer lies about
its foot it falls to the layer's top and stays there. The layer is no heap. Under it the
flank goes on as it came: of the two models of a flank, one line, or a line and then a
level, the second is taken where it explains the surface far better and its level is
longer than any single seed is."""

import numpy as np
from scipy.ndimage import median_filter

from benchtwin.vision.pile.heap import TOE, BaseLine

HIGH = 0.8  # of the crest's height: above it the surface is rounded
TALLEST = 0.45  # of the crest's height
LEAST_LONG = 3.0  # times its own height: a single seed is about as long as high
MOST_INCLINED = 0.2  # of the flank's slope
# of the sum of squares that one line leaves
MOST_LEFT = 0.6


def without_layer(
    profile: np.ndarray, base: BaseLine
) -> tuple[np.ndarray, tuple[str, ...]]:
    """The profile (n,) with both flanks led on to the plate where a layer of seeds
    hides them, and the sides on which one does."""
    height = base.at(np.arange(profile.size)) - profile
    above = np.where(np.isfinite(height), height, 0.0)
    sharp = median_filter(above, 5, mode="nearest")
    if not sharp.max() > 0:
        return profile, ()
    crest, rim = int(sharp.argmax()), _far_rim(sharp, base.pitch_deg)
    led, sides = height.copy(), []
    for side, outwards in (
        ("left", np.arange(crest, -1, -1)),
        ("right", np.arange(crest, sharp.size)),
    ):
        found = _knee(sharp[outwards], rim[outwards], sharp[crest])
        if found is not None:
            knee, at, slope = found
            hidden = outwards[knee:]
            flank = np.clip(at - slope * np.arange(hidden.size), 0.0, None)
            led[hidden] = np.minimum(height[hidden], flank)  # NaN stays
            sides.append(side)
    return base.at(np.arange(profile.size)) - led, tuple(sides)


def _far_rim(height: np.ndarray, pitch_deg: float) -> np.ndarray:
    """How high a camera that looks down sees the far rim of all that lies on the plate
    above its middle: the far half of the ellipse whose near half is the foot."""
    above = np.flatnonzero(height > TOE * height.max())
    middle, half = (above[0] + above[-1]) / 2, max((above[-1] - above[0]) / 2, 1.0)
    u = (np.arange(height.size) - middle) / half
    return half * np.sin(np.radians(pitch_deg)) * np.sqrt(np.clip(1 - u**2, 0, None))


def _knee(
    height: np.ndarray, rim: np.ndarray, top: float
) -> tuple[int, float, float] | None:
    """Where the flank (from the crest outwards) meets a layer, how high it is there,
    and its slope; None where there is no layer."""
    low = np.flatnonzero(height < TOE * top)
    end = int(low[0]) if low.size else height.size
    start = int(np.argmax(height < HIGH * top))
    h, level = height[start:end], (height - rim)[start:end]
    if h.size < 16:
        return None
    x = np.arange(h.size, dtype=float)
    flank, layer = _lines(x, h), _lines(x[::-1], level[::-1])
    knees = np.arange(4, h.size - 4)
    left_over = flank[knees, 2] + layer[h.size - 1 - knees, 3]
    k = int(knees[left_over.argmin()])
    slope, at = -flank[k, 0], flank[k, 1] + flank[k, 0] * k
    thick, inclined = float(level[k:].mean()), abs(layer[h.size - 1 - k, 0])
    is_layer = (
        slope > 0
        and 0 < thick < TALLEST * top
        and h.size - k > LEAST_LONG * thick
        and inclined < MOST_INCLINED * slope
        and left_over.min() < MOST_LEFT * flank[-1, 2]
        and abs(at - h[k:].max()) < thick
    )
    return (start + k, float(at), float(slope)) if is_layer else None


def _lines(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Of the first 1, 2, … n points: slope and intercept of the least-squares line, the
    sum of squares that it leaves, and that about the mean, (n, 4)."""
    n = np.arange(1, x.size + 1)
    sx, sy, sxx, sxy, syy = (np.cumsum(v) for v in (x, y, x * x, x * y, y * y))
    xx, xy, yy = sxx - sx**2 / n, sxy - sx * sy / n, syy - sy**2 / n
    slope = xy / np.maximum(xx, 1e-9)
    return np.c_[slope, (sy - slope * sx) / n, yy - slope * xy, yy]
