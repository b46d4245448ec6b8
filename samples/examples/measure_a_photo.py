"""Measure a photo of a heap: its angle of repose, with a standard deviation.

The picture shows what was found: the surface, the plate's line, and the lines fitted
between 20 and 80 % of the crest's height. Look at it before you believe the number.
This heap was drawn with flanks of 27°."""

from benchtwin import measure

found = measure("samples/drawn-bench/pile-heap")
angles = found.quantities.set_index("quantity")
angle_deg, sd_deg = angles.loc["repose_angle", ["value", "sd"]]
print(f"angle of repose {angle_deg:.2f} ± {sd_deg:.2f}°")

picture = found.picture("pile-heap")
