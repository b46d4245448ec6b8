"""A block's motion beside closed forms and brute force, and the machine code that it is
compiled to."""

import math
import time

import numpy as np
import pytest
from sliding import G

from benchtwin.rigs.slide.motion import (
    SCATTER,
    SHARE,
    Laws,
    _crept,
    friction_at,
    travel,
)


def test_a_block_on_a_still_plate_has_its_closed_form():
    """x = g (sin θ − μ cos θ) t²/2 from the onset, with μ = tan θ less what friction
    loses in motion."""
    angle, loss, onset = math.radians(25.0), 0.08, 0.237
    laws, tilt = Laws(static_excess=loss), np.array([angle, 0, 0, 0])
    friction = friction_at(onset, tilt, laws)
    assert friction == pytest.approx(math.tan(angle) - loss)
    t = np.linspace(0, 1, 101)
    x, v = travel(t, onset, tilt, laws._replace(friction=friction))
    pull = G * loss * math.cos(angle)
    assert x == pytest.approx(pull * np.clip(t - onset, 0, None) ** 2 / 2, abs=1e-12)
    assert v[-1] == pytest.approx(pull * (1 - onset))


def test_an_onset_long_before_the_first_row_is_fast():
    """A fit on its way may try one; at the usual step ten million seconds are minutes
    of work."""
    tilt, t = np.array([math.radians(25.0), 0, 0, 0]), np.linspace(0, 1, 11)
    travel(t, 0.0, tilt, Laws(friction=0.1))  # compiled
    begun = time.process_time()
    x, v = travel(t, -1e7, tilt, Laws(friction=0.1))
    assert (
        time.process_time() - begun < 0.5
        and np.isfinite(x).all()
        and np.isfinite(v).all()
    )


def test_a_slowly_tilting_plate_gives_the_third_power():
    """x = g Ω t³/(6 cos θ₀) while θ is near θ₀."""
    rate, angle = math.radians(1.0), math.radians(20.0)
    tilt, t = np.array([angle, rate, 0, 0]), np.linspace(0, 0.3, 31)
    x, _ = travel(t, 0.0, tilt, Laws(friction=math.tan(angle), turning=0.0))
    assert x[-1] == pytest.approx(G * rate * 0.3**3 / 6 / math.cos(angle), rel=2e-3)


def slipped(amplitude, omega, growth, phase):
    """Speed at which it slides on when the mean pull is up to the friction, the wave's
    own taken off, and the way until then: brute force, from rest, sticking whenever it
    stops."""
    times = np.linspace(-1.1 * amplitude / growth, 0.5 * amplitude / growth, 20_000)
    h, speed, way = times[1] - times[0], 0.0, 0.0
    for t in times:
        speed = max(
            speed + h * (growth * t + amplitude * math.sin(omega * t + phase)), 0.0
        )
        way += h * speed
    end, angle = times[-1], omega * times[-1] + phase
    mean = speed - growth * end**2 / 2 + amplitude / omega * math.cos(angle)
    return (
        mean,
        way - growth * end**3 / 6 - mean * end + amplitude / omega**2 * math.sin(angle),
    )


@pytest.mark.parametrize("in_a_wave", [0.1, 0.4, 1.0])
def test_a_shaken_block_slips_before_it_slides(in_a_wave):
    """The law against brute force, over the phases; in_a_wave: by how much of a the
    pull grows meanwhile."""
    a, hertz = 0.06, 20.0
    omega, growth = 2 * math.pi * hertz, in_a_wave * a * hertz
    laws = Laws(shake=a, omega=omega)
    speeds, ways = np.array(
        [slipped(a, omega, growth, phase) for phase in np.arange(0, 2 * math.pi, 0.4)]
    ).T
    low, high = (a / omega * (SHARE + SCATTER * chance) for chance in (-1.0, 1.0))
    assert low < speeds.mean() < high and speeds.std() < 0.6 * (high - low)
    assert speeds.max() == pytest.approx(a / omega, rel=0.03)
    way, speed = _crept(laws, growth, 0.0)
    assert way == pytest.approx(
        ways.mean(), rel=0.15 + 1.2 * in_a_wave
    ) and speed == pytest.approx(a / omega)
    assert _crept(laws, growth, -1.01 * a / growth) == (0.0, 0.0)
    before = [_crept(laws, growth, -0.5 * a / growth - h)[0] for h in (0.0, 1e-6)]
    assert (before[0] - before[1]) / 1e-6 == pytest.approx(
        _crept(laws, growth, -0.5 * a / growth)[1], rel=1e-3
    )


def test_a_plate_in_stairs_pulls_evenly_between_its_climbs():
    """On one stair the acceleration is g (sin θ − μ cos θ) of that stair, on the next
    that of the next, and the climb between."""
    stair, climb, rate, angle = (
        math.radians(0.5),
        0.02,
        math.radians(1.0),
        math.radians(20.0),
    )
    laws = Laws(
        friction=math.tan(angle), stair=stair, climb=climb, lag=0.5, turning=0.0
    )
    t = np.linspace(0.0, 0.8, 801)
    _, v = travel(t, 0.0, np.array([angle, rate, 0, 0]), laws)
    pull = np.gradient(v, t)
    for when, stairs in ((0.3, 0.5), (0.7, 1.5)):
        there = angle + stairs * stair
        assert pull[round(1e3 * when)] == pytest.approx(
            G * (math.sin(there) - math.tan(angle) * math.cos(there)), rel=1e-3
        )
