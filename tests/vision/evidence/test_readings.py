"""readings.csv: means, spreads and the paper's trimming, against the paper's own
tables."""

from pathlib import Path

import numpy as np
import pytest

from benchtwin.vision.evidence.readings import observe_readings, summarise
from benchtwin.vision.measurement import DOUBTFUL, MeasurementError
from benchtwin.vision.recording import read_recording

PAPER = Path(__file__).parents[3] / "samples" / "soybean-paper"


def quantity(observation, name):
    return next(q for q in observation.quantities if q.name == name)


@pytest.mark.parametrize(
    ("rig", "name", "mean", "derived", "value"),
    [
        ("drop", "rebound_height", 95.0, "restitution", np.sqrt(95 / 310)),
        ("slide", "slide_angle", 19.51, "static_friction", np.tan(np.radians(19.51))),
        (
            "roll",
            "run_out",
            214.0,
            "rolling_friction",
            10 * np.sin(np.radians(15)) / (10 * np.cos(np.radians(15)) + 214),
        ),
    ],
)
def test_the_papers_bench_tables(rig, name, mean, derived, value):
    """Its text gives 95 mm, 19.5° and 214 mm."""
    observation = observe_readings(read_recording(PAPER / rig))
    assert quantity(observation, name).value == pytest.approx(mean, abs=0.02)
    assert quantity(observation, derived).value == pytest.approx(value, rel=1e-3)


@pytest.mark.parametrize(
    ("angles", "doubtful"), [((0.34, 0.35, 0.36), True), ((1.2, 1.9, 1.5), False)]
)
def test_angles_that_may_be_radians_are_doubtful(tmp_path, angles, doubtful):
    (tmp_path / "a").mkdir()
    rows = "".join(f"{a}\n" for a in angles)
    (tmp_path / "a" / "readings.csv").write_text(f"slide_angle_deg\n{rows}")
    found = observe_readings(read_recording(tmp_path / "a"))
    assert all(("radians" in q.reason) == doubtful for q in found.quantities)


def run_outs(folder, lengths_mm, **roll):
    """Run-outs read off behind an incline of 15° and 20 mm; `roll`: keys beside."""
    folder.mkdir(parents=True)
    told = {"incline_deg": 15.0, "incline_length_mm": 20.0, "direction": '"+x"'} | roll
    keys = "".join(f"{k} = {v}\n" for k, v in told.items() if v is not None)
    (folder / "recording.toml").write_text(f'rig = "roll"\n[roll]\n{keys}')
    rows = "".join(f"{v:.1f}\n" for v in lengths_mm)
    (folder / "readings.csv").write_text(f"run_out_mm\n{rows}")
    return quantity(observe_readings(read_recording(folder)), "rolling_friction")


def run_out(mu, falls_deg, incline_deg=15.0, length_mm=20.0):
    """How far a seed rolls on a plate that falls along its way, by its energy."""
    beta, theta = np.radians([incline_deg, falls_deg])
    drive = np.sin(beta) - mu * np.cos(beta)
    return length_mm * drive / (mu * np.cos(theta) - np.sin(theta))


def test_a_stated_slope_counts_for_run_outs_that_were_read_off(tmp_path):
    """μ .02 on a plate that falls by 0.5° towards +x, run either way; nobody knows it
    where the direction is not stated."""
    for way, sign in (("+x", 1), ("-x", -1)):
        lengths = run_out(0.02, 0.5 * sign) + np.array([-1.0, 0.0, 1.0])
        q = run_outs(tmp_path / way, lengths, slope_deg=0.5, direction=f'"{way}"')
        assert q.value == pytest.approx(0.02, abs=2e-4) and q.quality == "good"
        wrong = run_outs(tmp_path / f"{way} level", lengths)
        assert abs(wrong.value - 0.02) > 0.005  # the control
    unknown = run_outs(tmp_path / "?", lengths, slope_deg=0.5, direction=None)
    assert unknown.quality == DOUBTFUL and "direction is not" in unknown.reason


