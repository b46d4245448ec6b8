"""The true outline of a heap of seeds, from their balls: what a distant camera at table height would see."""

from collections.abc import Sequence

import numpy as np

from sim.motion import Motion
from sim.rigs.bench import turned

WINDOW = (0.2, 0.8)  # of the crest's height: between these the line is fitted, as in the picture


def balls(motion: Motion, frame: int = -1) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, 3) and radii (n,) [m] of every ball of every seed that is there."""
    centres, radii = [], []
    for x, q, k in zip(motion.positions_m[frame], motion.orientations[frame], motion.shape_of):
        if np.isfinite(x).all():
            seed = motion.shapes[k]
            centres.append(x + turned(q, seed.centres_m))
            radii.append(seed.radii_m)
    return np.vstack(centres), np.concatenate(radii)


def outline(motion: Motion, x_m: np.ndarray, frame: int = -1) -> np.ndarray:
    """Height [m] of the highest point of any seed over each x [m], whatever its depth y; 0 where there is none."""
    centres, radii = balls(motion, frame)
    height = np.zeros(len(x_m))
    order = np.searchsorted(x_m, centres[:, 0] - radii), np.searchsorted(x_m, centres[:, 0] + radii)
    for c, r, a, b in zip(centres, radii, *order, strict=True):
        across = x_m[a:b] - c[0]
        np.maximum(height[a:b], c[2] + np.sqrt(np.maximum(r * r - across * across, 0.0)), out=height[a:b])
    return height


def slope_angle(x_m: np.ndarray, height_m: np.ndarray, window: Sequence[float] = WINDOW) -> float:
    """Inclination [deg] of the least-squares line through an outline that falls towards +x, between two shares of its crest's
    height: from where it last exceeds the upper to where it first falls below the lower. NaN without such a stretch."""
    crest = height_m.max()
    begin = np.flatnonzero(height_m >= window[1] * crest)[-1]
    below = np.flatnonzero(height_m[begin:] <= window[0] * crest)
    if not len(below) or below[0] < 3:
        return float("nan")
    rows = slice(begin, begin + below[0])
    return float(-np.degrees(np.arctan(np.polyfit(x_m[rows], height_m[rows], 1)[0])))
