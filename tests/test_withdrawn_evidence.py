"""What the data do not tell is not good: tracks of every rig of which few rows are
left, or rows as good as nothing."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from synthetic.motion import Motion, draw_drop, draw_roll, draw_slide

from benchtwin.bench.keys import Air, Camera
from benchtwin.rigs.drop.heard import measure_impacts
from benchtwin.rigs.drop.measure import measure_drop
from benchtwin.rigs.roll.keys import Roll
from benchtwin.rigs.roll.measure import measure_roll
from benchtwin.rigs.slide.measure import measure_slide
from benchtwin.vision.measurement import NARROWED
from benchtwin.vision.motion.track import make_track
from benchtwin.vision.recording import Recording

DROP = draw_drop(height_mm=400, restitution=0.6, max_bounces=5)
ROLL = draw_roll(rolling=0.03)
SLIDE = draw_slide(static=0.4, kinetic=0.3)
ENDS = {"drop": 0.62, "roll": ROLL.end_s, "slide": SLIDE.end_s}
MEASURE = {"drop": measure_drop, "roll": measure_roll, "slide": measure_slide}
TRUTH: dict[str, Motion] = {"drop": DROP, "roll": ROLL, "slide": SLIDE}


def recording(rig: str) -> Recording:
    known = {"roll": Roll(incline_deg=15)} if rig == "roll" else {}
    camera = Camera(mm_per_px=0.25, mm_per_px_sd=0.0002)
    air = Air(density_kg_m3=0.0)
    return Recording(
        "r", Path("r"), rig, "track.csv", (), camera=camera, air=air, **known
    )


def measured(rig: str, rows: int, noise_mm: float, seed: int):
    """The quantities of a track of so many rows, each off by so much."""
    motion, rng = TRUTH[rig], np.random.default_rng(seed)
    begin = max(motion.truth.get("onset_s", 1.0) - 1.0, 0.0)
    time = np.linspace(begin, ENDS[rig], rows)
    x, y, _ = motion.path(time)
    x, y = (place + noise_mm * rng.standard_normal(rows) for place in (x, y))
    tilt = None if motion.tilt is None else motion.tilt(time)
    tilt = None if tilt is None else tilt + 0.02 * rng.standard_normal(rows)
    track = make_track(time, x, y, sd=noise_mm, tilt_deg=tilt)
    return MEASURE[rig](track, recording(rig)).quantities


@pytest.mark.parametrize("rig", ["drop", "roll", "slide"])
@pytest.mark.parametrize("rows, noise_mm", [(9, 0.05), (9, 20.0), (60, 20.0)])
def test_what_is_good_is_true_and_told_by_the_data(rig, rows, noise_mm):
    for q in measured(rig, rows, noise_mm, 1):
        if q.quality == "good":
            assert q.sd <= NARROWED * q.believed_sd
            assert q.sd < abs(q.value)
            if q.name in TRUTH[rig].truth:
                assert abs(q.value - TRUTH[rig].truth[q.name]) < 4 * q.sd, q.name


@pytest.mark.parametrize("rig", ["drop", "roll", "slide"])
def test_with_all_evidence_something_is_good(rig):
    """Control: the same tracks, whole."""
    good = [q for q in measured(rig, 400, 0.05, 1) if q.quality == "good"]
    assert len(good) >= 2


def test_a_height_that_nobody_knows_tells_no_restitution():
    """400 ± 400 mm stated, one interval: restitution is what is believed of any."""
    fast = math.sqrt(2 * 9.80665 * 0.4)
    times = np.array([0.3, 0.3 + 2 * 0.9 * fast / 9.80665])
    one = recording("drop")
    told = one.drop.model_copy(update={"height_mm": 400.0, "height_sd_mm": 400.0})
    found, _, _ = measure_impacts(times, np.full(2, 1e-5), replace(one, drop=told))
    by_name = {q.name: q for q in found}
    assert by_name["restitution_normal"].quality == "doubtful"
    assert by_name["restitution"].quality == "doubtful"
    assert by_name["rebound_height"].quality == "good"
