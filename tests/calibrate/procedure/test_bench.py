"""Bench recordings pooled: tracks and readings, rigs that differ, the odd one out."""

import numpy as np
import pandas as pd
import pytest

from benchtwin.calibrate.procedure.bench import bench_of
from benchtwin.calibrate.procedure.rigs import STEEL


def drop(folder, name, restitution, *, height=0.31, more=""):
    """A track of one bounce with an exactly known rebound, height × e²."""
    g, fall = 9.80665, np.sqrt(2 * height / 9.80665)
    t = np.arange(0, fall + 2 * restitution * fall * 0.95, 1 / 1000)
    after = t - fall
    y = np.where(
        after < 0,
        height - g * t**2 / 2,
        restitution * g * fall * after - g * after**2 / 2,
    )
    (folder / name).mkdir(parents=True)
    pd.DataFrame({"t_s": t, "x_mm": 0.0, "y_mm": 1e3 * y}).to_csv(
        folder / name / "track.csv", index=False
    )
    told = (
        'rig = "drop"\n[camera]\nmm_per_px = 0.2\nmm_per_px_sd ='
        f" 0.0002\n[drop]\nheight_mm = {1e3 * height:g}\n{more}"
    )
    (folder / name / "recording.toml").write_text(told)


def test_tracks_are_pooled_with_their_shared_scale(tmp_path):
    for k, e in enumerate((0.50, 0.51, 0.52, 0.515)):
        drop(tmp_path, f"drop-{k}", e)
    readings = bench_of(tmp_path).rigs["drop"]
    assert readings.values == pytest.approx(
        [310 * e**2 for e in (0.50, 0.51, 0.52, 0.515)], rel=5e-3
    )
    assert readings.shared_sd == pytest.approx(1e-3 * readings.values.max(), rel=0.05)
    mean = readings.mean()
    assert (
        mean.n == 4
        and mean.sd > mean.scatter_sd
        and readings.description["drop"]["height_mm"] == 310.0
    )


def test_another_height_is_another_rig_and_is_left_out(tmp_path):
    for k in range(3):
        drop(tmp_path, f"drop-{k}", 0.5 + 0.01 * k)
    drop(tmp_path, "low", 0.5, height=0.15)
    readings = bench_of(tmp_path).rigs["drop"]
    assert readings.values.size == 3 and any(
        "low: another drop than drop-0" in n for n in readings.notes
    )


def test_the_odd_film_is_named_and_kept(tmp_path):
    for k, e in enumerate((0.50, 0.503, 0.498, 0.501, 0.35)):
        drop(tmp_path, f"drop-{k}", e)
    readings = bench_of(tmp_path).rigs["drop"]
    assert readings.values.size == 5 and any(
        n.startswith("drop-4: 3") and "lies far from the others" in n
        for n in readings.notes
    )


def test_what_cannot_be_read_is_kept_with_its_reason(tmp_path):
    drop(tmp_path, "good", 0.5)
    (tmp_path / "bad").mkdir()
    (tmp_path / "bad" / "recording.toml").write_text('rig = "slide"\n')
    (tmp_path / "bad" / "readings.csv").write_text("slide_angle\n19\n")
    bench = bench_of(tmp_path)
    assert [(n, rig) for n, rig, _ in bench.trouble] == [
        ("bad", "slide")
    ] and "no column of readings" in bench.trouble[0][2]
    assert set(bench.hashes) == {
        "good/track.csv",
        "good/recording.toml",
        "bad/recording.toml",
        "bad/readings.csv",
    }


def test_equations_1_to_3_are_the_papers():
    assert STEEL["drop"].direct(95.0, {"drop": {"height_mm": 310.0}}) == pytest.approx(
        0.5536, abs=1e-4
    )
    assert STEEL["slide"].direct(19.5, {}) == pytest.approx(0.3541, abs=1e-4)
    assert (
        STEEL["roll"].direct(214.0, {}) is None
        and STEEL["drop"].direct(95.0, {}) is None
    )