@pytest.mark.parametrize("slope_deg", [None, 0.0])
def test_how_level_a_plate_is_stands_in_the_sd_of_a_run_out_s_friction(
    tmp_path, slope_deg
):
    """Plates level to 0.1° where nobody states it, to 0.02° where somebody does: 95 %
    intervals hold in 95 ± 3 (2 sd) of 100; by the scatter of readings alone in half."""
    rng, held, alone = np.random.default_rng(8), [], []
    sd = 0.1 if slope_deg is None else 0.02
    for k in range(100):
        incline = 15.0 + 0.1 * rng.standard_normal()
        length = 20.0 + 0.5 * rng.standard_normal()
        mean = run_out(0.02, sd * rng.standard_normal(), incline, length)
        lengths = mean * (1 + 0.01 * rng.standard_normal(8))
        q = run_outs(tmp_path / str(k), lengths, slope_deg=slope_deg)
        off = abs(q.value - 0.02)
        held.append(off < 1.96 * q.sd)
        alone.append(off < 1.96 * np.sqrt(q.sd**2 - q.sd_common**2))
    assert sum(held) >= 89 and sum(alone) < 75


def test_the_papers_range_of_restitution():
    """Its text: 0.47 to 0.62 for 70 to 120 mm."""
    row = observe_readings(read_recording(PAPER / "drop")).readings.iloc[0]
    assert np.sqrt(np.array([row.low, row.high]) / 310) == pytest.approx(
        [0.47, 0.62], abs=0.006
    )
    assert (row.n, row.left_out) == (10, 0)


def test_a_single_reading_has_no_sd():
    q = quantity(observe_readings(read_recording(PAPER / "pile")), "repose_angle")
    assert q.value == 31
    assert np.isnan(q.sd)
    assert q.quality == DOUBTFUL


def test_trimming_leaves_out_one_highest_and_one_lowest():
    s = summarise(np.array([1.0, 5, 6, 7, 100]), trim=True)
    assert (s.mean, s.n, s.low, s.high) == (6.0, 3, 5.0, 7.0)
    assert summarise(np.array([1.0, 5, 6, 7, 100])).n == 5
    assert summarise(np.array([1.0, 2, 3]), trim=True).n == 3  # too few to trim


def test_the_mean_s_interval_covers():
    """95 % of intervals mean ± 1.96 sd_mean hold the truth, for n = 5 as for n = 12:
    Student's t is in the sd."""
    for n in (3, 5, 12):
        rng = np.random.default_rng(n)
        inside = [
            abs(s.mean) <= 1.96 * s.sd_mean
            for s in (summarise(rng.normal(size=n)) for _ in range(2000))
        ]
        assert np.mean(inside) == pytest.approx(
            0.95, abs=0.015
        )  # 3 standard errors of 2,000 runs


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("rebound_height_mm\n96\n-3\n", "rebound_height_mm = -3 in row 3"),
        ("slide_angle_deg\n95\n", "should lie between 0 and 90"),
        ("height\n3\n", "expected one of rebound_height_mm"),
        ("rebound_height_mm\nhigh\n", "'high' in row 2 is not a number"),
        ("rebound_height_mm\n", "no rows"),
        ("", "0 bytes"),
    ],
)
def test_wrong_readings_are_named(tmp_path, text, words):
    (tmp_path / "recording.toml").write_text('rig = "drop"')
    (tmp_path / "readings.csv").write_text(text)
    with pytest.raises(MeasurementError, match=words):
        observe_readings(read_recording(tmp_path))


def test_an_empty_cell_is_left_out_and_said(tmp_path):
    (tmp_path / "recording.toml").write_text('rig = "drop"\n[drop]\nheight_mm = 310.0')
    (tmp_path / "readings.csv").write_text("rebound_height_mm,note\n96,a\n,b\n100,c\n")
    observation = observe_readings(read_recording(tmp_path))
    assert quantity(observation, "rebound_height").value == 98
    assert any("row 3" in note for note in observation.notes)


@pytest.mark.parametrize(
    ("readings", "words"),
    [
        ("380 384 382", "higher than the release"),
        ("0.080 0.084 0.082", "is it in millimetres"),
        ("80 81 82 79 80 240", "far from the others"),
    ],
)
def test_what_can_hardly_be_is_doubted(tmp_path, readings, words):
    (tmp_path / "recording.toml").write_text('rig = "drop"\n[drop]\nheight_mm = 310')
    (tmp_path / "readings.csv").write_text(
        "rebound_height_mm\n" + "\n".join(readings.split())
    )
    for q in observe_readings(read_recording(tmp_path)).quantities:
        assert q.quality == DOUBTFUL
        assert words in q.reason


def test_readings_of_another_rig_are_refused(tmp_path):
    (tmp_path / "recording.toml").write_text('rig = "drop"')
    (tmp_path / "readings.csv").write_text("slide_angle_deg\n19\n20\n")
    with pytest.raises(MeasurementError, match="belongs to a slide, the rig is drop"):
        observe_readings(read_recording(tmp_path))
