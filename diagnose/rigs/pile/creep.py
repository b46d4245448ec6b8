"""Photos of one heap in turn: whether its flanks go on getting flatter. A gate has done its work by then; what shakes goes on.

Asked only of photos in the same view: the same grains must be seen in the same places, else they show other sides of the heap.
"""

from itertools import pairwise

import numpy as np
from scipy.ndimage import uniform_filter1d

SAME_VIEW = 0.5  # correlation of the grains' outline between photos that follow each other
GRAINS = 0.1  # of the heap's height: longer waves are its shape


def creep_deg(piles: list, photos: list) -> float:
    """How much flatter the flanks [deg] against the plate are in the last photo than in the first, by a line through all.

    piles: twin.piles.SeenPile in their order; photos: flanks.Photo of them. NaN for one photo, for another view, and
    where one flank's angle could be the camera's.
    """
    angles = [_angle_deg(photo) for photo in photos]
    if len(piles) < 2 or not np.isfinite(angles).all() or min(_alike(a, b) for a, b in pairwise(piles)) < SAME_VIEW:
        return float("nan")
    turns = np.arange(len(angles))
    return float(-np.polyfit(turns, angles, 1)[0] * turns[-1])


def _angle_deg(photo) -> float:
    """Mean angle of the flanks against the plate; of one flank NaN where neither plate nor plumb says how the camera stands."""
    lean = photo.plate_deg if np.isfinite(photo.plate_deg) else 0.0
    if len(photo.flanks) < 2 and photo.reference != "plate" and not np.isfinite(photo.plate_deg):
        return float("nan")
    return float(np.mean([f.angle_deg - f.side * lean for f in photo.flanks]))


def _alike(one, other) -> float:
    """Correlation of two surfaces' short waves where both are seen."""
    count = min(len(one.z), len(other.z))
    if count < 2 or one.unit != other.unit or abs(one.x[0] - other.x[0]) > abs(one.x[1] - one.x[0]):
        return 0.0
    high = max(3, round(GRAINS * float(np.nanmax(one.z - one.base_z)) / float(one.x[1] - one.x[0]))) | 1
    a, b = (_grains(seen.z[:count], high) for seen in (one, other))
    there = np.isfinite(one.z[:count]) & np.isfinite(other.z[:count])
    a, b = a[there], b[there]
    return float(np.corrcoef(a, b)[0, 1]) if len(a) > 2 and a.std() > 0 and b.std() > 0 else 0.0


def _grains(z: np.ndarray, wide: int) -> np.ndarray:
    """What is left of a surface (n,) of its mean over `wide` columns."""
    there = np.isfinite(z)
    whole = np.interp(np.arange(len(z)), np.flatnonzero(there), z[there])
    return whole - uniform_filter1d(whole, wide)
