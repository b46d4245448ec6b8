"""The flying ellipsoid beside closed forms."""

import math

import numpy as np
import pytest

from benchtwin.prove.cases import ellipsoid as body
from benchtwin.prove.cases.drop_effects import falling, value
from benchtwin.prove.cases.flight_laws import (
    drag_number,
    impact_array,
    law_array,
    restitution,
)

R, DENSITY = 3.5e-3, 1250.0
SPHERE = np.full(3, R)


def dropped(
    axes,
    *,
    height_m=0.31,
    e=0.55,
    film_m_s=0.0,
    friction=0.3,
    turned=(1.0, 0, 0, 0),
    spin=(0.0, 0, 0),
    fps=2000,
    end_s=0.9,
    law=None,
    most=3,
    tilt=0.0,
    contact_s=2.5e-4,
):
    """(times, states, log) of one drop."""
    mass = 4 / 3 * math.pi * axes.prod() * DENSITY
    inertia = mass / 5 * (np.sum(axes**2) - axes**2)
    normal = (-math.sin(tilt), 0.0, math.cos(tilt))
    plate = np.array(
        [
            *normal,
            friction,
            mass * (math.pi / contact_s) ** 2,
            0.5 * mass * film_m_s**2,
            mass,
        ]
    )
    state = np.zeros(13)
    state[6:10], state[10:13] = np.array(turned) / np.linalg.norm(turned), spin
    state[2] = (
        height_m
        + body.lowest(body.rotation(state[6:10]), axes, np.array([0.0, 0.0, 1.0]))[0]
    )
    times = np.arange(0, end_s, 1 / fps)
    law = law_array(gravity=body.G_M_S2) if law is None else law
    rows, log, n = body.fly(
        state, times, axes, inertia, plate, law, impact_array(e=e), most, 0.2
    )
    return times[:n], rows[:n], log


def test_free_fall_is_a_parabola():
    t, rows, log = dropped(SPHERE)
    falling_rows = t < log[0, body.T_BEGIN]
    expected = 0.31 + R - 0.5 * body.G_M_S2 * t[falling_rows] ** 2
    np.testing.assert_allclose(rows[falling_rows, 2], expected, atol=1e-12)
    assert log[0, body.T_BEGIN] == pytest.approx(
        math.sqrt(2 * 0.31 / body.G_M_S2), abs=1e-6
    )


@pytest.mark.parametrize("e", [0.3, 0.55, 0.8])
def test_a_central_impact_returns_what_the_law_asks_for(e):
    _, _, log = dropped(SPHERE, e=e)
    got = -log[0, body.VZ_OUT] / log[0, body.VZ_IN]
    assert got == pytest.approx(
        e, abs=0.001
    )  # gravity does work during a contact of 0.25 ms: 0.0005


def test_a_film_takes_its_energy():
    _, _, log = dropped(SPHERE, film_m_s=0.2)
    v = -log[0, body.VZ_IN]
    assert log[0, body.VZ_OUT] / v == pytest.approx(
        math.sqrt(0.55**2 - (0.2 / v) ** 2), abs=0.002
    )


def test_energy_is_kept_in_flight_and_an_impact_takes_what_the_law_says():
    axes = np.array([4.4e-3, 3.4e-3, 3.0e-3])
    mass = 4 / 3 * math.pi * axes.prod() * DENSITY
    inertia = mass / 5 * (np.sum(axes**2) - axes**2)
    t, rows, log = dropped(
        axes,
        e=0.7,
        friction=0.0,
        turned=(1, 0.2, 0.3, 0.1),
        spin=(5.0, 20.0, -10.0),
        most=1,
        end_s=0.4,
        contact_s=6e-5,
    )
    energy = 0.5 * mass * (rows[:, 3:6] ** 2).sum(axis=1) + 0.5 * (
        inertia * rows[:, 10:13] ** 2
    ).sum(axis=1)
    energy += mass * body.G_M_S2 * rows[:, 2]
    before = np.flatnonzero(t < log[0, body.T_BEGIN])
    np.testing.assert_allclose(energy[before], energy[0], rtol=1e-9)
    normal, turned = np.array([0.0, 0, 1]), body.rotation(rows[before[-1], 6:10])
    meff = body.effective_mass(
        turned, body.lowest(turned, axes, normal)[1], normal, mass, inertia
    )
    lost = 0.5 * meff * (1 - 0.7**2) * log[0, body.V_NORMAL] ** 2
    # the last frame is up to 0.5 ms before the touch, and the seed turns while it is
    # pressed
    assert energy[0] - energy[-1] == pytest.approx(lost, rel=0.03)


def test_an_oblique_lossless_blow_keeps_what_friction_cannot_change():
    """A smooth blow turns the ellipsoid by the moment of its momentum about the centre:
    I Δω = r × J."""
    axes = np.array([4.4e-3, 3.4e-3, 3.0e-3])
    mass = 4 / 3 * math.pi * axes.prod() * DENSITY
    inertia_y = mass / 5 * (axes[0] ** 2 + axes[2] ** 2)
    turn = 0.3  # about y, in the picture's plane
    _, _, log = dropped(
        axes,
        friction=0.0,
        turned=(math.cos(turn / 2), 0, math.sin(turn / 2), 0),
        most=1,
        end_s=0.4,
        contact_s=6e-5,
    )
    blow = mass * (log[0, body.VZ_OUT] - log[0, body.VZ_IN])
    _, point = body.lowest(
        body.rotation(np.array([math.cos(turn / 2), 0, math.sin(turn / 2), 0.0])),
        axes,
        np.array([0.0, 0, 1.0]),
    )
    expected = (
        -(-point[0] * blow) / inertia_y
    )  # ω about the axis towards the viewer, −y
    assert log[0, body.TURN_OUT] - log[0, body.TURN_IN] == pytest.approx(
        expected, rel=0.02
    )


def test_terminal_speed_is_where_drag_is_the_weight():
    share = 0.5  # of the weight at 2 m/s
    re = 900.0
    _, rows, _ = dropped(
        SPHERE,
        height_m=60.0,
        law=law_array(gravity=body.G_M_S2, drag=share, re_per_speed=re),
        end_s=3.0,
        fps=200,
    )
    v = -rows[-1, 5]
    assert share * drag_number(re * v) * v**2 / (
        drag_number(re * 2) * 4
    ) == pytest.approx(1.0, rel=1e-4)


def test_a_tilted_plate_kicks_towards_its_lower_side():
    alpha = math.radians(1.0)  # rises towards +x
    _, _, log = dropped(SPHERE, tilt=alpha, friction=0.0, most=1)
    assert log[0, body.VX_OUT] == pytest.approx(
        1.55 * alpha * log[0, body.VZ_IN], rel=0.01
    )


@pytest.mark.parametrize("law", ["viscous", "yielding", "zener"])
def test_laws_fall_by_what_the_key_says(law):
    entries = falling(law, 0.08, 0.5)
    assert value(entries, 1.2) == pytest.approx(0.5)
    assert value(entries, 0.5) - value(entries, 2.0) == pytest.approx(0.08, abs=1e-6)
    e = [restitution(v, 0, 0.5, impact_array(**entries)) for v in (0.3, 0.6, 1.2, 2.4)]
    assert np.all(np.diff(e) < 0)


def test_a_law_that_cannot_fall_so_far_is_refused():
    with pytest.raises(ValueError, match="sign"):
        falling("yielding", 0.4, 0.5)
