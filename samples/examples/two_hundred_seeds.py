"""A box of 200 soybeans: what the floor carries, and what the sides do.

At rest, the floor and the sides together carry the weight exactly, for nothing moves.
How they share it the weight does not tell: friction remembers how the seeds came to
lie. Let fall all at once, these rebounded, and the sides now hold them down."""

import numpy as np
import plotly.graph_objects as go

from benchtwin import Seed
from benchtwin.sim.engine.observe import Settled
from benchtwin.sim.engine.step import init, run
from benchtwin.sim.engine.walls import box
from benchtwin.sim.engine.world import Scattered, World
from benchtwin.sim.material import Q235, SOYBEAN, SOYBEAN_Q235, SOYBEAN_SOYBEAN

SIDE_M = 0.035
bean, soft = Seed.from_dimensions(8.72e-3, 6.84e-3, 5.98e-3), SOYBEAN.softened(3e6)
beans = Scattered((bean,), soft, 200, low=(0, 0, 0), high=(SIDE_M, SIDE_M, 0.5))
walls = box("box", Q235, (0, 0, 0), (SIDE_M, SIDE_M, 0.5))
world = World((beans,), walls, (SOYBEAN_Q235, SOYBEAN_SOYBEAN))
at_rest = Settled(window_s=0.05, displacement=1e-2, kinetic=1e-5)
state = run(world, init(world, np.random.default_rng(1)), at_rest, threads=1)

weight_n = 9.80665 * state.masses.sum()
carried_n = -state.wall_load[:, 2]
floor_share = carried_n[world.wall_index("box-floor")] / weight_n
height_m = np.quantile(state.positions[:, 2], 0.98)
print(f"{1e3 * height_m:.0f} mm high; the floor carries {100 * floor_share:.0f} %")

x, y, z = (1e3 * state.positions).T
marker = {"size": 9, "color": z, "colorscale": "Viridis"}
picture = go.Figure(go.Scatter(x=x, y=z, mode="markers", marker=marker))
picture.update_layout(xaxis_title="across (mm)", yaxis_title="height (mm)")
picture.update_yaxes(scaleanchor="x")
