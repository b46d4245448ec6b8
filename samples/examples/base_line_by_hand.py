"""Give the plate's line by hand, where a photo does not show it well.

A base line that is off by a degree turns both flanks: one reads steeper, the other
flatter, and their mean hardly changes. So a heap with two flanks forgives a tilted base
line; a heap against a wall does not."""

import numpy as np

from benchtwin import measure

PHOTO = "samples/drawn-bench/pile-heap"
width_px = measure(PHOTO).picture("pile-heap").shape[1]
foot = measure(PHOTO).observations[0].heap.base  # as it is found: intercept, slope
tilts_deg = np.array([-1.0, 0.0, 1.0])


def turned(tilt_deg: float):
    """Measured with the found line turned about the middle of the picture."""
    slope = foot.slope + np.tan(np.radians(tilt_deg))
    middle = foot.intercept + foot.slope * width_px / 2
    left, right = (middle + slope * (x - width_px / 2) for x in (0.0, width_px))
    return measure(PHOTO, baseline_px=(0.0, left, width_px, right))


by_tilt = [turned(tilt) for tilt in tilts_deg]
angles = [found.quantities.set_index("quantity")["value"] for found in by_tilt]
means_deg = [angle["repose_angle"] for angle in angles]
skew_deg = [a["repose_angle_left"] - a["repose_angle_right"] for a in angles]
print("base line turned by", tilts_deg, "°: mean of the flanks", np.round(means_deg, 2))
print("left less right:", np.round(skew_deg, 2))

picture = by_tilt[2].picture("pile-heap")
