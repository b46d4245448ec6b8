"""Rows that lie astray: marked, left out, and nothing else is."""

from dataclasses import replace

import numpy as np
import pytest
from drops import drop, named
from synthetic.motion import draw_drop, film_track

from benchtwin.rigs.drop.measure import measure_drop


def test_outliers_are_marked_and_left_out():
    track = film_track(draw_drop(), np.random.default_rng(4))
    y = track.y.copy()
    wrong = np.arange(300, 1200, 45)
    y[wrong] += 12.0
    result = measure_drop(replace(track, y=y), drop())
    assert (
        result.track.outlier[wrong].all()
        and result.track.outlier.sum() < len(wrong) + 20
    )
    assert named(result)["restitution_normal"].value == pytest.approx(0.5, abs=0.002)


@pytest.mark.parametrize(
    ("every", "off"), [(50, 40.0), (50, -40.0), (10_000, 40.0), (20, 40.0)]
)
def test_single_rows_far_off_are_marked_and_nothing_else(every, off):
    """1000 fps, one row in 50 (or one in all) 40 mm off: those rows are outliers,
    hardly any other is."""
    track = film_track(draw_drop(), np.random.default_rng(0), fps=1000, noise_mm=0.05)
    wrong = np.arange(len(track)) % every == (3 if every < 100 else 150)
    result = measure_drop(replace(track, y=track.y + off * wrong), drop(fps=1000))
    assert (
        result.track.outlier[wrong].all() and (result.track.outlier & ~wrong).sum() <= 3
    )
    for name, q in named(result).items():
        truth = 0.5 if name.startswith("restitution") else draw_drop().truth[name]
        assert q.quality == "good" and abs(q.value - truth) < 3 * q.sd, name


def test_rows_astray_sideways_are_outliers_and_cost_the_sideways_speed_nothing():
    """Three rows in a hundred are 2 mm off, across only: 40 times the noise."""
    motion = draw_drop()
    track = film_track(motion, np.random.default_rng(0), noise_mm=0.05)
    rng = np.random.default_rng(1)
    odd = rng.random(len(track)) < 0.03
    strayed = replace(track, x=track.x + odd * rng.choice([-2.0, 2.0], len(track)))
    clean, found = measure_drop(track, drop()), measure_drop(strayed, drop())
    flown = np.isin(np.arange(len(track)), np.concatenate(clean.flights.rows))
    assert (
        found.track.outlier[odd & flown].all()
        and not found.track.outlier[flown & ~odd].any()
    )
    column = found.bounces["lateral_after_m_s"].to_numpy()
    assert column == pytest.approx(
        clean.bounces["lateral_after_m_s"].to_numpy(), abs=3e-3
    )


def test_a_flight_that_air_bends_more_than_is_assumed_is_no_outlier():
    """By half a millimetre at its end, smoothly: all its rows are used; as a control 20
    rows that jump by 0.2 mm."""
    motion = draw_drop()
    track = film_track(motion, np.random.default_rng(0), fps=5000, noise_mm=0.006)
    first, second = (motion.truth["bounces"][k]["t_s"] for k in (0, 1))
    way = np.clip((track.t_s - first) / (second - first), 0.0, None)
    flying = (way > 0) & (way < 1)
    bent = replace(track, y=track.y + np.where(flying, 0.5 * way**8, 0.0))
    found = measure_drop(bent, drop(fps=5000))
    assert found.track.outlier[flying].mean() < 0.01
    burst = (way > 0.9) & (np.cumsum((way > 0.9) & flying) <= 20)
    jumped = measure_drop(
        replace(track, y=track.y + np.where(burst, 0.2, 0.0)), drop(fps=5000)
    )
    assert jumped.track.outlier[burst].mean() > 0.9
