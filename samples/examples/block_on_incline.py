"""A block on an incline: the engine beside the closed form tan φ = μ.

Four seeds taped together lie on a plate that is tilted slowly. With static friction μ
they slide at φ = arctan μ, whatever their size, mass and modulus."""

import numpy as np
import plotly.graph_objects as go

from benchtwin import Parameters
from benchtwin.sim.rigs.bench import Bench
from benchtwin.sim.rigs.slide import Slide, run_slide

friction = 0.34
on_steel, _ = Parameters(static_friction=friction).contacts()
rig = Slide(start_deg=15.0, tilt_rate_deg_s=4.0, travel_m=0.03)
motion = run_slide(rig, Bench(seed_wall=on_steel), np.random.default_rng(1))
angle_deg = motion.truth["slide_angle_deg"]
by_formula_deg = np.degrees(np.arctan(friction))
print(f"slides at {angle_deg:.2f}°, arctan μ is {by_formula_deg:.2f}°")

at = motion.positions_m[:, 0]
from_hinge_m = np.linalg.norm(at, axis=1)
way_mm = 1e3 * (from_hinge_m[0] - from_hinge_m)
picture = go.Figure(go.Scatter(x=motion.series["tilt_deg"], y=way_mm))
picture.add_vline(by_formula_deg, line_dash="dot")
picture.update_layout(xaxis_title="tilt (°)", yaxis_title="way (mm)")
