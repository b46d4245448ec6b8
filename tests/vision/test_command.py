"""`benchtwin measure` as a user meets it: files written, table printed, exit codes,
nothing overwritten, the batch goes on."""

import html
import re
from urllib.parse import unquote

import numpy as np
import pandas as pd
import pytest
from PIL import Image
from synthetic.piles import PileScene, draw_pile
from typer.testing import CliRunner

from benchtwin.command_line import app

COLUMNS = "recording,rig,quantity,value,sd,sd_common,unit,quality,reason,overlay"


@pytest.fixture
def run():
    return lambda *args: CliRunner().invoke(app, ["measure", *map(str, args)])


@pytest.fixture
def photos(tmp_path):
    folder = tmp_path / "my photos (ä)"
    folder.mkdir()
    for name, angle in (("a", 28), ("b [2]", 33)):
        picture = draw_pile(
            PileScene(angle_deg=angle, size=(600, 400), pile_height=120),
            np.random.default_rng(0),
        )
        Image.fromarray(picture).save(folder / f"{name}.png")
    return folder


def test_a_folder_of_photos(run, photos, tmp_path):
    out = tmp_path / "new folder" / "out"
    result = run(photos, "--out", out)
    assert result.exit_code == 0, result.output
    assert (out / "measurements.csv").read_text().splitlines()[0] == COLUMNS
    table = pd.read_csv(out / "measurements.csv")
    angles = table[table.quantity == "repose_angle"].set_index("recording").value
    assert angles["a"] == pytest.approx(28, abs=0.1)
    assert angles["b [2]"] == pytest.approx(33, abs=0.1)
    for overlay in table.overlay.unique():
        assert (
            np.asarray(Image.open(out / overlay)).shape[1] == 800
        )  # small pictures are shown larger
    assert str(angles["a"])[:5] in result.output
    assert "b [2]" in result.output


def test_the_workbook_holds_what_the_tables_hold(run, photos, tmp_path):
    run(photos, "--out", tmp_path / "out")
    book = pd.read_excel(tmp_path / "out" / "results.xlsx", None, engine="openpyxl")
    means = pd.read_csv(tmp_path / "out" / "summary.csv")
    read = book["means over repeats"]
    assert read["quantity"].tolist() == means["quantity"].tolist()
    assert np.allclose(read["mean"], means["mean"], rtol=1e-3)  # summary.csv is rounded
    named = book["units and methods"]["column"]
    for column in ("scatter", "measuring", "common", "quality", "sd_common"):
        assert column in set(named)


def test_what_failed_stands_last_where_it_is_seen(run, photos, tmp_path):
    Image.fromarray(np.full((300, 300), 99, np.uint8)).save(photos / "z blank.png")
    result = run(photos, "--out", tmp_path / "out")
    assert result.exit_code == 0
    assert (
        result.output.index("b [2]")
        < result.output.index("look at these")
        < result.output.index("z blank")
    )
    table = pd.read_csv(tmp_path / "out" / "measurements.csv")
    assert table[table.recording == "z blank"].quality.tolist() == ["failed"]


def test_phone_photos_are_measured_and_what_is_not_read_is_named(run, photos, tmp_path):
    Image.open(photos / "a.png").save(photos / "phone.HEIC")
    (photos / "phone.AAE").write_bytes(b"edits")
    (photos / "notes.txt").write_text("the first heap")
    result = run(photos, "--out", tmp_path / "out")
    table = pd.read_csv(tmp_path / "out" / "measurements.csv")
    angles = table[table.quantity == "repose_angle"].set_index("recording").value
    assert angles["phone"] == pytest.approx(28, abs=0.3)
    notes = pd.read_csv(tmp_path / "out" / "notes.csv").set_index("recording").note
    assert notes[photos.name].startswith("not read: phone.AAE (")
    assert "phone.AAE" in result.output


