"""`benchtwin diagnose` as it is typed: folders in, diagnosis.json and report.html out,
mistakes in one clear line."""

import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import falling
import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from benchtwin.command_line import app

SEED = (
    "length_mm = 8.72\nwidth_mm = 6.84\nthickness_mm = 5.98\ndensity_kg_m3 = 1250.0\n"
)
CAMERA = (
    "fps = 1000.0\nmm_per_px = 0.25\nmm_per_px_sd = 0.0002\nplumb_deg ="
    " 0.0\nplumb_sd_deg = 0.05\ndistance_mm = 20000.0\n"
)
AIRLESS = falling.Bench(stated_air=0.0, bounces=1)
KEYS = {
    "alarm",
    "p_global",
    "sectors",
    "window",
    "verdict",
    "names",
    "ln_bayes_baseline",
    "ln_bayes_runner_up",
    "parameters",
    "law",
    "held_out",
    "next_record",
    "explanations",
    "effects",
    "contact_parameters",
    "matters",
    "p_verdict",
    "moves_mm",
}


def write(folder: Path, bench: falling.Bench, count: int, seed: int) -> Path:
    """`count` drops as a bench folder."""
    rng = np.random.default_rng(seed)
    for k in range(count):
        t, x, z, angle, _ = falling.film(
            replace(bench, height=(0.31, 0.45)[k % 2]), rng
        )
        one = folder / f"drop-{k + 1}"
        one.mkdir(parents=True)
        table = pd.DataFrame({"t_s": t, "x_mm": x, "y_mm": z, "angle_deg": angle})
        table.to_csv(one / "track.csv", index=False, float_format="%.6g")
        height = 1000 * (0.31, 0.45)[k % 2]
        told = (
            'rig = "drop"\n[drop]\nheight_mm ='
            f" {height}\n[seed]\n{SEED}[air]\ndensity_kg_m3 = {bench.stated_air}\n"
        )
        (one / "recording.toml").write_text(
            f"{told}[camera]\n{CAMERA}", encoding="utf8"
        )
    return folder


def diagnose(bench: Path, out: Path, *more: str):
    return CliRunner().invoke(app, ["diagnose", str(bench), "--out", str(out), *more])


@pytest.fixture(scope="module")
def airless(tmp_path_factory):
    """Drops in air whose recordings state none, diagnosed without the twin."""
    folder = tmp_path_factory.mktemp("airless")
    bench = write(folder / "bench", AIRLESS, 3, 1)
    return bench, folder / "out", diagnose(bench, folder / "out", "--no-twin")


@pytest.fixture(scope="module")
def again(airless):
    """The same drops diagnosed with the twin, into a folder with a stopped diagnosis'
    film."""
    out = airless[1].parent / "again"
    (out / "twin" / "drop-9-old").mkdir(parents=True)
    return out, diagnose(airless[0], out, "--quick")


def test_the_verdict_is_printed_and_written(airless):
    _, out, result = airless
    assert result.exit_code == 0, result.output
    assert (
        re.search(r"air drag is missing \(> 99.9 %\), and nothing else", result.output)
        and "of the weight at 2 m/s" in result.output
    )
    found = json.loads((out / "diagnosis.json").read_text())
    assert found["schema"] == 1 and set(found["rigs"]) == {"drop"}
    drop = found["rigs"]["drop"]
    assert (
        set(drop) >= KEYS
        and drop["alarm"]
        and (drop["verdict"], drop["names"]) == ("name", ["drag"])
    )
    value = drop["parameters"]["drag"]
    assert (
        value["unit"] == "1"
        and value["low95"] < 0.0185 * 1.15
        and value["high95"] > 0.0185 * 0.9
    )
    assert (
        drop["sectors"][0]["name"] == "flight"
        and drop["held_out"]["removed_fraction"] > 0.5
    )
    assert {p.name for p in out.iterdir()} == {"diagnosis.json", "report.html"}


def test_equal_seeds_give_equal_numbers(airless, again):
    files = (out / "diagnosis.json" for out in (airless[1], again[0]))
    one, other = (json.loads(file.read_text())["rigs"]["drop"] for file in files)
    assert one == {name: value for name, value in other.items() if name != "twin"}


def test_results_are_not_overwritten(airless):
    bench, out, _ = airless
    refused = diagnose(bench, out, "--no-twin")
    assert (
        refused.exit_code == 2
        and "--overwrite" in refused.output
        and refused.output.count("\n") == 1
    )


