"""Sliding blocks beside closed forms."""

import math

import numpy as np
import pytest

from benchtwin.prove.cases import slide
from benchtwin.prove.cases.air import G_M_S2 as G
from benchtwin.prove.cases.bench import Request


def block(mu: float, **fields: float):
    """A block that nothing but friction holds."""
    scene = slide.draw(Request(("adhesion",)), np.random.default_rng(0))
    return scene.worlds[0]._replace(mu=mu, air=0.0, hinge_m=0.2, seeds=1, **fields)


def test_a_block_lets_go_at_the_angle_of_friction():
    t = np.arange(0, 6, 1 / 500)
    world = block(0.35, start_deg=15.0, rate_deg_s=2.0, travel_mm=60.0)
    x, n = slide.simulate(world, t)
    onset = 15 + 2 * t[np.argmax(x > 0)]
    assert onset == pytest.approx(math.degrees(math.atan(0.35)), abs=0.01)
    late = t[:n] - t[np.argmax(x > 0)]
    theta = math.atan(0.35)
    cubic = (
        G * math.radians(2) * (math.cos(theta) + 0.35 * math.sin(theta)) * late**3 / 6
    )
    rows = (late > 0.2) & (late < 0.35)  # t³ while it has not tilted on by much
    np.testing.assert_allclose(x[:n][rows], 1e3 * cubic[rows], rtol=0.05)


@pytest.mark.parametrize(
    "fields",
    [
        {"stribeck": -0.05, "stribeck_m_s": 0.1},
        {"viscous_sliding": 0.1},
        {"partial_rolling": 0.3},
        {"worn_track": 0.5},
        {"air": 1.0, "lone_drag": 0.1, "re_per_speed": 500.0},
    ],
)
def test_what_resists_makes_it_slower(fields):
    t = np.arange(0, 6, 1 / 200)
    world = block(0.35, start_deg=18.0, rate_deg_s=2.0, travel_mm=60.0)
    plain, n = slide.simulate(world, t)
    slower, _ = slide.simulate(world._replace(**fields), t)
    assert slower[n - 1] < plain[n - 1]


def test_it_lets_go_exactly_so_that_an_snr_may_ask_for_slopes():
    """A plate that was tilted a ten-thousandth of a degree more lets go that much
    sooner."""
    world = block(0.35, start_deg=18.0, rate_deg_s=2.0, travel_mm=np.inf)
    t = np.arange(0, 1.6, 1 / 500)
    x, _ = slide.simulate(world, t)
    more, _ = slide.simulate(world._replace(start_deg=18.0 + 1e-4), t)
    speed = np.gradient(x, t)
    late = (x > 1.0)[:-1]
    slope = ((more - x) / 1e-4)[:-1][late]
    np.testing.assert_allclose(slope, speed[:-1][late] / 2.0, rtol=0.02)
