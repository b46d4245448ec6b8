"""A bouncing seed also drifts towards the camera or away from it: nearer it looks larger, and so do its heights and speeds."""

import math

import numpy as np

from vision.motion.flight import Flights

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


def drifts(
    flights: Flights, time: np.ndarray, up: np.ndarray, across: np.ndarray, axis: float, distance_mm: float | None
) -> list[np.ndarray]:
    """What the heights `up` (n,) would gain if the seed drifted in depth in one flight as fast as it usually goes sideways: one
    array (n,) a flight. In the flights after it the seed stays as far off. axis: the height that does not change with depth, the
    camera's own. A seed let go has no depth before its first impact beyond what its first flight shows sideways.
    """
    speeds = np.array([np.polyfit(time[r], across[r], 1)[0] if len(r) > 2 else 0.0 for r in flights.rows])
    usual = float(np.sqrt(np.mean(speeds[1:] ** 2))) if len(speeds) > 1 else 0.0
    begins = [time[0], *(flights.meeting(k) for k in range(len(flights.rows) - 1))]
    ends = [*begins[1:], time[-1]]
    out = []
    for k, (begin, end) in enumerate(zip(begins, ends)):
        speed = abs(float(speeds[0])) if k == 0 else max(usual, abs(float(speeds[k])))
        depth = speed * (np.clip(time, begin, end) - begin)
        out.append(-(up - axis) * depth * per_distance(distance_mm))
    return out