def test_the_twin_with_the_effect_is_nearer_and_leftovers_are_replaced(again):
    out, result = again
    assert result.exit_code == 0, result.output
    assert not (out / "twin" / "drop-9-old").exists()
    twin = json.loads((out / "diagnosis.json").read_text())["rigs"]["drop"]["twin"]
    assert (
        twin["rmse_after"] < twin["rmse_before"]
        and twin["effects"] == ["drag"]
        and twin["held_out"]
    )
    assert (
        "run again so that the air's drag law is on" in result.output
        and "the twin is off by" in result.output
    )


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["nowhere", "--out", "out"], "nowhere: no such folder"),
        (["bench", "--out", "bench/out"], "lies within the bench folder"),
        (["bench", "--out", "taken"], "holds letter.txt, which no diagnosis wrote"),
        (["bench", "--out", "file"], "is a file"),
        (
            ["bench", "--out", "out", "--rig", "dorp"],
            "no such rig; there are drop, slide, roll, pile",
        ),
    ],
)
def test_a_mistake_is_one_clear_line(arguments, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for folder in ("bench", "taken"):
        Path(folder).mkdir()
    Path("taken/letter.txt").write_text("dear reader")
    Path("file").write_text("")
    result = CliRunner().invoke(app, ["diagnose", *arguments])
    assert (
        result.exit_code == 2
        and says in result.output
        and result.output.count("\n") == 1
    )
    assert not Path("out").exists()


def test_a_negative_seed_of_random_numbers_is_refused(tmp_path):
    result = CliRunner().invoke(
        app, ["diagnose", str(tmp_path), "--out", str(tmp_path / "out"), "--rng", "-1"]
    )
    assert (
        result.exit_code == 2
        and "greater than or equal to 0" in result.output
        and not (tmp_path / "out").exists()
    )


def test_unusable_recordings_are_reported_and_others_diagnosed(tmp_path):
    bench = write(tmp_path / "bench", replace(AIRLESS, stated_air=1.2), 1, 2)
    for name, toml, track in (
        ("odd", 'rig = "drop"\n[camera]\nfsp = 3\n', "t_s,x_mm,y_mm\n0,0,0\n"),
        (
            "still",
            'rig = "drop"\n',
            "t_s,x_mm,y_mm\n" + "".join(f"{k / 1000},0,0\n" for k in range(50)),
        ),
        (
            "tilted",
            'rig = "slide"\n',
            "t_s,x_mm,y_mm\n" + "".join(f"{k / 100},{k},0\n" for k in range(50)),
        ),
    ):
        (bench / name).mkdir()
        (bench / name / "recording.toml").write_text(toml)
        (bench / name / "track.csv").write_text(track)
    result = diagnose(bench, tmp_path / "out")
    assert result.exit_code == 0, result.output
    for line in (
        "did you mean fps?",
        "still: nothing falls",
        "slide: not diagnosed",
        "tilt_deg",
        "nothing could be held out",
    ):
        assert line in result.output, line
    assert result.output.count("did you mean fps?") == 1
    found = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert list(found["rigs"]) == ["drop"] and "slide" in found["refused"]
    assert {t["recording"] for t in found["trouble"]} == {"odd", "still", "tilted"}
    assert found["rigs"]["drop"]["held_out"] == {
        "rmse_ratio": None,
        "removed_fraction": None,
    }
    page = (tmp_path / "out" / "report.html").read_text()
    assert "did you mean fps?" in page and "nothing could be held out" in page


def test_a_drop_without_a_usable_flight_is_left_out(airless, tmp_path):
    """It is left out, and nothing stumbles over it; asked to be quiet, the command says
    nothing."""
    import shutil

    bench = shutil.copytree(airless[0], tmp_path / "bench")
    rows = pd.read_csv(bench / "drop-1" / "track.csv")
    (bench / "drop-0").mkdir()
    shutil.copy(bench / "drop-1" / "recording.toml", bench / "drop-0")
    rows.iloc[:3].to_csv(bench / "drop-0" / "track.csv", index=False)  # no flight
    result = diagnose(bench, tmp_path / "out", "--quick", "--quiet")
    assert (result.exit_code, result.output) == (0, "")
    drop = json.loads((tmp_path / "out" / "diagnosis.json").read_text())["rigs"]["drop"]
    assert drop["names"] == ["drag"] and drop["recordings"] == [
        "drop-1",
        "drop-2",
        "drop-3",
    ], result.output
    assert {r["recording"] for r in drop["twin"]["recordings"]} == {
        "drop-1",
        "drop-2",
        "drop-3",
    }


def test_an_empty_folder_is_no_diagnosis(tmp_path):
    (tmp_path / "bench").mkdir()
    result = diagnose(tmp_path / "bench", tmp_path / "out")
    assert result.exit_code == 1 and "nothing to measure here" in result.output


def test_drops_in_pixels_have_their_scale_from_gravity(tmp_path):
    bench = write(tmp_path / "bench", AIRLESS, 3, 3)
    for one in bench.iterdir():
        table = pd.read_csv(one / "track.csv")
        frame = np.round(1000 * table.t_s).astype(int)
        pixels = pd.DataFrame(
            {"frame": frame, "x_px": 4 * table.x_mm, "y_px": 4 * table.y_mm}
        )
        pixels.to_csv(one / "track.csv", index=False)
        toml = (
            (one / "recording.toml")
            .read_text()
            .replace("mm_per_px = 0.25\nmm_per_px_sd = 0.0002\n", "")
        )
        (one / "recording.toml").write_text(toml)
    result = diagnose(bench, tmp_path / "out", "--no-twin")
    drop = json.loads((tmp_path / "out" / "diagnosis.json").read_text())["rigs"]["drop"]
    assert drop["names"] == ["drag"] and drop["verdict"] in (
        "name",
        "class",
    ), result.output
    assert "scale-error" not in drop["names"]


def test_a_ball_in_free_flight_needs_no_plate(tmp_path):
    """50 g, 70 mm, 20 m down with C_d = 0.47 all the way: v = v_e tanh(g t/v_e)."""
    rng, end = (
        np.random.default_rng(4),
        np.sqrt(2 * 0.05 * 9.81 / (1.2 * 0.47 * np.pi * 0.035**2)),
    )
    time = np.arange(0, 1.9, 1 / 60)
    for k in range(3):
        one = tmp_path / "bench" / f"ball-{k}"
        one.mkdir(parents=True)
        down = end**2 / 9.81 * np.log(np.cosh(9.81 * time / end))
        columns = {
            "t_s": time,
            "x_mm": rng.normal(0, 5, len(time)),
            "y_mm": -1000 * down + rng.normal(0, 5, len(time)),
        }
        pd.DataFrame(columns).to_csv(one / "track.csv", index=False)
        camera = (
            "[camera]\nfps = 60.0\nmm_per_px = 10.0\nmm_per_px_sd ="
            " 0.05\n[air]\ndensity_kg_m3 = 0.0\n"
        )
        (one / "recording.toml").write_text(
            f'rig = "drop"\n[seed]\nlength_mm = 70.0\nmass_g = 50.0\n{camera}'
        )
    result = diagnose(tmp_path / "bench", tmp_path / "out", "--no-twin")
    drop = json.loads((tmp_path / "out" / "diagnosis.json").read_text())["rigs"]["drop"]
    assert drop["alarm"] and "drag" in drop["names"], result.output


def test_a_fault_in_one_rig_is_reported(airless, tmp_path, monkeypatch):
    from benchtwin.rigs.drop import read

    monkeypatch.setattr(read, "read_drops", lambda folder: folder.lost)
    result = diagnose(airless[0], tmp_path / "out")
    assert result.exit_code == 1 and "please report it: AttributeError" in result.output


def test_no_engine_is_imported_for_a_verdict(airless):
    """What `--no-twin` needs starts quickly: neither the DEM nor the renderer."""
    import subprocess

    code = (
        "import sys; from benchtwin.diagnose import bench;"
        " import benchtwin.rigs.drop.diagnose;"
        " print([m for m in ('benchtwin.sim.engine', 'pyrender', 'plotly',"
        " 'distributed') if m in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


def test_a_rig_that_nobody_states_is_told_to_a_diagnosis_as_to_a_measurement(tmp_path):
    """Readings of sliding angles, as docs/start.md has them, with nothing stated."""
    from benchtwin.diagnose.bench import diagnose_bench

    (tmp_path / "bench" / "slides").mkdir(parents=True)
    rows = "slide_angle_deg\n19\n20\n21\n20.5\n19.5\n"
    (tmp_path / "bench" / "slides" / "readings.csv").write_text(rows)
    found = diagnose_bench(tmp_path / "bench")
    assert list(found.findings) == ["slide"] and not found.trouble
    assert any("taken for a slide: readings" in note for note in found.notes)
