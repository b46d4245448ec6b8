"""Rolls: how far a seed runs out, and its rolling friction, from drawn tracks."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from benchtwin.bench.keys import Air
from benchtwin.bench.priors import stated_sd
from benchtwin.rigs.roll.measure import measure_roll
from benchtwin.vision.recording import Camera, Recording, Roll
from synthetic.motion import draw_roll, film_track

KNOWN = Recording(
    "r",
    Path("r"),
    "roll",
    "track.csv",
    (),
    camera=Camera(mm_per_px=0.25, mm_per_px_sd=0.0002),
    air=Air(density_kg_m3=0.0),
    roll=Roll(incline_deg=15, incline_length_mm=10),
)


def named(result):
    return {q.name: q for q in result.quantities}


@pytest.mark.parametrize("fps, ar", [(30, 0.0), (500, 0.0), (500, 0.9)])
@pytest.mark.parametrize("rolling", [0.01, 0.05])
def test_drawn_rolls(fps, ar, rolling):
    motion = draw_roll(rolling=rolling)
    track = film_track(motion, np.random.default_rng(1), fps=fps, ar=ar, noise_mm=0.05)
    for name, q in named(measure_roll(track, KNOWN)).items():
        assert abs(q.value - motion.truth[name]) < 3 * q.sd, name
        assert q.quality == "good"


def test_intervals_hold_the_truth_when_the_rig_is_off_by_its_sd():
    inside = []
    for seed in range(80):
        rng = np.random.default_rng(seed)
        way, beta = (
            10 + stated_sd("way-on-incline") * rng.standard_normal(),
            15 + stated_sd("incline") * rng.standard_normal(),
        )
        motion = draw_roll(
            rolling=float(rng.uniform(0.01, 0.05)), incline_mm=way, incline_deg=beta
        )
        track = film_track(motion, rng, fps=120, ar=0.5, noise_mm=0.05)
        for name, q in named(measure_roll(track, KNOWN)).items():
            inside.append(abs(q.value - motion.truth[name]) < 1.96 * q.sd)
    assert 0.90 <= np.mean(inside) <= 0.99


def test_a_seed_that_rocks_at_the_end_rests_about_its_mean():
    motion = draw_roll(rock_mm=1.5, end_rest_s=1.5)
    found = named(
        measure_roll(
            film_track(motion, np.random.default_rng(0), fps=240, noise_mm=0.05), KNOWN
        )
    )["run_out"]
    assert abs(found.value - motion.truth["run_out"]) < 3 * found.sd < 1.5
    still_rocking = draw_roll(rock_mm=4.0, end_rest_s=0.4)
    found = named(
        measure_roll(
            film_track(still_rocking, np.random.default_rng(0), fps=240, noise_mm=0.05),
            KNOWN,
        )
    )["run_out"]
    assert found.quality == "doubtful" and "rocks" in found.reason


def test_a_seed_that_leaves_the_picture_fails_or_is_extrapolated_with_doubt():
    motion = draw_roll()
    rng = np.random.default_rng(0)
    early = named(
        measure_roll(
            film_track(motion, rng, fps=120, until_s=0.8, noise_mm=0.05), KNOWN
        )
    )
    resistance = early.pop("rolling_resistance")  # is told by the rows that there are
    assert (
        abs(resistance.value - motion.truth["rolling_resistance"]) < 3 * resistance.sd
        and resistance.quality == "good"
    )
    assert all(
        q.quality == "failed" and "still moving" in q.reason for q in early.values()
    )
    late = named(
        measure_roll(
            film_track(motion, rng, fps=120, until_s=2.0, noise_mm=0.05), KNOWN
        )
    )["run_out"]
    assert late.quality == "doubtful" and "extrapolated" in late.reason
    assert abs(late.value - motion.truth["run_out"]) < 3 * late.sd


def test_missing_keys_are_named_and_the_run_out_still_given():
    motion = draw_roll(incline_mm=30)
    track = film_track(motion, np.random.default_rng(0), fps=240, noise_mm=0.05)
    found = named(measure_roll(track, replace(KNOWN, roll=Roll(incline_length_mm=30))))
    assert found["run_out"].quality == "good"
    assert (
        found["rolling_friction"].quality == "failed"
        and "[roll] incline_deg" in found["rolling_friction"].reason
    )
    bare = measure_roll(track, replace(KNOWN, roll=Roll()))
    assert (
        abs(named(bare)["run_out"].value - motion.truth["run_out"])
        < 3 * named(bare)["run_out"].sd
    )  # junction from the motion
    assert "incline_length_mm" in named(bare)["rolling_friction"].reason


def test_the_other_direction_and_a_junction_that_does_not_fit():
    motion = draw_roll(direction=-1.0)
    track = film_track(motion, np.random.default_rng(0), fps=240, noise_mm=0.05)
    assert (
        abs(
            named(measure_roll(track, KNOWN))["run_out"].value - motion.truth["run_out"]
        )
        < 1
    )
    wrong = measure_roll(
        track, replace(KNOWN, roll=Roll(incline_deg=15, incline_length_mm=60))
    )
    for q in wrong.quantities:
        assert q.quality == "doubtful" and "check incline_length_mm" in q.reason


def test_wrong_units_a_jump_and_an_origin_elsewhere():
    track = film_track(draw_roll(), np.random.default_rng(0), fps=120, noise_mm=0.1)
    plain = measure_roll(track, KNOWN)
    assert {q.quality for q in plain.quantities} == {"good"}  # control
    centimetres = replace(track, x=track.x / 10, y=track.y / 10)
    jumped = replace(track, x=track.x + np.where(track.t_s > 1, 20, 0))
    started = track.take(track.x > 30)
    for wrong, says in ((centimetres, "seed is fastest"), (jumped, "jumps by +2")):
        for q in measure_roll(wrong, KNOWN).quantities:
            assert q.quality == "doubtful" and (
                says in q.reason
                or (q.name == "rolling_resistance" and "evenly" in q.reason)
            )
    assert all(
        q.quality == "failed" and "neither the release" in q.reason
        for q in measure_roll(started, KNOWN).quantities
    )
    elsewhere = measure_roll(replace(track, x=track.x + 500), KNOWN)
    for q, usual in zip(elsewhere.quantities, plain.quantities, strict=True):
        assert q.quality == "good" and q.value == pytest.approx(usual.value)


def test_a_seed_that_does_not_roll():
    motion = draw_roll()
    track = film_track(
        motion, np.random.default_rng(0), fps=120, until_s=0.1, noise_mm=0.01
    )
    assert all(
        q.quality == "failed" and "does not roll" in q.reason
        for q in measure_roll(track, KNOWN).quantities
    )


def test_energy_lost_at_the_corner_reads_as_friction():
    """Control for Eq. 3: it knows one loss only, so a corner that takes 10 % of the
    speed raises it."""
    rng = np.random.default_rng(0)
    plain = named(measure_roll(film_track(draw_roll(), rng, fps=240), KNOWN))[
        "rolling_friction"
    ]
    lossy = named(
        measure_roll(film_track(draw_roll(corner_loss=0.1), rng, fps=240), KNOWN)
    )["rolling_friction"]
    assert lossy.value > plain.value + 3 * plain.sd
