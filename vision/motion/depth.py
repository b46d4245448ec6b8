"""A bouncing seed also drifts towards the camera or away from it: nearer it looks larger, and so do its heights and speeds."""

import math

import numpy as np

NEAREST_MM, FARTHEST_MM = 300.0, 20_000.0  # of a camera whose distance nobody stated; each factor of distance as likely


def per_distance(distance_mm: float | None) -> float:
    """1/distance [1/mm]; of an unknown distance the root mean square over all it may be."""
    if distance_mm:
        return 1 / distance_mm
    return math.sqrt((NEAREST_MM**-2 - FARTHEST_MM**-2) / 2 / math.log(FARTHEST_MM / NEAREST_MM))


def drift_share(sideways_mm_s: np.ndarray, lasts_s: np.ndarray, before_mm_s: float, distance_mm: float | None) -> float:
    """Relative sd of a restitution from depth that nobody sees.

    sideways_mm_s, lasts_s: (2,) of the flights before and after. The seed is taken to drift in depth about as fast as it is seen to
    go sideways. Two things follow: the flights' mean depths differ, hence their scales; and a change of depth is seen as one
    of height, the more the further the plate is from the optical axis, for which half a fall at `before_mm_s` stands.
    """
    depth = float(np.hypot(*(sideways_mm_s * lasts_s / 2)))
    lever = before_mm_s**2 / (4 * 9806.65)
    return per_distance(distance_mm) * math.hypot(depth, lever * float(np.hypot(*sideways_mm_s)) / before_mm_s)
