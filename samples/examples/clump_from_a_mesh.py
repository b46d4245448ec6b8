"""A clump from a mesh: a seed's true shape in eight overlapping balls.

The mesh here is an ellipsoid, whose volume is known. Mass and inertia stay the mesh's
own, whatever the balls' union has; what the balls miss is told, in parts of the mean
radius."""

import numpy as np
import plotly.graph_objects as go
import trimesh

from benchtwin.sim.seed.clump import fit_clump
from benchtwin.sim.seed.shape import Shape

ball = trimesh.creation.icosphere(subdivisions=4)
half_mm = np.array([4.36, 3.42, 2.99])
shape = Shape(1e-3 * half_mm * ball.vertices, ball.faces)
centres_m, radii_m, error = fit_clump(shape, 8)
volume_mm3 = 1e9 * shape.volume_m3
by_formula_mm3 = 4 / 3 * np.pi * half_mm.prod()
print(f"{len(radii_m)} balls, surface off by {100 * error.surface_rms:.2f} % (rms)")
print(f"{volume_mm3:.1f} mm³, the ellipsoid's {by_formula_mm3:.1f} mm³")

turn = np.linspace(0, 2 * np.pi, 100)
picture = go.Figure()
for centre, radius in zip(1e3 * centres_m, 1e3 * radii_m, strict=True):
    x, z = centre[0] + radius * np.cos(turn), centre[2] + radius * np.sin(turn)
    picture.add_scatter(x=x, y=z, line_color="#1f5fa8")
x, z = half_mm[0] * np.cos(turn), half_mm[2] * np.sin(turn)
picture.add_scatter(x=x, y=z, line={"color": "#b3261e", "width": 3})
picture.update_layout(showlegend=False, xaxis_title="mm", yaxis_scaleanchor="x")
