"""The flying ellipsoid beside closed forms."""

import math

import numpy as np
import pytest

from benchtwin.prove.cases import ellipsoid as body
from benchtwin.prove.cases.air import G_M_S2, drag_number
from benchtwin.prove.cases.bench import Request
from benchtwin.prove.cases.drop import draw, with_strengths
from benchtwin.prove.cases.flight_laws import fading, restitution

R, DENSITY = 3.5e-3, 1250.0
SPHERE = (R, R, R)
BEAN = (4.4e-3, 3.4e-3, 3.0e-3)
UPWARDS = np.array([0.0, 0.0, 1.0])


def drop_of(axes=SPHERE, **fields):
    """A drop in still air that nothing conceals."""
    (world, *_) = draw(Request(), np.random.default_rng(0)).worlds
    plain = {"e": 0.55, "air": 0.0, "pull": 1.0, "density": DENSITY, "friction": 0.3}
    return world._replace(**{"axes": axes, "contact_s": 2.5e-4} | plain | fields)


def dropped(
    world,
    *,
    height_m=0.31,
    turned=(1.0, 0, 0, 0),
    spin=(0.0, 0, 0),
    fps=2000,
    end_s=0.9,
):
    """(times, states, log) of one drop."""
    state = np.zeros(13)
    state[6:10], state[10:13] = np.array(turned) / np.linalg.norm(turned), spin
    axes = np.array(world.axes)
    state[2] = height_m + body.lowest(body.rotation(state[6:10]), axes, UPWARDS)[0]
    times = np.arange(0, end_s, 1 / fps)
    rows, log = body.fly(state, times, world)
    return times[: len(rows)], rows, log


def test_free_fall_is_a_parabola():
    t, rows, log = dropped(drop_of())
    falling_rows = t < log["begin_s"][0]
    expected = 0.31 + R - 0.5 * G_M_S2 * t[falling_rows] ** 2
    np.testing.assert_allclose(rows[falling_rows, 2], expected, atol=1e-12)
    assert log["begin_s"][0] == pytest.approx(math.sqrt(2 * 0.31 / G_M_S2), abs=1e-6)


@pytest.mark.parametrize("e", [0.3, 0.55, 0.8])
def test_a_central_impact_returns_what_the_law_asks_for(e):
    _, _, log = dropped(drop_of(e=e))
    got = -log["vz_out"][0] / log["vz_in"][0]
    assert got == pytest.approx(
        e, abs=0.001
    )  # gravity does work during a contact of 0.25 ms: 0.0005


def test_a_film_takes_its_energy():
    _, _, log = dropped(drop_of(film_adhesion=0.2))
    v = -log["vz_in"][0]
    assert log["vz_out"][0] / v == pytest.approx(
        math.sqrt(0.55**2 - (0.2 / v) ** 2), abs=0.002
    )


def test_energy_is_kept_in_flight_and_an_impact_takes_what_the_law_says():
    world = drop_of(BEAN, e=0.7, friction=0.0, contact_s=6e-5, most_bounces=1)
    axes, mass, inertia, _ = body.solid(world)
    t, rows, log = dropped(
        world, turned=(1, 0.2, 0.3, 0.1), spin=(5.0, 20.0, -10.0), end_s=0.4
    )
    energy = 0.5 * mass * (rows[:, 3:6] ** 2).sum(axis=1) + 0.5 * (
        inertia * rows[:, 10:13] ** 2
    ).sum(axis=1)
    energy += mass * G_M_S2 * rows[:, 2]
    before = np.flatnonzero(t < log["begin_s"][0])
    np.testing.assert_allclose(energy[before], energy[0], rtol=1e-9)
    turned = body.rotation(rows[before[-1], 6:10])
    point = body.lowest(turned, axes, UPWARDS)[1]
    meff = body.effective_mass(turned, point, UPWARDS, mass, inertia)
    lost = 0.5 * meff * (1 - 0.7**2) * log["normal_m_s"][0] ** 2
    # the last frame is up to 0.5 ms before the touch, and the seed turns while it is
    # pressed
    assert energy[0] - energy[-1] == pytest.approx(lost, rel=0.03)


def test_an_oblique_lossless_blow_keeps_what_friction_cannot_change():
    """A smooth blow turns the ellipsoid by the moment of its momentum about the centre:
    I Δω = r × J."""
    world = drop_of(BEAN, friction=0.0, contact_s=6e-5, most_bounces=1)
    axes, mass, inertia, _ = body.solid(world)
    turn = 0.3  # about y, in the picture's plane
    turned = np.array([math.cos(turn / 2), 0, math.sin(turn / 2), 0])
    _, _, log = dropped(world, turned=turned, end_s=0.4)
    blow = mass * (log["vz_out"][0] - log["vz_in"][0])
    _, point = body.lowest(body.rotation(turned), axes, UPWARDS)
    # ω about the axis towards the viewer, −y
    expected = -(-point[0] * blow) / inertia[1]
    assert log["turn_out"][0] - log["turn_in"][0] == pytest.approx(expected, rel=0.02)


def test_terminal_speed_is_where_drag_is_the_weight():
    share = 0.5  # of the weight at 2 m/s
    re = 900.0
    world = drop_of(air=share, re_per_speed=re)
    _, rows, _ = dropped(world, height_m=60.0, end_s=3.0, fps=200)
    v = -rows[-1, 5]
    assert share * drag_number(re * v) * v**2 / (
        drag_number(re * 2) * 4
    ) == pytest.approx(1.0, rel=1e-4)


def test_a_tilted_plate_kicks_towards_its_lower_side():
    alpha = math.radians(1.0)  # falls towards +x
    _, _, log = dropped(drop_of(plate_tilt=1.0, friction=0.0, most_bounces=1))
    assert log["vx_out"][0] == pytest.approx(-1.55 * alpha * log["vz_in"][0], rel=0.01)


@pytest.mark.parametrize(
    "law", ["viscoelastic_restitution", "plastic_restitution", "plate_compliance"]
)
def test_laws_fall_by_what_the_key_says(law):
    world = with_strengths(drop_of(e=0.5, **{law: 0.08}))
    e = {v: world.e * fading(v, world) for v in (0.5, 1.2, 2.0)}
    assert e[1.2] == pytest.approx(0.5)
    assert e[0.5] - e[2.0] == pytest.approx(0.08, abs=1e-6)
    e = [restitution(v, 0, 0.5, world) for v in (0.3, 0.6, 1.2, 2.4)]
    assert np.all(np.diff(e) < 0)


def test_a_law_that_cannot_fall_so_far_is_refused():
    with pytest.raises(ValueError, match="sign"):
        with_strengths(drop_of(e=0.5, plastic_restitution=0.4))
