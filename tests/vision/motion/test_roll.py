"""Rolls past a few gates, on tracks of a few rows, and on an incline only: intervals
hold, and what cannot be is said."""

import math
from dataclasses import replace

import numpy as np
import pytest
from rolling_balls import Ball, way

from benchtwin.bench.keys import Camera, Seed
from benchtwin.rigs.roll.inertia import inertia_of
from benchtwin.rigs.roll.keys import Roll
from benchtwin.rigs.roll.measure import measure_roll
from benchtwin.vision.motion.track import make_track
from benchtwin.vision.recording import Recording

BALL = Seed(length_mm=15, width_mm=15, thickness_mm=15, mass_g=13.8)
LEAST = (
    0.92  # of 200 intervals of 95 %: 6 fewer than expected is two standard deviations
)


def recording(
    tmp_path, roll: Roll, evidence="track.csv", seed=BALL, **camera
) -> Recording:
    return Recording(
        "roll-01",
        tmp_path,
        "roll",
        evidence,
        (tmp_path / evidence,),
        seed=seed,
        roll=roll,
        camera=Camera(**camera),
    )


def quantities(found) -> dict:
    return {q.name: q for q in found.quantities}


def held(quantity, truth: float) -> bool:
    return abs(quantity.value - truth) <= 1.96 * quantity.sd


def passed(ball: Ball, gates: np.ndarray, speed: float) -> np.ndarray:
    t, x = way(ball, speed, 3.0)
    return np.interp(gates / 1000, x, t)


@pytest.mark.slow
@pytest.mark.parametrize("stated", [True, False])
def test_intervals_of_four_to_six_gates_on_an_incline_hold(tmp_path, stated):
    rng, good, widths = np.random.default_rng(3), [], []
    for _ in range(200):
        ball = Ball(
            math.radians(rng.uniform(4, 20)),
            rng.uniform(0.002, 0.03),
            1.4 * (1 + 0.003 * rng.standard_normal()),
            0.002,
        )
        gates = np.sort(rng.uniform(20, 900, rng.integers(4, 7)))
        sd = 10 ** rng.uniform(-4.5, -3)
        time = passed(ball, gates, rng.uniform(0.02, 0.4)) + sd * rng.standard_normal(
            len(gates)
        )
        speed = np.gradient(gates, time)
        track = make_track(
            time, gates, 0 * gates, sd=np.abs(speed) * sd if stated else np.nan
        )
        roll = Roll(
            incline_deg=math.degrees(ball.beta) + 0.1 * rng.standard_normal(),
            level=False,
        )
        found = quantities(measure_roll(track, recording(tmp_path, roll, "gates.csv")))
        good.append(
            [
                held(found["acceleration"], ball.acceleration),
                held(found["rolling_resistance"], ball.mu),
            ]
        )
        widths.append(found["acceleration"].sd / ball.acceleration)
    shares = np.mean(good, axis=0)
    print(
        f"stated {stated}: acceleration {shares[0]:.3f}, friction {shares[1]:.3f}, sd"
        f" of a {100 * np.median(widths):.2g} %"
    )
    assert (shares >= LEAST).all()


@pytest.mark.slow
@pytest.mark.parametrize("stated", [True, False])
def test_intervals_of_tracks_of_four_to_ten_rows_hold(tmp_path, stated):
    rng, good = np.random.default_rng(5), []
    for _ in range(200):
        ball = Ball(
            math.radians(rng.uniform(4, 20)),
            rng.uniform(0.002, 0.03),
            1.4 * (1 + 0.003 * rng.standard_normal()),
            0.002,
        )
        fine, x = way(ball, rng.uniform(0.0, 0.4), 1.0)
        time = np.linspace(0, 1, rng.integers(4, 11))
        sd, scale = 10 ** rng.uniform(-1, 0.5), 1 + 0.002 * rng.standard_normal()
        seen = (
            1000 * np.interp(time, fine, x) + sd * rng.standard_normal(len(time))
        ) * scale
        track = make_track(time, seen, 0 * seen, sd=sd if stated else np.nan)
        roll = Roll(
            incline_deg=math.degrees(ball.beta) + 0.1 * rng.standard_normal(),
            incline_length_mm=5000,
        )
        about = recording(tmp_path, roll, mm_per_px=0.5, mm_per_px_sd=0.001)
        found = quantities(measure_roll(track, about))
        good.append(
            [
                held(found["acceleration"], ball.acceleration),
                held(found["rolling_resistance"], ball.mu),
            ]
        )
    shares = np.mean(good, axis=0)
    print(f"stated {stated}: acceleration {shares[0]:.3f}, friction {shares[1]:.3f}")
    assert (shares >= LEAST).all()


def test_a_seed_that_waits_and_is_stopped_is_read_between(tmp_path):
    ball, rng = Ball(math.radians(8), 0.01, 1.4), np.random.default_rng(1)
    fine, x = way(ball, 0.0, 1.2)
    time = np.arange(0, 2.2, 1 / 60)
    seen = 1000 * np.minimum(
        np.interp(time - 0.5, fine, x), 0.4
    ) + 0.2 * rng.standard_normal(len(time))
    roll = Roll(incline_deg=8, level=False)
    found = measure_roll(
        make_track(time, -seen, 0 * seen),
        recording(tmp_path, roll, mm_per_px=0.5, mm_per_px_sd=0.0005),
    )
    assert held(quantities(found)["acceleration"], ball.acceleration)
    assert quantities(found)["acceleration"].sd < 0.01 * ball.acceleration
    assert any("is stopped at 1.4" in n for n in found.notes)


