"""Sliding blocks and rolling seeds beside closed forms."""

import math

import numpy as np
import pytest

from benchtwin.prove.cases import ground_motion as ground
from benchtwin.prove.cases.flight_laws import drag_number
from benchtwin.prove.cases.roll import slip_friction
from benchtwin.prove.cases.stated import drag_scale

G = ground.G_M_S2


def block(mu: float, **more: float) -> np.ndarray:
    out = np.zeros(ground.BLOCK)
    out[[ground.STATIC, ground.KINETIC]] = mu
    out[ground.HINGE] = 0.2
    for name, value in more.items():
        out[getattr(ground, name)] = value
    return out


def seed(mu: float, **more: float) -> np.ndarray:
    out = np.zeros(ground.SEED)
    out[ground.ROLLING], out[ground.RADIUS] = mu, 3e-3
    for name, value in more.items():
        out[getattr(ground, name)] = value
    return out


def test_a_block_lets_go_at_the_angle_of_friction():
    t = np.arange(0, 6, 1 / 500)
    x, _, n = ground.slide(t, math.radians(15), math.radians(2), block(0.35), 0.06)
    onset = 15 + 2 * t[np.argmax(x > 0)]
    assert onset == pytest.approx(math.degrees(math.atan(0.35)), abs=0.01)
    late = t[:n] - t[np.argmax(x > 0)]
    theta = math.atan(0.35)
    cubic = (
        G * math.radians(2) * (math.cos(theta) + 0.35 * math.sin(theta)) * late**3 / 6
    )
    rows = (late > 0.2) & (late < 0.35)  # t³ while it has not tilted on by much
    np.testing.assert_allclose(x[:n][rows], cubic[rows], rtol=0.05)


@pytest.mark.parametrize(
    ("name", "value"),
    [("FALLING", 0.05), ("VISCOUS", 0.1), ("ADDED", 0.3), ("WORN", 0.5), ("AIR", 0.1)],
)
def test_what_resists_makes_it_slower(name, value):
    t = np.arange(0, 6, 1 / 200)
    more = {name: value} | {
        "FALLING": {"STRIBECK_SPEED": 0.1},
        "AIR": {"REYNOLDS": 500.0},
    }.get(name, {})
    plain, _, n = ground.slide(t, math.radians(18), math.radians(2), block(0.35), 0.06)
    slower, _, _ = ground.slide(
        t, math.radians(18), math.radians(2), block(0.35, **more), 0.06
    )
    assert slower[n - 1] < plain[n - 1]


def test_rolling_runs_out_as_energy_says():
    beta, way, mu = math.radians(15), 0.04, 0.03
    x, v = ground.roll(np.arange(0, 4, 1 / 1000), way, beta, seed(mu))
    expected = way * (math.sin(beta) - mu * math.cos(beta)) / mu
    assert v[-1] == 0
    assert x[-1] - way == pytest.approx(expected, rel=2e-3)


def test_rolling_gathers_speed_at_five_sevenths():
    t = np.arange(0, 0.1, 1 / 1000)
    _, v = ground.roll(t, 0.5, math.radians(15), seed(0.03))
    a = 5 / 7 * G * (math.sin(math.radians(15)) - 0.03 * math.cos(math.radians(15)))
    np.testing.assert_allclose(v, a * t, atol=1e-6)


def test_slipping_stops_at_the_speed_that_angular_momentum_leaves():
    """v and the slip at the foot, and rolling after it: v falls by two sevenths of the
    slip."""
    beta, way, slip, mu = math.radians(15), 0.04, 0.05, 0.03
    grip = slip_friction(beta, way * 1e3, slip, mu)
    t = np.arange(0, 1, 1e-4)
    x, v = ground.roll(t, way, beta, seed(mu, SLIPS=1.0, SLIP_FRICTION=grip))
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
        ground.roll(t, 0.04, math.radians(15), seed(0.03, LEVEL=s * 0.005))[0][-1]
        for s in (-1, 0, 1)
    ]
    assert ends[0] > ends[1] > ends[2]


def test_a_shape_barrier_can_hold_a_seed_and_never_gives_energy():
    t = np.arange(0, 12, 1 / 500)
    x, v = ground.roll(t, 0.04, math.radians(15), seed(0.01, BARRIER=1e-4))
    assert v[-1] == 0
    smooth, _ = ground.roll(t, 0.04, math.radians(15), seed(0.01))
    assert x[-1] <= smooth[-1] + 1e-3


def test_air_slows_a_seed_as_its_drag_number_says():
    """Steady rolling downhill: weight along the plate is what friction and air take."""
    slope, mu, air, re = 0.02, 0.002, 5.0, 400.0
    t = np.arange(0, 12, 1 / 500)
    _, v = ground.roll(
        t, 0.04, math.radians(15), seed(mu, LEVEL=-slope, BLOWN=air, RE=re)
    )
    drag = air * drag_number(re * v[-1]) * v[-1] ** 2 / G
    assert v[-1] == pytest.approx(v[-500], rel=1e-3)
    assert drag == pytest.approx(math.sin(slope) - mu * math.cos(slope), rel=1e-2)


def test_a_sphere_in_free_air_has_the_area_and_reynolds_number_of_its_size():
    size, re_per_speed = drag_scale((8.0, 8.0, 8.0), 1200.0)
    mass = 1200 * math.pi / 6 * 8e-3**3
    assert size == pytest.approx(1.2 * math.pi / 4 * 8e-3**2 / 2 / mass)
    assert re_per_speed == pytest.approx(1.2 * 8e-3 / 1.81e-5)
