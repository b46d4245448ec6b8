"""Balls and grains of any size in the twin: restitution as entered, a hollow ball's
inertia as stated."""

import numpy as np
import pytest

from benchtwin.bench.keys import Air, Seed
from benchtwin.sim.rigs.drop import Drop, run_drop
from benchtwin.sim.rigs.roll import Roll, run_roll
from benchtwin.twin.job import Job
from benchtwin.twin.parameters import Parameters, bench

NO_AIR = {
    "drag": {"factor": 0.0}
}  # the same laws as with air: the step loop is compiled once
SMOOTH = Parameters(
    restitution=0.75, static_friction=0.0, rolling_friction=0.0, laws=NO_AIR
)


@pytest.mark.parametrize(
    ("size_mm", "mass_g", "height_m"),
    [(0.5, 1e-4, 0.05), (240.0, 600.0, 1.0), (2000.0, 1e5, 1.0)],
)
def test_a_ball_of_any_size_rebounds_as_entered(size_mm, mass_g, height_m):
    seed = Seed(
        length_mm=size_mm, width_mm=size_mm, thickness_mm=size_mm, mass_g=mass_g
    )
    made = bench(SMOOTH, "drop", seed, Air())
    (ball,) = made.draw(np.random.default_rng(0), 1)
    assert ball.mass_kg == pytest.approx(mass_g / 1000) and len(ball.radii_m) == 1
    rig = Drop(height_m=height_m, bounces=1, plate_m=(max(0.3, 5e-3 * size_mm),) * 2)
    truth = run_drop(rig, made, np.random.default_rng(1), fps=500.0).truth
    # e within 0.5 % at a fifth of the Rayleigh step; a large soft ball sinks in by 1 %
    # of its fall besides
    assert truth["rebound_speed_m_s"] / truth["impact_speed_m_s"] == pytest.approx(
        0.75, rel=0.01
    )
    assert truth["impact_speed_m_s"] == pytest.approx(
        np.sqrt(2 * 9.80665 * height_m), rel=0.01
    )


@pytest.mark.parametrize("factor", [0.1, 0.4, 2 / 3])
def test_a_hollow_ball_rolls_down_as_its_inertia_lets_it(factor):
    seed = Seed(
        length_mm=40, width_mm=40, thickness_mm=40, mass_g=2.7, inertia_factor=factor
    )
    rough = Parameters(static_friction=0.5, rolling_friction=0.0, laws=NO_AIR)
    made = bench(rough, "roll", seed, Air())
    motion = run_roll(
        Roll(incline_deg=5.0, incline_length_m=0.2), made, np.random.default_rng(1)
    )
    fast = np.linalg.norm(motion.velocities_m_s[:, 0], axis=1)
    rows = (motion.t_s > 0.1) & (
        fast < 0.4
    )  # behind the first touch, before the corner
    acceleration = np.polyfit(motion.t_s[rows], fast[rows], 1)[0]
    assert acceleration == pytest.approx(
        9.80665 * np.sin(np.radians(5)) / (1 + factor), rel=0.01
    )


@pytest.mark.parametrize(
    ("roll", "why"),
    [
        ({"level": False}, "run out on a level plate"),
        ({"rail_gap_mm": 6.0}, "no rails"),
    ],
)
def test_what_the_twin_has_not_is_said(tmp_path, roll, why):
    with pytest.raises(ValueError, match=why):
        Job("roll", Parameters(), {"roll": roll})