@pytest.mark.slow
@pytest.mark.parametrize(
    "rows", [6, *(pytest.param(n, marks=pytest.mark.slow) for n in (8, 12))]
)
def test_few_rows_on_both_legs_tell_run_out_and_friction(tmp_path, rows):
    rng, good = np.random.default_rng(rows), []
    for _ in range(100):
        beta = math.radians(rng.uniform(8, 15))
        ball = Ball(
            beta,
            rng.uniform(0.02, 0.05),
            1.4,
            0.002,
            0.15,
            1 - rng.uniform(0, 1) * (1 - math.cos(beta)) / 1.4,
        )
        fine, x = way(ball, 0.0, 8.0)
        end = fine[np.argmax(x >= x[-1] - 1e-6)]
        time = np.linspace(0.05, rng.uniform(0.8, 1.1) * end, rows)
        seen = 1000 * np.interp(time, fine, x) + 0.5 * rng.standard_normal(rows)
        roll = Roll(incline_deg=math.degrees(beta), incline_length_mm=150)
        found = quantities(
            measure_roll(
                make_track(time, seen, 0 * seen),
                recording(tmp_path, roll, mm_per_px=0.5, mm_per_px_sd=0.0005),
            )
        )
        good.append(
            [
                held(found["run_out"], 1000 * (x[-1] - 0.15)),
                held(found["rolling_resistance"], ball.mu),
            ]
        )
    print(rows, np.mean(good, axis=0))
    assert (
        np.mean(good, axis=0) >= 0.9
    ).all()  # of 100: 5 fewer than expected is two standard deviations


def test_inertia_of_hollow_balls_and_of_balls_on_rails():
    shell, solid = (
        Seed(length_mm=40, width_mm=40, thickness_mm=40, inertia_factor=2 / 3),
        Seed(length_mm=15, width_mm=15),
    )
    assert inertia_of(shell, None).factor == pytest.approx(5 / 3)
    assert inertia_of(solid, 6.0).factor == pytest.approx(
        1 + 0.4 * 7.5**2 / (7.5**2 - 3**2)
    )
    assert inertia_of(Seed(), None).factor == pytest.approx(1.4)


def test_what_cannot_be_is_one_sentence(tmp_path):
    gates = np.array([100.0, 300, 500, 700])
    time = passed(Ball(0.1, 0.01, 1.4), gates, 0.1)
    track = make_track(time, gates, 0 * gates)
    wide = measure_roll(
        track,
        recording(
            tmp_path, Roll(level=False, incline_deg=6, rail_gap_mm=20), "gates.csv"
        ),
    )
    assert (
        "rail_gap_mm = 20: a ball of 15 mm falls between" in wide.quantities[0].reason
    )
    asked = measure_roll(track, recording(tmp_path, Roll(level=False), "gates.csv"))
    assert (
        "[roll] incline_deg is missing"
        in quantities(asked)["rolling_resistance"].reason
    )
    assert quantities(asked)["acceleration"].quality == "good"
    no_length = measure_roll(
        track, recording(tmp_path, Roll(incline_deg=6), "gates.csv")
    )
    assert (
        "[roll] incline_length_mm missing" in no_length.quantities[0].reason
        and "level = false" in no_length.quantities[0].reason
    )
    back = measure_roll(
        replace(track, t_s=time.max() - time[::-1]),
        recording(tmp_path, Roll(level=False), "gates.csv"),
    )
    assert "does not speed up on its incline" in back.quantities[0].reason


@pytest.mark.parametrize(
    ("acceleration", "stays"), [(200.0, True), (2.0, False), (-40.0, False)]
)
def test_a_seed_that_speeds_up_to_its_last_row_is_on_an_incline(
    tmp_path, acceleration, stays
):
    """Of which nothing is stated: at 0.2 m/s² it says so in each of 20 noisy tracks;
    what is hardly one, or slows down, does not."""
    rng, time = np.random.default_rng(7), np.arange(40) / 30
    x = 100 * time + acceleration / 2 * time**2
    told = [
        measure_roll(
            make_track(time, x + 0.2 * rng.standard_normal(40), 0 * x),
            recording(tmp_path, Roll()),
        )
        for _ in range(20)
    ]
    found = [quantities(one) for one in told]
    assert {"acceleration" in one for one in found} == {stays}
    if stays:
        assert sum(held(one["acceleration"], 0.2) for one in found) >= 17
        assert "incline_deg is missing" in found[0]["rolling_resistance"].reason


@pytest.mark.parametrize("lasts_s", [1.3, 4.0, 5.5])
def test_a_seed_seen_on_the_level_only_tells_its_resistance(tmp_path, lasts_s):
    """By its slowing alone, whether it stops (at 5 s) in the track or not; a run-out
    has no beginning then."""
    rng, time = np.random.default_rng(2), np.arange(0, lasts_s, 1 / 30)
    until = np.minimum(time, 5.0)
    x = 200 * until - 20 * until**2
    stated = Roll(slope_deg=0.0, direction="+x")
    for _ in range(3):
        noisy = make_track(time, x + 0.2 * rng.standard_normal(len(x)), 0 * x)
        found = quantities(measure_roll(noisy, recording(tmp_path, stated)))
        friction = found["rolling_resistance"]
        assert held(friction, 1.4 * 0.04 / 9.80665)
        assert friction.sd < 0.3 * friction.value
        assert "the end of the incline is in the track" in found["run_out"].reason
