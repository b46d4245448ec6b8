"""The true outline of a heap of seeds, from their balls: what a distant camera at table
height would see."""

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import uniform_filter1d

from benchtwin.bench.slope_window import line_window
from benchtwin.sim.motion import Motion
from benchtwin.sim.rotation import turned

# of the crest's height: what is lower does not count for the centroid, and where a pile
# ends
FOOT = 0.1
TOE = 0.02
GAP_M = 5e-3
# of the crest's height: between these the line is fitted, as in the picture
WINDOW = (0.2, 0.8)


def balls(motion: Motion, frame: int = -1) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, 3) and radii (n,) [m] of every ball of every seed that is there."""
    centres, radii = [], []
    for x, q, k in zip(
        motion.positions_m[frame], motion.orientations[frame], motion.shape_of
    ):
        if np.isfinite(x).all():
            seed = motion.shapes[k]
            centres.append(x + turned(q, seed.centres_m))
            radii.append(seed.radii_m)
    return np.vstack(centres), np.concatenate(radii)


def outline(motion: Motion, x_m: np.ndarray) -> np.ndarray:
    """Height [m] of the highest point of any seed over each x [m], whatever its depth
    y; 0 where there is none."""
    return upper_edge(*balls(motion), x_m, 0.0)


def upper_edge(
    centres: np.ndarray, radii: np.ndarray, x_m: np.ndarray, without: float
) -> np.ndarray:
    """Height [m] of the highest ball over each x [m], `without` where there is none."""
    height = np.full(len(x_m), without)
    ends = (np.searchsorted(x_m, centres[:, 0] + s * radii) for s in (-1, 1))
    for c, r, a, b in zip(centres, radii, *ends, strict=True):
        across = x_m[a:b] - c[0]
        below = np.maximum(r * r - across * across, 0.0)
        np.maximum(height[a:b], c[2] + np.sqrt(below), out=height[a:b])
    return height


def slope_angle(
    x_m: np.ndarray, height_m: np.ndarray, window: Sequence[float] = WINDOW
) -> float:
    """Inclination [deg] of the least-squares line through an outline that falls towards
    +x, where it lies between two shares of its crest's height; NaN without such a
    slope."""
    top = float(height_m.max())
    side = np.arange(len(x_m)) >= int(
        np.argmax(uniform_filter1d(height_m, max(3, len(x_m) // 50)))
    )
    side &= np.cumsum(height_m[::-1] > 0.02 * top)[::-1] > 0
    inside = line_window(x_m, height_m, side, window[0] * top, window[1] * top)
    if inside is None:
        return float("nan")
    slope = np.polyfit(x_m[inside], height_m[inside], 1)[0]
    # a heap of a layer or two has no slope
    return float(-np.degrees(np.arctan(slope))) if slope < 0 else float("nan")


def centroid_angle(
    x_m: np.ndarray, height_m: np.ndarray, wall_m: float | None = None
) -> float:
    """Inclination [deg] of the straight pile whose centroid lies where this one's does:
    atan(z̄ / x̄) of what stands higher than FOOT of the crest, z̄ from there, x̄ from
    the wall that the pile leans on, or without a wall the mean distance from the heap's
    own axis. NaN for nothing.

    All of the outline from toe to toe counts, so that no single seed decides. A toe is
    where, outwards from the crest, the outline averaged over GAP_M first falls below
    TOE of the crest: seeds that rolled farther do not count."""
    top, crest = float(height_m.max()), int(np.argmax(height_m))
    bare = (
        uniform_filter1d(height_m, max(1, round(GAP_M / (x_m[1] - x_m[0])))) < TOE * top
    )
    right = np.cumsum(bare[crest:]) == 0
    left = (np.cumsum(bare[crest::-1]) == 0)[::-1]
    above = np.clip(height_m - FOOT * top, 0.0, None) * np.r_[left[:-1], right]
    area = float(above.sum())
    if not area > 0:
        return float("nan")
    axis = float((x_m * above).sum()) / area if wall_m is None else wall_m
    reach = float((np.abs(x_m - axis) * above).sum()) / area
    return float(np.degrees(np.arctan2(float((above**2).sum()) / 2 / area, reach)))
