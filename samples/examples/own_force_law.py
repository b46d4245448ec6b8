"""A force law of your own: a steady wind, in ten lines.

A law is a function of plain numbers that the engine compiles into its step loop. A ball
that falls in a steady wind drifts by ½ (F/m) t²; without air that is exact."""

import numpy as np
import plotly.graph_objects as go

from benchtwin import Bench, Law
from benchtwin.sim.laws import Parameter
from benchtwin.sim.rigs.drop import Drop, run_drop

PUSH_N = 2e-4


def wind(vx, vy, vz, wx, wy, wz, diameter, push):
    """A steady force along x [N], however fast the seed is."""
    return push, 0.0, 0.0, 0.0, 0.0, 0.0


blown = Law("wind", "body", wind, (Parameter("push", "N", -1.0, 1.0, "force along x"),))
bench = Bench(
    sizes=(7e-3, 7e-3, 7e-3),
    spheres=1,
    air_density_kg_m3=0.0,
    laws=(blown.use(push=PUSH_N),),
)
rig = Drop(height_m=0.2, bounces=1, hold_s=0.0)
motion = run_drop(rig, bench, np.random.default_rng(1), fps=500.0)
t, at = motion.t_s, motion.positions_m[:, 0]
falling = t < 0.95 * np.sqrt(2 * 0.2 / 9.80665)
drift_mm = 1e3 * (at[falling, 0] - at[0, 0])
by_formula_mm = 1e3 * 0.5 * PUSH_N / motion.shapes[0].mass_kg * t[falling] ** 2
print(f"drift {drift_mm[-1]:.3f} mm, by the formula {by_formula_mm[-1]:.3f} mm")

dots = go.Scatter(x=drift_mm, y=1e3 * at[falling, 2], mode="markers", name="engine")
line = go.Scatter(x=by_formula_mm, y=1e3 * at[falling, 2], name="½ (F/m) t²")
picture = go.Figure([line, dots])
picture.update_layout(xaxis_title="drift (mm)", yaxis_title="height (mm)")