def test_a_table_beside_evidence_that_is_not_read_is_named(run, photos, tmp_path):
    (photos / "angles.csv").write_text("photo,angle\na,28\n")
    assert run(photos, "--out", tmp_path / "out").exit_code == 0
    notes = pd.read_csv(tmp_path / "out" / "notes.csv").set_index("recording").note
    assert notes[photos.name].startswith("not read: angles.csv (")


def test_a_bad_file_does_not_stop_the_batch(run, photos, tmp_path):
    (photos / "broken.png").write_bytes((photos / "a.png").read_bytes()[:200])
    (photos / "empty.jpg").write_bytes(b"")
    assert run(photos, "--out", tmp_path / "out").exit_code == 0
    table = pd.read_csv(tmp_path / "out" / "measurements.csv").set_index("recording")
    assert "cut short" in table.loc["broken"].reason
    assert "0 bytes" in table.loc["empty"].reason
    assert (
        table.quality == "good"
    ).sum() == 14  # two heaps: angle, toe, top, left, right, height/radius, centroid


def test_nothing_measured_is_exit_1(run, tmp_path):
    (tmp_path / "in").mkdir()
    result = run(tmp_path / "in", "--out", tmp_path / "out")
    assert result.exit_code == 1
    assert (
        "nothing to measure here" in (tmp_path / "out" / "measurements.csv").read_text()
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--window", "80-20"), "--window 80-20"),
        (("--window", "x"), "such as 20-80"),
        (("--roi", "1,2,3"), "--roi 1,2,3"),
        (("--baseline", "1,2"), "--baseline 1,2: expected 1 or 4 numbers"),
    ],
)
def test_misuse_is_exit_2(run, photos, tmp_path, arguments, words):
    result = run(photos, "--out", tmp_path / "out", *arguments)
    assert result.exit_code == 2
    assert words in result.output
    assert not (tmp_path / "out").exists()


