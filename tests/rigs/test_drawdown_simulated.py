"""A small draw-down in the simulation, and its photo measured by the bench's code."""

import json
from dataclasses import replace

import numpy as np
import pytest
from benchtwin.measure.observe import observe
from benchtwin.sim.rigs.drawdown import OF_A_FLOW, Drawdown, run_drawdown
from benchtwin.sim.rigs.engine import Ours
from benchtwin.twin import Parameters
from benchtwin.twin.job import Job
from benchtwin.twin.parameters import bench
from benchtwin.vision.recording import Recording

SMALL = Drawdown(
    box_m=(0.060, 0.024, 0.050),
    slot_m=0.025,
    fill_height_m=0.040,
    fall_m=0.050,
    tray_m=0.080,
)
KEYS = {
    "box_mm": [60.0, 24.0, 50.0],
    "slot_mm": 25.0,
    "fill_height_mm": 40.0,
    "fall_mm": 50.0,
    "tray_mm": 80.0,
}
CAMERA = {
    "width_px": 900,
    "height_px": 900,
    "mm_per_px": 0.13,
    "target_mm": [45.0, 0.0, 0.0],
}


def run(rig: Drawdown, seed: int = 1, **parameters: float):
    recording = Recording("a", None, "drawdown", "", ())  # type: ignore[arg-type]
    made = Parameters(**parameters).for_rig("drawdown")
    on = bench(made, "drawdown", recording.seed, recording.air)
    return run_drawdown(rig, on, np.random.default_rng(seed), engine=Ours(1)).truth


@pytest.fixture(scope="module")
def rough():
    return run(SMALL, seed_static_friction=0.6, seed_rolling_friction=0.06)


def test_no_gram_is_made_and_some_stays_some_falls(rough):
    spilt = rough["filled_mass_g"] - rough["retained_mass_g"] - rough["tray_mass_g"]
    assert spilt > -1e-9 and rough["retained_mass_g"] > 0 and rough["tray_mass_g"] > 0
    assert rough["jammed"] == 0 and rough["lies_still"] == 1
    assert all(np.isfinite(rough[name]) for name in OF_A_FLOW)


def test_seeds_without_friction_run_out_faster_and_hold_no_slope(rough):
    """No friction on seed, shelf or pane: what stays is a layer that the shelf's end
    does not let go; control: the same box with rough seeds holds back twice as much."""
    slick = run(
        replace(SMALL, slab=True),
        static_friction=0.0,
        rolling_friction=0.0,
        seed_static_friction=0.0,
        seed_rolling_friction=0.0,
    )
    kept, held = (t["retained_mass_g"] / t["filled_mass_g"] for t in (slick, rough))
    assert kept < 0.1 and held > 2 * kept
    assert slick["flow_time_s"] < rough["flow_time_s"]


def test_a_narrow_slot_jams_and_says_nothing_of_slopes():
    found = run(replace(SMALL, slot_m=0.013), seed_static_friction=0.9)
    assert found["jammed"] == 1
    assert all(np.isnan(found[name]) for name in OF_A_FLOW)


def test_the_photo_shows_what_the_simulation_knows(tmp_path):
    job = Job(
        "drawdown", Parameters(), {"drawdown": KEYS, "camera": CAMERA}, rng=(3, 1)
    )
    recording = job.run(tmp_path / "a", threads=1)
    truth = json.loads((tmp_path / "a" / "simulation.json").read_text())["truth"]
    assert recording.drawdown.jammed is False and recording.drawdown.shelf_px
    seen = {q.name: q for q in observe(recording).quantities}
    for name, most in (("shear", 1.0), ("heap", 1.0)):
        for what in ("angle", "centroid"):
            q = seen[f"{name}_{what}"]
            assert abs(q.value - truth[f"{name}_{what}_deg"]) < most, q
    assert seen["flow_time"].value == pytest.approx(truth["flow_time_s"], abs=1e-3)
    out = truth["filled_mass_g"] - truth["retained_mass_g"]
    expected = 0.8 * out / truth["flow_time_s"]
    assert seen["mass_flow"].value == pytest.approx(expected, rel=0.01)
