"""Gravity as the judge of units: what is a fall, what only looks like one, and what is
asked."""

import numpy as np
import pytest
from bouncing import G, ball

from benchtwin.vision.foreign.unit_inference import free_fall, free_falls, unit_doubt

FRAME, X, Y = ball()
T = FRAME / 120


@pytest.mark.parametrize("noise_m", [0.0, 0.001, 0.003])
def test_the_acceleration_of_a_fall(noise_m):
    rng = np.random.default_rng(4)
    fall = free_fall(
        T, X + rng.normal(0, noise_m, T.size), Y + rng.normal(0, noise_m, T.size)
    )
    assert fall is not None
    assert fall.acceleration == pytest.approx(
        -G, rel=0.001 if noise_m == 0 else 0.08
    )  # 3 mm beside a sagitta of 120


def test_the_rest_before_a_release_and_after_the_last_bounce_stays_out():
    t = np.arange(T.size + 240) / 120
    y = np.concatenate([np.full(120, Y[0]), Y, np.zeros(120)])
    fall = free_fall(t, np.zeros_like(t), y)
    assert fall is not None and fall.acceleration == pytest.approx(-G, rel=0.02)


def test_what_rolls_does_not_fall():
    """Noise beside a run-out; a roll down an incline, seen along it and across."""
    rng, t = np.random.default_rng(5), np.arange(300) / 100
    along = 300 * (1 - np.exp(-t))
    assert free_fall(t, along, rng.normal(0, 0.3, t.size)) is None
    down = 0.5 * 1200 * t**2
    for steep in np.radians([10, 30, 60]):
        assert free_fall(t, down * np.cos(steep), -down * np.sin(steep)) is None


def test_a_hand_that_lifts_before_a_fall_is_no_reason_to_ask():
    """Lifted by a metre in an even sweep, then let go: the sweep is the greater
    parabola, and not gravity's."""
    rise = np.arange(0, 1, 1 / 120)
    y = np.concatenate(
        [1 - (1 - rise) ** 2, 1 - G * np.arange(0, 0.4, 1 / 120) ** 2 / 2]
    )
    t = np.arange(y.size) / 120
    assert unit_doubt(free_falls(t, np.zeros_like(t), 1000 * y), 1.0, 1.0, False) == ""


def test_a_light_ball_near_its_final_speed_is_no_reason_to_ask():
    """v = v∞ tanh(g t / v∞) with v∞ = 4 m/s, seen from its first second on: what is
    left of g is a fifth at most."""
    t = np.arange(0.6, 3, 1 / 15)
    y = -(4**2) / G * np.log(np.cosh(G * t / 4))
    assert unit_doubt(free_falls(t, np.zeros_like(t), 1000 * y), 1.0, 1.0, False) == ""


@pytest.mark.parametrize(
    ("times", "lengths", "said"),
    [
        (1000, 1000, "are the times milliseconds?"),
        (1 / 60, 1000, "are the times minutes?"),
        (1, 1, "are the lengths metres?"),
        (1, 100, "are the lengths centimetres?"),
        (37.3, 2.2, "in which units are its times and lengths?"),
        (1, 1000, ""),
        (1.3, 1000, ""),
    ],
)
def test_what_is_asked(times, lengths, said):
    doubt = unit_doubt(free_falls(times * T, lengths * X, lengths * Y), 1.0, 1.0, False)
    assert said in doubt and bool(said) == bool(doubt)


def test_frame_numbers_are_asked_with_the_rate_that_would_fit():
    doubt = unit_doubt(
        free_falls(FRAME.astype(float), 1000 * X, 1000 * Y), 1.0, 1.0, True
    )
    assert "are the times frame numbers, at 120 frames per second?" in doubt


def test_times_that_all_but_coincide_do_no_harm():
    t = np.array([0.0, 1e-300, 2e-300, 3e-300, 1.0, 2.0])
    assert isinstance(free_falls(t, np.zeros(6), np.arange(6.0)), list)
    assert free_falls(np.arange(3.0), np.zeros(3), np.zeros(3)) == []
