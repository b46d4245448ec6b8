"""Creep: flattening of a heap from photo to photo of one view; shaking, unlike a gate, goes on."""

from itertools import pairwise

import numpy as np
from scipy.ndimage import uniform_filter1d

SAME_VIEW = 0.5  # correlation of the grains' outline between photos that follow each other
GRAINS = 0.1  # of the heap's height: longer waves are its shape


def creep_deg(piles: list, photos: list) -> float:
    """By how much flanks [deg] flatten from first to last photo; NaN where not comparable."""
    angles = [_angle_deg(photo) for photo in photos]
    if len(piles) < 2 or not np.isfinite(angles).all() or min(_alike(a, b) for a, b in pairwise(piles)) < SAME_VIEW:
        return float("nan")
    turns = np.arange(len(angles))
    return float(-np.polyfit(turns, angles, 1)[0] * turns[-1])


def _angle_deg(photo) -> float:
    """Mean angle of the flanks against the plate, NaN where the camera's tilt is unknown."""
    known = np.isfinite(photo.plate_deg)
    if len(photo.flanks) < 2 and photo.reference != "plate" and not known:
        return float("nan")
    lean = photo.plate_deg if known else 0.0
    return float(np.mean([f.angle_deg - f.side * lean for f in photo.flanks]))


def _alike(one, other) -> float:
    """Correlation of the short waves of two surfaces."""
    count = min(len(one.z), len(other.z))
    if count < 2 or one.unit != other.unit or abs(one.x[0] - other.x[0]) > abs(one.x[1] - one.x[0]):
        return 0.0
    high = max(3, round(GRAINS * float(np.nanmax(one.z - one.base_z)) / float(one.x[1] - one.x[0]))) | 1
    a, b = (_grains(seen.z[:count], high) for seen in (one, other))
    there = np.isfinite(one.z[:count]) & np.isfinite(other.z[:count])
    a, b = a[there], b[there]
    return float(np.corrcoef(a, b)[0, 1]) if len(a) > 2 and a.std() > 0 and b.std() > 0 else 0.0


def _grains(z: np.ndarray, wide: int) -> np.ndarray:
    """A surface (n,) less its mean over `wide` columns."""
    there = np.isfinite(z)
    whole = np.interp(np.arange(len(z)), np.flatnonzero(there), z[there])
    return whole - uniform_filter1d(whole, wide)
