"""docs/start.md walked by somebody who has never seen it: ten photos of heaps, one
sound of ten drops and a film of a slide become three numbers and their pictures.

All of it is drawn (benchmarks/), by code that shares nothing with the reader.
"""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from drawn_sound import SCENES, draw_session, write
from PIL import Image
from synthetic.film import Look, write_video
from synthetic.motion import draw_slide
from synthetic.piles import PileScene, draw_pile
from synthetic.rigs_film import film_slide
from typer.testing import CliRunner

from benchtwin.command_line import app
from benchtwin.vision.recording import Recording

START = Path(__file__).parents[2] / "docs" / "start.md"
ANGLE, ANGLE_SD, E, E_SD, SLIDES_AT = 28.0, 1.0, 0.6, 0.02, 0.35


def heap_photos(folder, rng):
    """Ten photos as a phone names them; the true angles."""
    angles = ANGLE + ANGLE_SD * rng.standard_normal(10)
    for k, angle in enumerate(angles):
        scene = PileScene(
            angle_deg=float(angle),
            size=(1600, 1200),
            pile_height=320 + 20 * rng.random(),
            pile_tone=(205.0, 180.0, 130.0),
            ground_tone=(60.0, 62.0, 66.0),
            plate_tone=(110.0, 112.0, 115.0),
            grain_px=12.0,
            noise=0.015,
            light=0.1,
        )
        picture = Image.fromarray(draw_pile(scene, rng))
        picture.save(folder / f"IMG_{4300 + k}.jpg", quality=92)
    return angles


def ten_drops(folder, rng):
    """One sound as a phone's recorder saves it; the true first restitutions."""
    first = E + E_SD * rng.standard_normal(10)
    loud = replace(next(s for s in SCENES if s.name == "pink"), db=(25, 30))
    drawn = draw_session(loud, first, 300.0, rng)
    write(drawn[0], "aac 128000", folder, "Memo 12")
    return np.array([d.e[0] for d in drawn])


def slide_film(folder, rng):
    """A film as a phone names it, of a block that lets go at atan(SLIDES_AT)."""
    motion = draw_slide(static=SLIDES_AT, start_deg=12, tilt_rate_deg_s=4)
    look = Look(width=640, height=480, mm_per_px=0.4, noise=3, clutter=4)
    frames = film_slide(motion, look, rng, fps=60)
    known = Recording("x", folder / "made", "slide", "video", ())
    made = write_video(known, frames, fps=60, name="IMG_4310.mp4")
    made.files[0].rename(folder / "IMG_4310.mp4")
    (folder / "made" / "recording.toml").unlink()
    (folder / "made").rmdir()


@pytest.fixture(scope="module")
def brought(tmp_path_factory):
    folder = tmp_path_factory.mktemp("brought")
    (folder / "heaps").mkdir()
    rng = np.random.default_rng(12)
    truth = heap_photos(folder / "heaps", rng), ten_drops(folder, rng)
    slide_film(folder, rng)
    return folder, *truth


def measured(out, *paths):
    """What `benchtwin measure` leaves, and the lines of summary.csv by quantity."""
    said = CliRunner().invoke(
        app, ["measure", *(str(p) for p in paths), "--out", str(out)]
    )
    assert said.exit_code == 0, said.output
    assert (out / "overlays" / "index.html").is_file()
    assert list((out / "overlays").glob("*.png"))
    return pd.read_csv(out / "summary.csv").set_index("quantity")


@pytest.mark.slow
def test_ten_heap_photos_give_an_angle(brought, tmp_path):
    """A heap's angle is right to 1° (README): so is the mean of ten."""
    folder, angles, _ = brought
    line = measured(tmp_path / "out", folder / "heaps").loc["repose_angle"]
    assert (line.n, line.not_measured) == (10, 0)
    assert abs(line["mean"] - angles.mean()) < 1.0
    assert line.low < line["mean"] < line.high and line.unit == "deg"


@pytest.mark.slow
def test_one_sound_of_ten_drops_gives_a_restitution(brought, tmp_path):
    """By the file alone, in doubt and with the reason; with the height, good: AAC moves
    single times by 0.5 ms, of intervals of 300."""
    folder, _, e = brought
    out = tmp_path / "bare"
    line = measured(out, folder / "Memo 12.m4a").loc["restitution_normal"]
    assert line.n == line.doubtful == 10 and line.low < e.mean() < line.high
    reasons = pd.read_csv(out / "measurements.csv").reason.dropna()
    assert reasons.str.contains("height_mm is missing").any()
    bench = tmp_path / "bench"
    said = CliRunner().invoke(
        app, ["import", str(folder / "Memo 12.m4a"), "--out", str(bench)]
    )
    assert said.exit_code == 0, said.output
    toml = bench / "Memo 12" / "recording.toml"
    toml.write_text(toml.read_text() + "height_mm = 300\n")  # under its question
    line = measured(tmp_path / "out", bench).loc["restitution_normal"]
    assert (line.n, line.doubtful) == (10, 0)
    assert line.low < e.mean() < line.high
    assert abs(line["mean"] - e.mean()) < 5e-3


@pytest.mark.slow
def test_a_film_of_a_slide_gives_a_friction(brought, tmp_path):
    """The angle is against the picture's horizontal, which nobody stated: ± 1°."""
    folder, *_ = brought
    line = measured(tmp_path / "out", folder / "IMG_4310.mp4").loc["static_friction"]
    assert line.n == 1 and line.low < SLIDES_AT < line.high


@pytest.mark.slow
def test_all_at_once_in_one_folder(brought, tmp_path):
    folder, *_ = brought
    names = ["heaps", "Memo 12.m4a", "IMG_4310.mp4"]
    means = measured(tmp_path / "out", *(folder / name for name in names))
    assert {"repose_angle", "restitution_normal", "static_friction"} <= set(means.index)


def test_what_start_says_is_what_was_walked():
    """The commands of docs/start.md are those walked here, and their options exist."""
    text = START.read_text(encoding="utf8")
    commands = re.findall(r"^\.venv/bin/benchtwin (\w+) (.*)$", text, re.MULTILINE)
    assert {"measure", "import", "page"} <= {verb for verb, _ in commands}
    for verb, rest in commands:
        known = CliRunner().invoke(app, [verb, "--help"], env={"COLUMNS": "200"}).output
        for option in re.findall(r"--[a-z-]+", rest):
            assert option in known, (verb, option)
