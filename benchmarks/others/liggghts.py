"""Spheres and rolling friction of the LIGGGHTS runs that `heaps.py`, `drums.py` and
`orifice_flows.py` are compared with."""

import math
from dataclasses import replace

import numpy as np
import pandas as pd
from scipy import stats

from benchtwin.sim.engine.bodies import V, X
from benchtwin.sim.engine.state import State
from benchtwin.sim.laws import LAWS, Chosen
from benchtwin.sim.material import Contact, Material
from benchtwin.sim.seed import Seed

GRAIN = Material("grain", 1400.0, 4e6, 0.25)  # their E = 1e7 Pa
WALL = Material("wall", 1400.0, 4e6, 0.25)
# of 3.4, 3.7 and 4.0 mm: 25, 50 and 25 % of the mass are 32, 49 and 19 % of the grains
RADII_M, SHARES = (1.7e-3, 1.85e-3, 2.0e-3), (32, 49, 19)
SHEAR = 2 * (1 - GRAIN.poisson_ratio) / (2 - GRAIN.poisson_ratio)  # k_t / k_n, Mindlin


def balls() -> tuple[Seed, ...]:
    """A hundred spheres in their shares, to draw from."""
    middle, density = np.zeros((1, 3)), GRAIN.density_kg_m3
    made = [Seed.from_spheres(middle, np.array([r]), density) for r in RADII_M]
    return tuple(ball for ball, n in zip(made, SHARES) for _ in range(n))


def contact(wall: Material, friction: float, rolling: float, e: float) -> Contact:
    """Grain on another material; rolling friction as a share of the reduced radius."""
    return Contact((GRAIN.name, wall.name), e, friction, rolling, "type_c")


def epsd2(
    mx, my, mz, ax, ay, az, dt, stiffness, normal_force, radius, inertia, mu_r, damping
):
    """LIGGGHTS's epsd2: a spring k_r = k_t R*² between the spins, k_t Mindlin's, cut to
    μ_r F_n R*, without a dashpot. Arguments as in `rolling_type_c`."""
    k_r = SHEAR * stiffness * radius * radius
    mx, my, mz = mx - k_r * ax, my - k_r * ay, mz - k_r * az
    limit = mu_r * normal_force * radius
    size = math.sqrt(mx * mx + my * my + mz * mz)
    if size > limit:
        cut = limit / size
        mx, my, mz = mx * cut, my * cut, mz * cut
    return mx, my, mz, mx, my, mz


def rolling(spring: str = "epsd2") -> Chosen:
    """Their rolling spring, or Ai's type C, which is softer; both without dashpot."""
    law = LAWS["rolling_type_c"]
    if spring == "epsd2":
        law = replace(law, function=epsd2, source="LIGGGHTS's manual, epsd2")
    return law.use(damping=0.0)


def spheres(state: State) -> pd.DataFrame:
    """Places [m], radii [m] and velocities [m/s], as their code reads them."""
    columns = {"radius": state.ball[:, 3]}
    for k, axis in enumerate("xyz"):
        columns |= {
            axis: state.motion[:, X + k],
            f"v{axis}": state.motion[:, V + k],
        }
    return pd.DataFrame(columns)


def told(apart: list[float], sd: float, unit: str) -> str:
    """Mean of ours less theirs with its 95 % interval, and how many agree; sd: of a
    difference, by the scatter of runs."""
    half = stats.t.ppf(0.975, len(apart) - 1) * stats.sem(apart)
    most = 1.96 * sd
    near = int((np.abs(apart) <= most).sum())
    return (
        f"ours less theirs: {np.mean(apart):+.2f} ± {half:.2f} {unit} (95 %)\n"
        f"within {most:.1f} {unit}, 1.96 sd of the difference: {near} of {len(apart)}"
    )
