"""Rolling resistance from slowing down on the level, against closed forms."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from benchtwin.bench.keys import Air, Camera, Seed
from benchtwin.rigs.roll.keys import Roll
from benchtwin.vision.motion.rolling_resistance import LEVEL_SD_DEG, fit_resistance
from benchtwin.vision.motion.track import make_track
from benchtwin.vision.recording import Recording

G, SPEED, FPS = 9806.65, 300.0, 240.0
BALL = Seed(length_mm=6.0, width_mm=6.0, thickness_mm=6.0, density_kg_m3=1200.0)
KNOWN = Recording(
    "r",
    Path("r"),
    "roll",
    "track.csv",
    (),
    camera=Camera(mm_per_px=0.25, mm_per_px_sd=0.0002),
    seed=BALL,
    air=Air(density_kg_m3=0.0),
    roll=Roll(direction="+x"),
)


def rolled(slow: float, k: float = 0.0, noise: float = 0.0):
    """A seed that enters the level at SPEED [mm/s] and loses `slow` + k v² [mm/s²]: v =
    √(s/k) tan(φ − √(s k) t)."""
    if k:
        root = math.sqrt(slow * k)
        phase = math.atan(SPEED * math.sqrt(k / slow))
        end = phase / root
        time = np.arange(0, end + 0.2, 1 / FPS)
        x = np.log(np.cos(phase - root * np.minimum(time, end)) / math.cos(phase)) / k
    else:
        end = SPEED / slow
        time = np.arange(0, end + 0.2, 1 / FPS)
        t = np.minimum(time, end)
        x = SPEED * t - slow * t**2 / 2
    return make_track(
        time, x + noise * np.random.default_rng(0).standard_normal(len(x)), 0 * x
    ), float(x[-1])


def resistance(track, stop, recording=KNOWN):
    level = fit_resistance(track, track.x, (0.0, 0.1), stop, recording)
    assert len(level.curve) == level.rows.sum()
    return level.resistance


@pytest.mark.parametrize("inertia", [None, 2 / 3])
def test_a_ball_in_a_vacuum(inertia):
    factor = 1 + (inertia or 0.4)
    recording = replace(KNOWN, seed=BALL.model_copy(update={"inertia_factor": inertia}))
    found = resistance(*rolled(0.03 * G / factor, noise=0.05), recording)
    assert (
        abs(found.value - 0.03) < 2e-4 and found.quality == "good"
    )  # the level's 0.05° are not in this track
    assert found.sd == pytest.approx(math.radians(LEVEL_SD_DEG), rel=0.1)


def test_air_is_taken_out_and_its_doubt_is_common():
    """At 300 mm/s Re is 120 to 0 on the way, C_d some 1 on average; the closed form
    needs one k."""
    from benchtwin.vision.motion.gravity import drag_per_metre

    windy = replace(KNOWN, air=Air())
    k = drag_per_metre(windy, 0.2) / 1000 / 1.4
    track, stop = rolled(0.02 * G / 1.4, k)
    found = resistance(track, stop, windy)
    assert abs(found.value - 0.02) < 2e-4
    assert (
        resistance(track, stop).value > 0.0203
    )  # control: where no air is stated, what it takes is friction
    assert found.sd_common > 1e-4
    unknown = resistance(track, stop, replace(windy, seed=Seed()))
    assert unknown.sd > found.sd and abs(unknown.value - 0.02) < 2 * unknown.sd


def test_a_stated_slope_is_taken_out_along_the_motion():
    for direction, sign in (("+x", 1.0), ("-x", -1.0)):
        fall = (
            math.tan(math.radians(0.2)) * sign
        )  # falls towards +x: speeds up what rolls there
        track, stop = rolled((0.03 - fall) * G / 1.4)
        sloping = replace(KNOWN, roll=Roll(direction=direction, slope_deg=0.2))
        assert resistance(track, stop, sloping).value == pytest.approx(0.03, abs=2e-5)


def test_what_nobody_knows_of_the_level_is_common_unless_the_direction_is_stated():
    track, stop = rolled(0.03 * G / 1.4)
    assert resistance(track, stop).sd_common < 2e-4
    found = resistance(track, stop, replace(KNOWN, roll=Roll()))
    assert found.sd_common == pytest.approx(math.radians(LEVEL_SD_DEG), rel=0.05)


def test_a_seed_that_leaves_the_picture_needs_no_stop():
    track, stop = rolled(0.03 * G / 1.4, noise=0.05)
    gone = track.take(track.x < 0.6 * stop)
    assert abs(resistance(gone, None).value - 0.03) < 1e-3


def test_what_cannot_be_told_says_why():
    track, stop = rolled(0.03 * G / 1.4)
    pixels = resistance(replace(track, unit="px"), stop)
    assert pixels.quality == "failed" and "[camera] mm_per_px" in pixels.reason
    untimed = resistance(replace(track, t_s=np.full(len(track), np.nan)), stop)
    assert untimed.quality == "failed" and "[camera] fps" in untimed.reason
    assert "too few" in resistance(track.take(slice(0, None, 40)), stop).reason
    ripple = replace(track, x=track.x + 8 * np.sin(track.x / 10))
    assert "evenly" in resistance(ripple, stop).reason
