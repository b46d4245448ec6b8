"""A ball on an incline: it rolls at 5/7 of g (sin α − μ_r cos α).

Two sevenths go into its spin; rolling friction μ_r, a torque μ_r F_n R in EDEM's
convention, takes its part of what is left. Neither mass nor size is in it."""

import numpy as np
import plotly.graph_objects as go

from benchtwin import Bench, Parameters
from benchtwin.sim.rigs.roll import Roll, run_roll

ALPHA, MU_R, G = np.radians(10.0), 0.02, 9.80665
on_steel, _ = Parameters(static_friction=0.5, rolling_friction=MU_R).contacts()
bench = Bench(
    seed_wall=on_steel, sizes=(7e-3, 7e-3, 7e-3), spheres=1, air_density_kg_m3=0.0
)
rig = Roll(incline_deg=10.0, incline_length_m=0.15, plate_m=(0.05, 0.12))
motion = run_roll(rig, bench, np.random.default_rng(1), fps=500.0)
speed = np.linalg.norm(motion.velocities_m_s[:, 0], axis=1)
rolling = (motion.t_s > 0.05) & (motion.t_s < 0.40)
acceleration = np.polyfit(motion.t_s[rolling], speed[rolling], 1)[0]
by_formula = 5 / 7 * G * (np.sin(ALPHA) - MU_R * np.cos(ALPHA))
print(f"{acceleration:.4f} m/s², by the formula {by_formula:.4f} m/s²")

t = motion.t_s[rolling]
picture = go.Figure(go.Scatter(x=t, y=speed[rolling], mode="markers", name="engine"))
picture.add_scatter(x=t, y=by_formula * t, name="5/7 g (…)")
picture.update_layout(xaxis_title="time (s)", yaxis_title="speed (m/s)")
