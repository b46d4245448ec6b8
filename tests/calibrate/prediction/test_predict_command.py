"""`benchtwin predict`: draws, packings, files, comparison with recordings, and what is
refused, over a simulator in closed form."""

import json

import numpy as np
import pandas as pd
import pytest
from command_code import command_code, simulated_by
from prediction_stand_in import FRICTION_SD, MEAN, SLOPE_DEG, Angles, write_calibrated

from benchtwin import predict
from benchtwin.calibrate.prediction.predict import DRAWN


@pytest.fixture
def calibrated(tmp_path):
    return write_calibrated(tmp_path / "calibrated")


def asked(calibrated, tmp_path, **more) -> dict:
    told = {"calibrated": calibrated, "rig": "cylinder", "out": tmp_path / "out"}
    return told | more


def predict_command(options, simulator) -> int:
    return command_code("predict", simulator, **options)


def predicted(options, simulator):
    with simulated_by(simulator):
        return predict(**options)


def recordings(
    folder,
    angles,
    toml='rig = "pile"\n[pile]\ncylinder_mm = [70, 150]\n',
    column="repose_angle_deg",
):
    """One recording a reading."""
    for k, angle in enumerate(angles):
        (folder / f"r-{k}").mkdir(parents=True)
        (folder / f"r-{k}" / "recording.toml").write_text(toml)
        (folder / f"r-{k}" / "readings.csv").write_text(f"{column}\n{angle}\n")
    return folder


def test_every_draw_has_its_own_parameters_and_packing_and_the_set_its_repeats(
    calibrated, tmp_path
):
    simulate = Angles()
    found = predicted(asked(calibrated, tmp_path, draws=10, packings=5), simulate)
    frictions = [run.values["seed_static_friction"] for run in simulate.runs]
    assert len(set(frictions[:10])) == 10 and len(set(frictions[10:])) == 1
    assert frictions[10] == MEAN["seed_static_friction"]
    assert len({run.rng for run in simulate.runs}) == 15
    assert simulate.runs[0].description["pile"]["cylinder_mm"] == [70.0, 150.0]
    assert simulate.runs[0].description["seed"]["length_mm"] == 7.5
    assert (found.runs["kind"] == DRAWN).sum() == 10


def test_more_draws_begin_with_the_same_runs(calibrated, tmp_path):
    few, many = Angles(), Angles()
    predicted(asked(calibrated, tmp_path, draws=6), few)
    predicted(asked(calibrated, tmp_path, draws=9, overwrite=True), many)
    assert many.runs[:6] == few.runs[:6] and many.runs[9:] == few.runs[6:]


@pytest.mark.parametrize("rig", ["cylinder", "drum"])
def test_the_known_answer_is_predicted_and_written(calibrated, tmp_path, rig):
    """200 draws: the mean to 4 standard errors, and both parts of the scatter."""
    assert (
        predict_command(
            asked(calibrated, tmp_path, rig=rig, draws=200, packings=60, quiet=True),
            Angles(0.8),
        )
        == 0
    )
    table = pd.read_csv(tmp_path / "out" / "predicted.csv").set_index("quantity")
    row = table.loc["flowing_angle_deg" if rig == "drum" else "repose_angle_deg"]
    expected = (
        15 + SLOPE_DEG * MEAN["seed_static_friction"] + (10 if rig == "drum" else 0)
    )
    assert row["mean"] == pytest.approx(expected, abs=0.45)
    assert row["parameter_sd"] == pytest.approx(SLOPE_DEG * FRICTION_SD, abs=0.3)
    assert row["packing_sd"] == pytest.approx(0.8, abs=0.2)
    assert row["low"] < row["mean_low"] < row["mean"] < row["mean_high"] < row["high"]
    told = json.loads((tmp_path / "out" / "prediction.json").read_text())
    assert told["quantities"][row.name]["mean"] == pytest.approx(row["mean"], rel=1e-4)
    page = (tmp_path / "out" / "prediction.html").read_text()
    assert f"Predicted {rig}" in page and "Plotly.newPlot" in page


def test_a_length_is_predicted_in_millimetres(calibrated, tmp_path, capsys):
    bed = asked(calibrated, tmp_path, rig="bed", draws=60, packings=20)
    assert predict_command(bed, Angles()) == 0
    row = pd.read_csv(tmp_path / "out" / "predicted.csv").iloc[0]
    expected = 0.1 * (15 + SLOPE_DEG * MEAN["seed_static_friction"])
    assert row["unit"] == "mm" and row["mean"] == pytest.approx(expected, abs=0.1)
    assert f"{row['mean']:.1f} ({row['low']:.1f} to {row['high']:.1f}) mm" in (
        capsys.readouterr().out
    )


