"""Rolling seeds beside closed forms."""

import math

import numpy as np
import pytest

from benchtwin.prove.cases import roll
from benchtwin.prove.cases.air import (
    AIR_DENSITY,
    AIR_VISCOSITY,
    drag_number,
    drag_scale,
)
from benchtwin.prove.cases.air import G_M_S2 as G
from benchtwin.prove.cases.bench import Request


def seed(mu: float, way_mm: float = 40.0, **fields: float):
    """A sphere that nothing but rolling friction holds."""
    world = roll.draw(Request(("drag",)), np.random.default_rng(0)).worlds[0]
    plain = {"lot_mu": mu, "way_mm": way_mm, "mu_factor": 1.0, "diameter_mm": 6.0}
    known = {"start_off_mm": 0.0, "incline_off_deg": 0.0, "level_off_deg": 0.0}
    return world._replace(sign=1.0, phase=0.0, **(plain | known | fields))


def run(world, t):
    """Travel [m] and speed [m/s]."""
    x, v = roll.simulate(world, t)
    return x / 1e3, v / 1e3


def test_rolling_runs_out_as_energy_says():
    beta, way, mu = math.radians(15), 0.04, 0.03
    x, v = run(seed(mu), np.arange(0, 4, 1 / 1000))
    expected = way * (math.sin(beta) - mu * math.cos(beta)) / mu
    assert v[-1] == 0
    assert x[-1] - way == pytest.approx(expected, rel=2e-3)


def test_rolling_gathers_speed_at_five_sevenths():
    t = np.arange(0, 0.1, 1 / 1000)
    _, v = run(seed(0.03, 500.0), t)
    a = 5 / 7 * G * (math.sin(math.radians(15)) - 0.03 * math.cos(math.radians(15)))
    np.testing.assert_allclose(v, a * t, atol=1e-6)


def test_slipping_stops_at_the_speed_that_angular_momentum_leaves():
    """v and the slip at the foot, and rolling after it: v falls by two sevenths of the
    slip."""
    beta, way, slip, mu = math.radians(15), 0.04, 0.05, 0.03
    world = roll.with_grip(seed(mu, initial_slip=slip))
    grip, t = world.grip, np.arange(0, 1, 1e-4)
    x, v = run(world, t)
    foot = np.argmax(x > way)
    assert v[foot] == pytest.approx(
        math.sqrt(2 * G * (math.sin(beta) - grip * math.cos(beta)) * way), rel=2e-3
    )
    slips_for = slip / (3.5 * grip * G - 2.5 * mu * G)
    after = np.searchsorted(t, t[foot] + slips_for)
    assert v[after] == pytest.approx(v[foot] - grip * G * slips_for, rel=5e-3)
    slope = (v[after + 500] - v[after + 50]) / (450e-4)
    assert slope == pytest.approx(-5 / 7 * mu * G, rel=0.01)


def test_a_slope_is_seen_with_opposite_signs_in_opposite_directions():
    t = np.arange(0, 4, 1 / 500)
    ends = [
        run(seed(0.03, slope=-s * math.degrees(0.005)), t)[0][-1] for s in (-1, 0, 1)
    ]
    assert ends[0] > ends[1] > ends[2]


def test_a_shape_barrier_can_hold_a_seed_and_never_gives_energy():
    t = np.arange(0, 12, 1 / 500)
    x, v = run(seed(0.01, shape_barrier=0.1), t)
    assert v[-1] == 0
    smooth, _ = run(seed(0.01), t)
    assert x[-1] <= smooth[-1] + 1e-3


def test_air_slows_a_seed_as_its_drag_number_says():
    """Steady rolling downhill: weight along the plate is what friction and air take."""
    slope, mu, air, re = 0.02, 0.002, 5.0, 400.0
    t = np.arange(0, 12, 1 / 500)
    world = seed(mu, slope=math.degrees(slope), air=1.0)
    _, v = run(world._replace(lone_drag=air, re_per_speed=re), t)
    drag = air * drag_number(re * v[-1]) * v[-1] ** 2 / G
    assert v[-1] == pytest.approx(v[-500], rel=1e-3)
    assert drag == pytest.approx(math.sin(slope) - mu * math.cos(slope), rel=1e-2)


def test_a_sphere_in_free_air_has_the_area_and_reynolds_number_of_its_size():
    size, re_per_speed = drag_scale((8.0, 8.0, 8.0), 1200.0)
    mass = 1200 * math.pi / 6 * 8e-3**3
    assert size == pytest.approx(AIR_DENSITY * math.pi / 4 * 8e-3**2 / 2 / mass)
    assert re_per_speed == pytest.approx(AIR_DENSITY * 8e-3 / AIR_VISCOSITY)
