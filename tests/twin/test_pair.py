"""Bench and twin over each other: the shift is found, a fixed axis is not shifted, and
what differs is seen."""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchtwin.calibrate.procedure import pairs as procedure
from benchtwin.calibrate.procedure.bench import bench_of
from benchtwin.calibrate.procedure.calibration import Calibration
from benchtwin.calibrate.procedure.effort import QUICK
from benchtwin.report.figures import panels, side_by_side
from benchtwin.twin.pair import Curve, laid_over, pair
from benchtwin.twin.seen import entries_of
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import read_recording

SAMPLES = Path(__file__).parents[2] / "samples"


def bounce(begin: float, tall: float = 300.0) -> Curve:
    t = np.arange(0, 0.6, 0.001)
    return Curve("time (s)", "height (mm)", t + begin, tall * np.abs(np.cos(6 * t)))


def test_the_start_of_the_film_makes_no_difference():
    x, one, other = laid_over(bounce(0.0), bounce(0.15))
    assert (
        np.abs(one - other).max() < 1.5
    )  # a time step of the search, 0.75 ms, at 1.8 m/s
    assert np.ptp(x) > 0.55


def test_what_differs_is_left():
    _, one, other = laid_over(bounce(0.0), bounce(0.3, tall=280.0))
    assert np.abs(one - other).max() == pytest.approx(20.0, abs=1.5)


def test_a_tilt_is_not_shifted():
    tilt = np.linspace(10, 20, 200)
    a, b = (
        Curve(
            "tilt (°)",
            "travel (mm)",
            tilt,
            np.maximum(tilt - onset, 0) ** 2,
            fixed=True,
        )
        for onset in (17.0, 17.5)
    )
    _, one, other = laid_over(a, b)
    assert np.abs(one - other).max() == pytest.approx(3.0**2 - 2.5**2, abs=0.05)


def test_curves_that_do_not_meet_are_refused():
    a, b = (
        Curve(
            "tilt (°)", "travel (mm)", np.linspace(*ends, 50), np.ones(50), fixed=True
        )
        for ends in ((5, 10), (20, 25))
    )
    with pytest.raises(MeasurementError, match="too little in common"):
        laid_over(a, b)


@pytest.mark.parametrize("name", ["drop-01", "slide-01", "roll-01", "pile-01"])
def test_a_recording_beside_itself_is_the_same_and_has_its_pictures(name):
    recording = read_recording(SAMPLES / "soybean-bench" / name)
    same = pair(recording, recording)
    assert same.rig == recording.rig and len(same.x) > 100
    np.testing.assert_allclose(same.bench, same.twin, atol=1e-9)
    assert same.pictures[0] == same.pictures[1] and same.pictures[0].startswith(
        b"\x89PNG"
    )
    assert len(panels([same])[0]["pictures"]) == 2
    drawn = side_by_side(same)
    assert max(abs(v) for v in drawn["data"][2]["y"]) < 1e-6
    assert max(drawn["data"][0]["y"]) > 20  # millimetres


def test_a_slide_without_a_tilt_sensor_is_shown_over_time(tmp_path):
    """Beside a twin that knows its tilt: degrees are not laid over seconds."""
    bench = tmp_path / "slide-01"
    shutil.copytree(SAMPLES / "soybean-bench" / "slide-01", bench)
    shutil.copy(SAMPLES / "soybean-bench" / "bench.toml", tmp_path)
    table = pd.read_csv(bench / "track.csv")
    table.drop(columns="tilt_deg").to_csv(bench / "track.csv", index=False)
    found = pair(
        read_recording(bench), read_recording(SAMPLES / "soybean-bench" / "slide-01")
    )
    assert found.x_name == "time (s)"
    np.testing.assert_allclose(
        found.bench, found.twin, atol=0.5
    )  # a time step of the search at 0.3 m/s


@pytest.fixture(scope="module")
def rolled():
    return bench_of(entries_of(SAMPLES / "soybean-bench", "roll"))


@pytest.fixture
def rolls(rolled, monkeypatch):
    """A calibration of which only the rolls are asked, and rolling friction as it was
    made with."""
    monkeypatch.setattr(Calibration, "most_probable", {"rolling_friction": 0.032})
    more = {
        "joint": None,
        "refused": {},
        "checks": pd.DataFrame(),
        "flags": (),
        "findings": (),
    }
    return Calibration(
        mode="simulated", bench=rolled, steel={"roll": None}, options={}, seed=1, **more
    )


def test_the_twin_of_a_calibrated_rig_stands_beside_the_recording_nearest_the_mean(
    rolls, tmp_path
):
    (found,), why = procedure.pairs(rolls, tmp_path, QUICK)
    assert (found.rig, why) == ("roll", [])
    table = rolls.bench.rigs["roll"].recordings.set_index("recording")["mean"]
    assert (
        found.recording
        == (table - rolls.bench.rigs["roll"].values.mean()).abs().idxmin()
    )
    assert found.bench.max() == pytest.approx(
        found.twin.max(), rel=0.2
    )  # the concealed slope makes 16 %
    assert found.twin.max() > 100


def test_a_twin_that_cannot_be_run_costs_a_picture_and_nothing_else(
    rolls, tmp_path, monkeypatch
):
    def fails(*_, **__):
        raise RuntimeError("no graphics here")

    monkeypatch.setattr(procedure.Job, "run", fails)
    found, (why,) = procedure.pairs(rolls, tmp_path, QUICK)
    assert found == [] and "no graphics here" in why and why.startswith("roll: roll-0")