def test_a_path_that_is_not_there_is_exit_2(run, tmp_path):
    result = run(tmp_path / "nowhere", "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert "no such file or folder" in result.output
    assert run(tmp_path).exit_code == 2  # no --out


def test_nothing_is_overwritten_unasked(run, photos, tmp_path):
    out = tmp_path / "out"
    assert run(photos, "--out", out).exit_code == 0
    before = (out / "measurements.csv").stat().st_mtime_ns
    result = run(photos, "--out", out)
    assert result.exit_code == 2
    assert "--overwrite" in result.output
    assert (out / "measurements.csv").stat().st_mtime_ns == before
    assert run(photos, "--out", out, "--overwrite").exit_code == 0
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter1.txt").write_text("years of work")
    result = run(photos, "--out", tmp_path / "thesis", "--overwrite")
    assert result.exit_code == 2
    assert (tmp_path / "thesis" / "chapter1.txt").exists()


def test_overwrite_never_takes_what_is_not_its_own(run, photos, tmp_path):
    out = tmp_path / "out"
    assert run(photos, "--out", out).exit_code == 0
    (out / "my notes.txt").write_text("keep")
    result = run(photos, "--out", out, "--overwrite")
    assert result.exit_code == 2
    assert "my notes.txt" in result.output
    assert (out / "my notes.txt").exists()
    (photos / "measurements.csv").write_text(
        "looks like results"
    )  # a bench folder is no results folder
    assert run(photos / "a.png", "--out", photos, "--overwrite").exit_code == 2
    assert (photos / "a.png").exists()


def test_a_fault_of_ours_costs_one_recording(run, photos, tmp_path, monkeypatch):
    from benchtwin.rigs.pile import observe

    whole = observe.observe_pile

    def fails(recording, *options):
        return 1 / 0 if recording.id == "a" else whole(recording, *options)

    monkeypatch.setattr(observe, "observe_pile", fails)
    assert run(photos, "--out", tmp_path / "out").exit_code == 0
    table = pd.read_csv(tmp_path / "out" / "measurements.csv").set_index("recording")
    assert "please report" in table.loc["a"].reason
    assert "ZeroDivisionError" in table.loc["a"].reason


def test_the_same_evidence_twice_counts_once(run, photos, tmp_path):
    assert (
        run(
            photos,
            photos / "a.png",
            photos / ".." / photos.name,
            "--out",
            tmp_path / "out",
        ).exit_code
        == 0
    )
    table = pd.read_csv(tmp_path / "out" / "measurements.csv")
    assert (table.quantity == "repose_angle").sum() == 2


def test_seeds_that_fail_are_seeds(run, tmp_path):
    Image.fromarray(np.full((100, 100), 9, np.uint8)).save(tmp_path / "flat.png")
    assert (
        run("--seeds", tmp_path / "flat.png", "--out", tmp_path / "out").exit_code == 1
    )
    assert pd.read_csv(tmp_path / "out" / "measurements.csv").quantity.tolist() == [
        "seed_length"
    ]


def test_quiet_prints_nothing(run, photos, tmp_path):
    result = run(photos, "--out", tmp_path / "out", "--quiet")
    assert result.exit_code == 0
    assert result.output == ""


def test_window_roi_and_baseline_reach_the_measurement(run, photos, tmp_path):
    result = run(
        photos / "a.png",
        "--out",
        tmp_path / "out",
        "--window",
        "30-70",
        "--roi",
        "0,0,600,399",
        "--baseline",
        "320",
    )
    assert result.exit_code == 0, result.output
    notes = (tmp_path / "out" / "notes.csv").read_text()
    assert "base line: given" in notes
    assert "30–70 %" in notes


def test_no_half_results_are_left_behind(run, photos, tmp_path, monkeypatch):
    from benchtwin.measure import measured

    def broken(*args, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(measured, "observe_or_fail", broken)
    assert run(photos, "--out", tmp_path / "out").exit_code == 1
    assert sorted(p.name for p in tmp_path.iterdir()) == [photos.name]


def test_the_contact_sheet_shows_every_picture_with_its_numbers(run, photos, tmp_path):
    Image.fromarray(np.asarray(Image.open(photos / "a.png"))).save(
        photos / "<i>&#1 %20.png"
    )
    assert run(photos, "--out", tmp_path / "out").exit_code == 0
    page = (tmp_path / "out" / "overlays" / "index.html").read_text()
    shown = [
        unquote(html.unescape(name))
        for name in re.findall(r'<img loading="lazy" src="([^"]*)"', page)
    ]
    assert sorted(shown) == sorted(
        p.name for p in (tmp_path / "out" / "overlays").glob("*.png")
    )
    assert len(re.findall(r"repose angle 2[78][\d.]* ± [\d.]+°", page)) == 2
    assert "<i>" not in page


def test_conditions_are_columns_of_every_table(run, tmp_path):
    for name, moisture, rebound in (
        ("a", 10, 70),
        ("b", 10, 72),
        ("c", 14, 60),
        ("d", 14, 61),
    ):
        (tmp_path / "bench" / name).mkdir(parents=True)
        text = (
            'rig = "drop"\n[drop]\nheight_mm = 310\n[conditions]\nmoisture_pct ='
            f" {moisture}\n"
        )
        (tmp_path / "bench" / name / "recording.toml").write_text(text)
        (tmp_path / "bench" / name / "readings.csv").write_text(
            f"rebound_height_mm\n{rebound}\n{rebound + 1}\n"
        )
    result = run(tmp_path / "bench", "--out", tmp_path / "out")
    for table in ("measurements", "readings"):
        assert set(pd.read_csv(tmp_path / "out" / f"{table}.csv").moisture_pct) == {
            10,
            14,
        }
    means = pd.read_csv(tmp_path / "out" / "summary.csv").set_index(
        ["quantity", "conditions"]
    )
    assert means.loc[("rebound_height", "moisture_pct = 10"), "mean"] == pytest.approx(
        71.5
    )
    assert "drop rebound_height, moisture_pct = 14" in result.output