@pytest.mark.parametrize(
    ("angles", "word"),
    [([24.6, 25.3, 25.2], "within"), ([33.0, 33.9, 33.4], "above"), ([14.0], "below")],
)
def test_recordings_beside_are_compared(calibrated, tmp_path, angles, word):
    beside = recordings(tmp_path / "bench", angles)
    asks = asked(calibrated, tmp_path, beside=beside, draws=30)
    (one,) = predicted(asks, Angles()).beside.itertuples()
    assert word in one.said and one.n == len(angles)
    assert (abs(one.z) <= 1.96) == (word == "within")
    assert one.measured == pytest.approx(np.mean(angles))


def test_recordings_describe_the_rig_that_is_predicted(calibrated, tmp_path):
    toml = 'rig = "drum"\n[drum]\nspeed_rpm = 20\n'
    beside, simulate = (
        recordings(tmp_path / "bench", [35.0, 36.0], toml, "flowing_angle_deg"),
        Angles(),
    )
    predicted(asked(calibrated, tmp_path, rig="drum", beside=beside), simulate)
    assert simulate.runs[0].description["drum"]["speed_rpm"] == 20.0


def test_a_recording_of_another_drum_is_left_out_by_name(calibrated, tmp_path, capsys):
    beside = recordings(
        tmp_path / "bench", [35.0, 36.0], 'rig = "drum"\n', "flowing_angle_deg"
    )
    (beside / "r-1" / "recording.toml").write_text(
        'rig = "drum"\n[drum]\nspeed_rpm = 20\n'
    )
    assert (
        predict_command(
            asked(calibrated, tmp_path, rig="drum", beside=beside), Angles()
        )
        == 0
    )
    assert "r-1: another drum" in capsys.readouterr().out
    again = asked(
        calibrated,
        tmp_path,
        rig="drum",
        beside=beside,
        settings={"drum.speed_rpm": 5},
        overwrite=True,
    )
    assert predict_command(again, Angles()) == 2
    assert "no recording of the predicted drum" in capsys.readouterr().err


def test_a_few_lost_runs_are_told_and_many_stop_it(calibrated, tmp_path, capsys):
    assert predict_command(asked(calibrated, tmp_path, draws=12), Angles(lost=2)) == 0
    assert "2 of 16 simulated runs gave nothing" in capsys.readouterr().out
    assert (
        predict_command(
            asked(calibrated, tmp_path, draws=12, overwrite=True), Angles(lost=8)
        )
        == 1
    )
    assert "it blew up" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"rig": "hopper"}, "no such rig to predict; there are pile, cylinder, drum"),
        ({"draws": 2}, "--draws 2: at least 4"),
        ({"draws": 900}, "--draws 900: the calibration keeps 500"),
        ({"packings": 1}, "--packings 1: at least 3"),
        (
            {"settings": {"seed_static_friction": 0.3}},
            "takes the contact parameters from the calibration",
        ),
        ({"settings": {"pile.nonsense": 3}}, "pile.nonsense"),
        ({"settings": {"pile.cylinder_mm": [400, 150]}}, "must stand on it"),
    ],
)
def test_what_cannot_be_is_said_before_anything_runs(
    calibrated, tmp_path, capsys, more, said
):
    simulate = Angles()
    assert predict_command(asked(calibrated, tmp_path, **more), simulate) == 2
    assert said in capsys.readouterr().err and not simulate.runs


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (
            {
                "parameters": {},
                "not_calibrated": {"pile": "no pile recording was measured"},
            },
            "no rig of many seeds was calibrated (no pile recording",
        ),
        ({"bench": {}}, "bench.described, the lot's seeds, is missing"),
        ({"conventions": 3}, "not a calibration's result"),
    ],
)
def test_a_calibration_that_tells_too_little_is_refused(
    tmp_path, capsys, changed, said
):
    assert (
        predict_command(
            asked(write_calibrated(tmp_path / "c", **changed), tmp_path), Angles()
        )
        == 2
    )
    assert said in capsys.readouterr().err


def test_no_calibration_no_posterior_and_a_foreign_folder_are_refused(
    calibrated, tmp_path, capsys
):
    assert predict_command(asked(tmp_path / "nowhere", tmp_path), Angles()) == 2
    assert "benchtwin calibrate" in capsys.readouterr().err
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.tex").touch()
    assert predict_command(asked(calibrated, tmp_path), Angles()) == 2
    assert "thesis.tex" in capsys.readouterr().err
    (tmp_path / "out" / "thesis.tex").unlink()
    (calibrated / "tables" / "posterior.csv").unlink()
    assert predict_command(asked(calibrated, tmp_path), Angles()) == 2
    assert "draws from the posterior" in capsys.readouterr().err


def test_a_rig_that_was_not_calibrated_is_assumed_and_said(
    calibrated, tmp_path, capsys
):
    file = calibrated / "tables" / "posterior.csv"
    pd.read_csv(file).drop(columns="rolling_friction").to_csv(file, index=False)
    simulate = Angles()
    assert predict_command(asked(calibrated, tmp_path), simulate) == 0
    assert simulate.runs[0].values["rolling_friction"] == 0.01
    assert (
        "rolling_friction was not calibrated: 0.01 is assumed"
        in capsys.readouterr().out
    )
