"""Readings only: numbers that somebody wrote down are evidence, too.

A bench folder may hold a readings.csv in the place of a film. Four sliding angles with
a mean of 19° are static friction tan 19°; how far they scatter says how well."""

import tempfile
from pathlib import Path

import numpy as np

from benchtwin import measure

angles_deg = [18.0, 19.0, 19.5, 19.5]
bench = Path(tempfile.mkdtemp())
(bench / "slide-01").mkdir()
(bench / "slide-01" / "recording.toml").write_text('rig = "slide"\n')
rows = "\n".join(f"{angle}" for angle in angles_deg)
(bench / "slide-01" / "readings.csv").write_text(f"slide_angle_deg\n{rows}\n")

found = measure(bench)
friction = found.quantities.set_index("quantity").loc["static_friction"]
print(f"static friction {friction['value']:.4f} ± {friction['sd']:.4f}")
by_hand = np.tan(np.radians(np.mean(angles_deg)))

picture = found.plot()
