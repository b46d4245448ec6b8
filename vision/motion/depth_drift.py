"""Errors due to motion of a bouncing seed towards the camera or away from it, which changes the scale."""

import math

import numpy as np

from vision.motion.flight import G_MM_S2, Flights

NEAREST_MM, FARTHEST_MM = 300.0, 20_000.0  # of a camera at unknown distance; log-uniform


def inverse_distance(distance_mm: float | None) -> float:
    """1/distance [1/mm]; for an unknown distance its root mean square."""
    if distance_mm:
        return 1 / distance_mm
    return math.sqrt((NEAREST_MM**-2 - FARTHEST_MM**-2) / 2 / math.log(FARTHEST_MM / NEAREST_MM))


def depth_drift_sd(sideways_mm_s: np.ndarray, lasts_s: np.ndarray, before_mm_s: float, distance_mm: float | None) -> float:
    """Relative sd of a restitution due to unseen motion in depth.

    sideways_mm_s, lasts_s: (2,) of the flights before and after. The seed is assumed to move in depth about as fast as sideways. Then the
    scales of the flights differ; and a change of depth looks like one of height, in proportion to the distance of the plate from the
    optical axis, which is assumed to be half a fall at `before_mm_s`.
    """
    depth = float(np.hypot(*(sideways_mm_s * lasts_s / 2)))
    lever = before_mm_s**2 / (4 * G_MM_S2)
    return inverse_distance(distance_mm) * math.hypot(depth, lever * float(np.hypot(*sideways_mm_s)) / before_mm_s)


def depth_drift_shifts(
    flights: Flights, time: np.ndarray, up: np.ndarray, across: np.ndarray, axis: float, distance_mm: float | None
) -> list[np.ndarray]:
    """Changes of the heights `up` (n,) if the seed moved in depth during one flight as fast as
    sideways: one array for each flight. In later flights the depth stays changed. axis: height of
    the optical axis. The first flight's speed in depth is at most the one that it shows
    sideways."""
    speeds = np.array([np.polyfit(time[r], across[r], 1)[0] if len(r) > 2 else 0.0 for r in flights.rows])
    typical = float(np.sqrt(np.mean(speeds[1:] ** 2))) if len(speeds) > 1 else 0.0
    begins = [time[0], *(flights.contact_time(k) for k in range(len(flights.rows) - 1))]
    ends = [*begins[1:], time[-1]]
    out = []
    for k, (begin, end) in enumerate(zip(begins, ends)):
        speed = abs(float(speeds[0])) if k == 0 else max(typical, abs(float(speeds[k])))
        depth = speed * (np.clip(time, begin, end) - begin)
        out.append(-(up - axis) * depth * inverse_distance(distance_mm))
    return out
