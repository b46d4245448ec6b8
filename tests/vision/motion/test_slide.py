"""Slides: the angle at which a block lets go and both frictions, from drawn tracks."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vision.motion.slide import TILT_SD_DEG, measure_slide
from vision.recording import Camera, Recording, Slide
from vision.synthetic.motion import draw_slide, film_track

KNOWN = Recording("s", Path("s"), "slide", "track.csv", (), camera=Camera(mm_per_px=0.25, mm_per_px_sd=0.0002))


def slid(seed=0, *, fps=240, ar=0.0, before=1.0, tilt_noise=0.02, noise=0.05, **options):
    motion = draw_slide(**options)
    rng = np.random.default_rng(seed)
    start = max(motion.truth["onset_s"] - before, 0)
    track = film_track(motion, rng, fps=fps, ar=ar, noise_mm=noise, tilt_noise_deg=tilt_noise, start_s=start)
    return motion, track


def named(result):
    return {q.name: q for q in result.quantities}


@pytest.mark.parametrize("static, kinetic", [(0.35, 0.28), (0.35, 0.35), (0.6, 0.3), (0.2, 0.19)])
@pytest.mark.parametrize("fps", [30, 500])
def test_frictions_of_drawn_slides(static, kinetic, fps):
    motion, track = slid(1, fps=fps, static=static, kinetic=kinetic, start_deg=5.0)
    for name, q in named(measure_slide(track, KNOWN)).items():
        assert abs(q.value - motion.truth[name]) < 3 * q.sd, name
        assert q.quality == "good"
    assert named(measure_slide(track, KNOWN))["slide_angle"].sd < 0.15


def test_a_threshold_would_be_late():
    """Control: the angle at which the block has moved 1 mm is 0.13° late."""
    motion, track = slid(1)
    late = track.tilt_deg[np.argmax(track.x > 1.0)]
    assert late - motion.truth["slide_angle"] > 0.1
    assert abs(named(measure_slide(track, KNOWN))["slide_angle"].value - motion.truth["slide_angle"]) < 0.03


def test_the_turning_plate_is_borne_less_on(monkeypatch):
    """With μ_k = μ_s the block sets off so gently that the Coriolis force tells: without it the onset comes out late."""
    motion, track = slid(noise=0.002, tilt_noise=0.001, fps=50, static=0.34, kinetic=0.34, start_deg=5.0, before=5.0)

    def off():
        found = named(measure_slide(track, KNOWN))["slide_angle"]
        assert 0.05 <= found.sd < 0.06 and found.quality == "good"  # the goniometer's; the fit adds little
        return found.value - motion.truth["slide_angle"]

    assert abs(off()) < 0.02
    monkeypatch.setattr("vision.motion.slide._turning", lambda time, x, tilt: 0 * time)  # control
    assert abs(off()) > 0.04


@pytest.mark.parametrize("ar", [0.0, 0.9])
def test_intervals_hold_the_truth_when_the_sensor_is_off_by_its_sd(ar):
    inside = []
    for seed in range(80):
        motion, track = slid(seed, fps=120, ar=ar)
        rng = np.random.default_rng(10_000 + seed)
        off = replace(
            track, tilt_deg=track.tilt_deg + TILT_SD_DEG * rng.standard_normal(), x=track.x * (1 + 8e-4 * rng.standard_normal())
        )
        for name, q in named(measure_slide(off, KNOWN)).items():
            inside.append(abs(q.value - motion.truth[name]) < 1.96 * q.sd)
    assert 0.90 <= np.mean(inside) <= 0.99


def test_the_tilt_rate_stands_in_for_the_column_and_says_what_it_assumes():
    motion = draw_slide(start_deg=0.0)
    track = film_track(motion, np.random.default_rng(0), fps=100, noise_mm=0.05)
    known = replace(KNOWN, slide=Slide(tilt_rate_deg_s=2.0))
    result = measure_slide(replace(track, tilt_deg=None), known)
    assert abs(named(result)["slide_angle"].value - motion.truth["slide_angle"]) < 0.05
    assert any("level at t = 0" in note for note in result.notes)
    assert all(q.quality == "doubtful" and "level at t = 0" in q.reason for q in result.quantities)
    assert {q.quality for q in measure_slide(track, KNOWN).quantities} == {"good"}  # control: a measured tilt


def test_without_any_tilt_both_keys_are_named():
    _, track = slid()
    for q in measure_slide(replace(track, tilt_deg=None), KNOWN).quantities:
        assert q.quality == "failed" and "tilt_deg" in q.reason and "tilt_rate_deg_s" in q.reason


def test_uphill_axis_and_pixels():
    motion, track = slid(slope_sign=-1.0)
    assert abs(named(measure_slide(track, KNOWN))["static_friction"].value - 0.35) < 0.002
    bare = replace(track, unit="px")
    found = named(measure_slide(bare, replace(KNOWN, camera=Camera())))
    assert abs(found["slide_angle"].value - motion.truth["slide_angle"]) < 0.1
    assert found["kinetic_friction"].quality == "failed" and "mm_per_px" in found["kinetic_friction"].reason


def test_a_block_that_stays_fails_with_the_reason():
    motion, track = slid()
    still = track.take(track.t_s < motion.truth["onset_s"] - 0.05)
    assert all(q.quality == "failed" and "does not slide" in q.reason for q in measure_slide(still, KNOWN).quantities)


def test_a_block_already_on_its_way_is_doubtful():
    motion, track = slid()
    late = track.take(track.t_s > motion.truth["onset_s"] + 0.1)
    found = named(measure_slide(late, KNOWN))["slide_angle"]
    assert found.quality != "good"


def test_what_happens_after_the_stop_is_not_fitted():
    _, track = slid(fps=240)
    n = 120
    time = np.concatenate([track.t_s, track.t_s[-1] + np.arange(1, n + 1) / 240])
    rng = np.random.default_rng(0)
    x = np.concatenate([track.x, track.x[-1] + 0.05 * rng.standard_normal(n)])
    from vision.motion.track import make_track

    longer = make_track(time, x, 0 * x, sd=0.05, tilt_deg=np.concatenate([track.tilt_deg, np.full(n, track.tilt_deg[-1])]))
    found = named(measure_slide(longer, KNOWN))
    assert abs(found["kinetic_friction"].value - 0.28) < 3 * found["kinetic_friction"].sd
    assert any("slide ends" in note for note in measure_slide(longer, KNOWN).notes)


def test_friction_that_changes_on_the_way_is_doubtful():
    motion, track = slid(noise=0.02)
    time = track.t_s - motion.truth["onset_s"]
    jerk = 6.0 * np.sin(20 * np.clip(time, 0, None))  # mm, a stick-slip ripple
    found = named(measure_slide(replace(track, x=track.x + jerk), KNOWN))
    assert all(q.quality == "doubtful" for q in found.values())
