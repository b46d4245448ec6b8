"""The drawn truth itself: motions obey their equations, films show the seed where it
was put."""

import numpy as np
import pytest
from synthetic.film import Look, film, to_picture
from synthetic.motion import (
    G,
    correlated_noise,
    draw_drop,
    draw_roll,
    draw_slide,
    film_track,
)


def test_a_drop_falls_and_bounces_by_energy():
    motion = draw_drop(height_mm=310, restitution=0.5)
    assert motion.truth["impact_speed"] == pytest.approx(
        np.sqrt(2 * G * 0.310), rel=1e-6
    )
    assert motion.truth["rebound_height"] == pytest.approx(310 * 0.25, rel=1e-5)
    time = np.linspace(0, motion.end_s, 5000)
    _, y, _ = motion.path(time)
    assert y.min() == pytest.approx(
        3.4
    )  # the centroid stands a radius over the plate, never below
    assert y[0] == pytest.approx(313.4)


def test_drag_takes_what_theory_says():
    """dv²/dh = 2 g − 2 k v²: v² = (g/k)(1 − exp(−2 k h))."""
    k = 0.05
    free, dragged = draw_drop(), draw_drop(drag_per_m=k)
    expected = np.sqrt(G / k * (1 - np.exp(-2 * k * 0.310)))
    assert dragged.truth["impact_speed"] == pytest.approx(expected, rel=1e-5)
    assert free.truth["impact_speed"] != pytest.approx(expected, rel=1e-3)  # control


def test_a_slide_lets_go_at_its_friction_angle_and_accelerates_as_it_should():
    motion = draw_slide(static=0.35, kinetic=0.28)
    onset = motion.truth["onset_s"]
    assert float(motion.tilt(onset)) == pytest.approx(np.degrees(np.arctan(0.35)))
    h = 0.01
    before, at, after = (
        float(motion.path(np.array([onset + 0.1 + d]))[0][0]) for d in (-h, 0, h)
    )
    tilt = np.radians(float(motion.tilt(onset + 0.1)))
    coriolis = 2 * np.radians(2.0) * (after - before) / (2 * h)
    push = 1000 * G * np.sin(tilt) - 0.28 * (1000 * G * np.cos(tilt) - coriolis)
    assert (after - 2 * at + before) / h**2 == pytest.approx(push, rel=2e-3)
    assert float(motion.path(np.array([onset - 0.01]))[0][0]) == 0


def test_a_roll_runs_out_by_equation_3():
    motion = draw_roll(rolling=0.012)
    assert motion.truth["rolling_friction"] == pytest.approx(0.012, rel=1e-9)
    assert (
        draw_roll(rolling=0.012, corner_loss=0.1).truth["rolling_friction"] > 0.0121
    )  # control: energy lost elsewhere
    end = motion.path(np.array([motion.end_s]))[0][0]
    assert end == pytest.approx(10 + motion.truth["run_out"])
    with pytest.raises(ValueError, match="does not start"):
        draw_roll(rolling=0.3)


def test_correlated_noise_is_what_it_says():
    noise = correlated_noise(40_000, 2.0, 0.9, np.random.default_rng(5))
    assert noise.std() == pytest.approx(2.0, rel=0.05)
    assert np.corrcoef(noise[1:], noise[:-1])[0, 1] == pytest.approx(0.9, abs=0.01)


def test_a_film_shows_the_seed_where_it_was_put():
    """Centroid of the bare brightness, on a flat ground without noise: right to a
    hundredth of a pixel."""
    motion, look = draw_drop(height_mm=150), Look(bits=16)
    times = np.array([0.05, 0.1037, 0.15])
    columns, rows = to_picture(look, *motion.path(times)[:2])
    for frame, column, row in zip(
        film(motion, look, np.random.default_rng(0), fps=1, times=times), columns, rows
    ):
        bright = frame.astype(float) - np.median(frame)
        v, u = np.mgrid[: bright.shape[0], : bright.shape[1]]
        assert (bright * u).sum() / bright.sum() == pytest.approx(column, abs=0.01)
        assert (bright * v).sum() / bright.sum() == pytest.approx(row, abs=0.01)


def test_the_same_seed_draws_the_same_track():
    one, two, other = (
        film_track(draw_drop(), np.random.default_rng(s)) for s in (1, 1, 2)
    )
    assert np.array_equal(one.y, two.y)
    assert not np.array_equal(one.y, other.y)
