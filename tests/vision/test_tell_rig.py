"""From a bare file to a number: the motion, the sound or the picture tells the rig, or
the message names the command that goes on.

The films are drawn by benchmarks/synthetic, which shares nothing with the reader.
"""

import shutil
import tomllib

import numpy as np
import pandas as pd
import pytest
from drawn_sound import SCENES, draw, write
from synthetic.film import Look, film, write_video
from synthetic.motion import Motion, draw_drop, draw_roll, draw_slide
from synthetic.rigs_film import film_roll, film_slide
from typer.testing import CliRunner

from benchtwin.command_line import app
from benchtwin.vision.recording import Recording
from benchtwin.vision.tell_rig import rig_of_motion


def drop_film(rng):
    motion = draw_drop(height_mm=180, restitution=0.6, end_s=1.0)
    return film(motion, Look(noise=3, plate_row=440), rng, fps=120), 120


def slide_film(rng):
    motion = draw_slide(static=0.35, start_deg=12, tilt_rate_deg_s=4)
    look = Look(width=640, height=480, mm_per_px=0.4, noise=3, clutter=4)
    return film_slide(motion, look, rng, fps=30), 30


def roll_film(rng):
    motion = draw_roll(incline_mm=30, rolling=0.06, end_rest_s=0.5)
    look = Look(mm_per_px=0.4, width=800, height=300, noise=3, origin_px=(110.0, 240.0))
    return film_roll(motion, look, rng, fps=60), 60


def nothing_film(rng):
    still = Motion(lambda t: (0 * t, 50 + 0 * t, 0 * t), 1.0)
    return film(still, Look(noise=3), rng, fps=30), 30


FILMS = {"drop": drop_film, "slide": slide_film, "roll": roll_film}
MAIN = {"drop": "restitution", "slide": "slide_angle", "roll": "run_out"}


def bare(folder, name, draw_film):
    """A film by itself, without a recording.toml."""
    frames, fps = draw_film(np.random.default_rng(3))
    made = write_video(
        Recording("x", folder / "made", None, "video", ()), frames, fps=fps
    )
    file = folder / f"{name}.mp4"
    shutil.move(made.files[0], file)
    shutil.rmtree(folder / "made")
    return file


def ran(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments])


@pytest.mark.parametrize(
    "rig",
    ["drop", *(pytest.param(r, marks=pytest.mark.slow) for r in ("slide", "roll"))],
)
def test_a_film_by_itself_is_measured_and_imported_as_its_rig(rig, tmp_path):
    file = bare(tmp_path, "IMG_0042", FILMS[rig])
    said = ran("measure", file, "--out", tmp_path / "out")
    assert said.exit_code == 0, said.output
    table = pd.read_csv(tmp_path / "out" / "measurements.csv").set_index("quantity")
    assert set(table.rig) == {rig} and np.isfinite(table.value[MAIN[rig]])
    notes = pd.read_csv(tmp_path / "out" / "notes.csv").note
    assert notes.str.startswith(f"taken for a {rig}: ").sum() == 1
    imported = ran("import", file, "--out", tmp_path / "bench")
    assert imported.exit_code == 0 and f"IMG_0042: {rig}" in imported.output
    text = (tmp_path / "bench" / "IMG_0042" / "recording.toml").read_text()
    assert tomllib.loads(text)["rig"] == rig and f'GUESS: rig = "{rig}"' in text


def test_where_nothing_tells_the_rig_one_command_that_goes_on_is_named(tmp_path):
    file = bare(tmp_path, "still", nothing_film)
    said = ran("measure", file, "--out", tmp_path / "out")
    assert said.exit_code == 1
    go_on = f"benchtwin import {file} --rig roll --out my-bench"
    (reason,) = pd.read_csv(tmp_path / "out" / "measurements.csv").reason
    assert go_on in reason
    words = go_on.split()[1:-1]
    assert ran(*words, tmp_path / "bench").exit_code == 0


def test_a_lone_sound_is_a_drop(tmp_path):
    drawn = draw(SCENES[4], np.random.default_rng(5))
    file = write(drawn, "", tmp_path, "memo")
    said = ran("measure", file, "--out", tmp_path / "out")
    assert said.exit_code == 0, said.output
    table = pd.read_csv(tmp_path / "out" / "measurements.csv").set_index("quantity")
    row = table.loc["restitution_normal"]
    assert set(table.rig) == {"drop"} and row.quality == "doubtful"
    assert "height_mm is missing" in row.reason  # only its later bounces are known
    imported = ran("import", file, "--out", tmp_path / "bench")
    assert "memo: drop" in imported.output


def test_paths_that_no_rig_makes_are_none():
    """A walk, a circle and a straight even motion are no drop and no roll."""
    t = np.linspace(0, 1, 100)
    walk = np.random.default_rng(1).standard_normal((2, 100)).cumsum(axis=1)
    assert rig_of_motion(t, *walk) is None
    assert rig_of_motion(t, 50 * np.cos(6 * t), 50 * np.sin(6 * t)) is None
    assert rig_of_motion(t, 300 * t, 0 * t) is None
    down = np.minimum(t, 0.4) * np.tan(np.radians(15))
    assert rig_of_motion(t, 300 * t, -300 * down) is None  # it does not slow
