"""Rolls: how far a seed runs out, and its rolling friction, from drawn tracks."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from synthetic.motion import draw_roll, film_track

from benchtwin.bench.keys import Air, Camera, Seed
from benchtwin.bench.priors import stated_sd, unstated_sd
from benchtwin.rigs.roll.keys import Roll
from benchtwin.rigs.roll.measure import measure_roll
from benchtwin.vision.motion.track import make_track
from benchtwin.vision.recording import Recording

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


@pytest.mark.slow
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
    """To 0.7 mm: 0.3 mm of the way on the incline and where its path turns, 0.4 mm of
    200 because the run may lie 2 mm beside the plane in which the scale holds."""
    motion = draw_roll(rock_mm=1.5, end_rest_s=1.5)
    found = named(
        measure_roll(
            film_track(motion, np.random.default_rng(0), fps=240, noise_mm=0.05), KNOWN
        )
    )["run_out"]
    assert abs(found.value - motion.truth["run_out"]) < 3 * found.sd < 2.4
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


@pytest.mark.parametrize("off_mm, used", [(0.0, True), (4.0, False), (-4.0, False)])
def test_a_corner_seen_where_it_cannot_be_is_not_used(off_mm, used):
    """A picture that misplaces the corner does not move the run-out, and is told."""
    motion = draw_roll(rolling=0.03)
    track = film_track(motion, np.random.default_rng(3), fps=120, noise_mm=0.05)
    seen = (track.x[0] + 10 + off_mm, 0.2)
    found = named(measure_roll(track, KNOWN, junction=seen))["run_out"]
    assert abs(found.value - motion.truth["run_out"]) < 3 * found.sd
    assert found.quality == ("good" if used else "doubtful")
    assert used or "the corner that the picture shows" in found.reason


def test_wrong_units_a_jump_and_an_origin_elsewhere():
    track = film_track(draw_roll(), np.random.default_rng(0), fps=120, noise_mm=0.1)
    plain = measure_roll(track, KNOWN)
    assert {q.quality for q in plain.quantities} == {"good"}  # control
    centimetres = replace(track, x=track.x / 10, y=track.y / 10)
    jumped = replace(track, x=track.x + np.where(track.t_s > 1, 20, 0))
    for wrong, says in (
        (centimetres, "incline_length_mm"),
        (jumped, "slows down even"),
    ):
        for q in measure_roll(wrong, KNOWN).quantities:
            assert q.quality == "doubtful" and says in q.reason
    elsewhere = measure_roll(replace(track, x=track.x + 500), KNOWN)
    for q, usual in zip(elsewhere.quantities, plain.quantities, strict=True):
        assert q.quality == "good" and q.value == pytest.approx(usual.value, rel=1e-4)


def test_a_track_that_begins_on_the_level_tells_how_far_the_stated_incline_reaches():
    """By energy: S sin β is given back over the run-out. Without the incline's length
    nothing tells where the level begins."""
    motion = draw_roll()
    track = film_track(motion, np.random.default_rng(0), fps=120, noise_mm=0.1)
    started = track.take(track.x > 30)
    found = named(measure_roll(started, KNOWN))
    for name, q in found.items():
        assert abs(q.value - motion.truth[name]) < 3 * q.sd, name
    assert found["run_out"].sd > 2  # 0.5 mm of a way of 10 mm is 5 % of the run-out
    bare = named(measure_roll(started, replace(KNOWN, roll=Roll(incline_deg=15))))
    assert bare["run_out"].quality == "failed"
    assert "neither the release" in bare["run_out"].reason


def test_a_seed_that_does_not_roll():
    motion = draw_roll()
    track = film_track(
        motion, np.random.default_rng(0), fps=120, until_s=0.1, noise_mm=0.01
    )
    assert all(
        q.quality == "failed" and "does not roll" in q.reason
        for q in measure_roll(track, KNOWN).quantities
    )


def test_energy_lost_at_the_corner_is_named_beside_what_it_would_change():
    """A sharp corner takes up to 2.5 % of the speed; one that takes 10 % is no
    friction, and shortens the run-out."""
    rng = np.random.default_rng(0)
    plain = named(measure_roll(film_track(draw_roll(), rng, fps=240), KNOWN))
    assert {q.quality for q in plain.values()} == {"good"}
    lossy = named(
        measure_roll(film_track(draw_roll(corner_loss=0.1), rng, fps=240), KNOWN)
    )
    for name in ("run_out", "rolling_friction"):
        assert "if the corner takes speed" in lossy[name].reason
    off = abs(lossy["rolling_resistance"].value - 0.012)
    assert off < 2 * lossy["rolling_resistance"].sd


BALL = Seed(length_mm=6.0, width_mm=6.0, thickness_mm=6.0, density_kg_m3=1200.0)
LEVEL = math.radians(unstated_sd("level-plate"))


def rolled(incline_deg=15.0, mm=60.0, mu=0.02, factor=1.4, air=0.0, fall=0.0):
    """A ball of 6 mm from rest down an incline, then along a level that falls by
    `fall`, in so many times the drag of a sphere (Brown & Lawler 2003): steps of
    0.02 ms, nothing of the model."""
    beta, g, step = math.radians(incline_deg), 9806.65, 2e-5
    x, v, out = 0.0, 0.0, [0.0] * int(0.1 / step)
    while x < 1e4 and len(out) < 4 / step:
        drive = math.sin(beta) - mu * math.cos(beta) if x < mm else fall - mu
        re = 1.2 * v / 1000 * 6e-3 / 1.81e-5 + 1e-9
        drag = 24 / re * (1 + 0.150 * re**0.681) + 0.407 / (1 + 8710 / re)
        k = air * 1.2 * drag * 0.75 / 1200 / 6e-3 / 1000  # [1/mm]
        a = (g * drive - k * v * v) / factor
        v = v + a * step
        if v <= 0:
            break
        x += v * step
        out.append(x)
    out += [x] * int(0.3 / step)
    path = np.array(out)[:: round(1 / 240 / step)]
    noisy = path + 0.05 * np.random.default_rng(0).standard_normal(len(path))
    return make_track(np.arange(len(path)) / 240, noisy, 0 * path)


def resistance(track, **changes):
    roll = Roll(incline_deg=15, incline_length_mm=60, direction="+x")
    known = replace(KNOWN, seed=BALL, roll=roll)
    return named(measure_roll(track, replace(known, **changes)))["rolling_resistance"]


@pytest.mark.parametrize("inertia", [None, 2 / 3])
def test_a_ball_in_a_vacuum(inertia):
    seed = BALL.model_copy(update={"inertia_factor": inertia})
    track = rolled(factor=1 + (inertia or 0.4))
    found = resistance(track, seed=seed)
    assert abs(found.value - 0.02) < 2 * found.sd and found.quality == "good"
    # the plate's ± 0.1°, of which the incline tells a part
    assert 0.5 * LEVEL < found.sd < LEVEL
    slope = Roll(incline_deg=15, incline_length_mm=60, direction="+x", slope_deg=0)
    stated = resistance(track, seed=seed, roll=slope)
    assert abs(stated.value - 0.02) < 2 * stated.sd
    assert stated.sd < 0.3 * LEVEL  # its ± 0.02°


def test_air_is_taken_out_and_its_doubt_is_common():
    track = rolled(air=1.3)  # a plate changes it: ± 50 %
    found = resistance(track, air=Air())
    assert abs(found.value - 0.02) < 2 * found.sd
    vacuum = resistance(track)
    assert vacuum.value > 0.0203  # control: what no stated air takes is friction
    rough = 0.5 * np.random.default_rng(1).standard_normal(len(track.x))
    less = replace(track, x=track.x + rough)  # which tells less of the air by itself
    common = [resistance(less, **known).sd_common for known in ({"air": Air()}, {})]
    assert common[0] > 1.02 * common[1]
    unknown = resistance(track, air=Air(), seed=Seed())
    assert unknown.sd > found.sd and abs(unknown.value - 0.02) < 2 * unknown.sd


@pytest.mark.parametrize(("direction", "sign"), [("+x", 1.0), ("-x", -1.0)])
def test_a_stated_slope_is_taken_out_along_the_motion(direction, sign):
    """A slope that falls towards +x speeds up what rolls there."""
    track = rolled(fall=math.tan(math.radians(0.2)) * sign)
    stated = Roll(
        incline_deg=15, incline_length_mm=60, direction=direction, slope_deg=0.2
    )
    found = resistance(replace(track, x=sign * track.x), roll=stated)
    assert abs(found.value - 0.02) < 2 * found.sd
    assert found.sd < 0.3 * LEVEL  # a stated slope's 0.02°


def test_what_nobody_knows_of_the_level_is_common_unless_the_direction_is_stated():
    track = rolled()
    told = resistance(track)
    untold = resistance(track, roll=Roll(incline_deg=15, incline_length_mm=60))
    assert untold.sd == pytest.approx(told.sd, rel=1e-3)
    more = math.sqrt(untold.sd_common**2 - told.sd_common**2)
    assert 0.5 * LEVEL < more < LEVEL  # the incline tells a part


def test_what_cannot_be_told_says_why():
    track = rolled()
    pixels = resistance(replace(track, unit="px"))
    assert pixels.quality == "failed" and "[camera] mm_per_px" in pixels.reason
    untimed = resistance(replace(track, t_s=np.full(len(track), np.nan)))
    assert untimed.quality == "failed" and "[camera] fps" in untimed.reason
    ripple = replace(track, x=track.x + 20 * np.sin(track.x / 60))
    assert "evenly" in resistance(ripple).reason


@pytest.mark.parametrize("unit", ["px", "frames"])
def test_a_run_out_needs_neither_scale_nor_frame_rate(unit):
    """The scale is fitted where it is unknown: what a seed rolls out is in pixels
    then."""
    motion = draw_roll(incline_mm=30)
    track = film_track(motion, np.random.default_rng(0), fps=120, noise_mm=0.05)
    mm = 0.4 if unit == "px" else 1.0
    changed = replace(track, x=track.x / mm, sd=track.sd / mm, unit="px")
    if unit == "frames":
        changed = replace(track, t_s=np.full(len(track), np.nan))
    roll = Roll(incline_deg=15, incline_length_mm=30)
    found = named(measure_roll(changed, replace(KNOWN, roll=roll)))["run_out"]
    assert abs(found.value - motion.truth["run_out"] / mm) < 3 * found.sd
    assert found.sd < 0.02 * found.value
