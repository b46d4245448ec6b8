"""Are the intervals right? Draw benches whose truth is known, and count.

Two hundred benches of five sliding angles, drawn about a true angle, each read off a
protractor whose zero is off by 0.1° (sd). If value ± 1.96 sd is a 95 % interval, 190 of
them hold the truth, give or take 3. For five readings a normal interval is too short;
the sd allows for that (Student's t)."""

import tempfile
from pathlib import Path

import numpy as np
import plotly.graph_objects as go

from benchtwin import measure

TRUE_DEG, SCATTER_DEG, ZERO_DEG, BENCHES = 18.8, 0.6, 0.1, 200
rng, folder = np.random.default_rng(1), Path(tempfile.mkdtemp())
for k in range(BENCHES):
    place = folder / f"slide-{k:03d}"
    place.mkdir()
    (place / "recording.toml").write_text('rig = "slide"\n')
    angles = rng.normal(TRUE_DEG + rng.normal(0.0, ZERO_DEG), SCATTER_DEG, 5)
    lines = "\n".join(f"{angle:.3f}" for angle in angles)
    (place / "readings.csv").write_text(f"slide_angle_deg\n{lines}\n")

table = measure(folder).quantities.query("quantity == 'slide_angle'")
off = (table["value"] - TRUE_DEG) / table["sd"]
held = (off.abs() < 1.96).sum()
print(f"{held} of {BENCHES} intervals hold the truth")

picture = go.Figure(go.Histogram(x=off, nbinsx=20))
picture.update_layout(xaxis_title="off by so many standard deviations")
for edge in (-1.96, 1.96):
    picture.add_vline(edge, line_dash="dot")
