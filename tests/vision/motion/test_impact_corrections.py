"""Impacts added and struck out by hand: in drawn sound whose impacts are known, and on
the command line.

The sound is drawn by benchmarks/drawn_sound.py, which shares nothing with the reader.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from drawn_sound import SCENES, draw, write
from typer.testing import CliRunner

from benchtwin.command_line import app
from benchtwin.measure.observe import observe
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.drop_sound import impacts_in_sound
from benchtwin.vision.recording import read_recording

LOUD = replace(next(s for s in SCENES if s.name == "pink"), db=(30, 32), e=(0.6, 0.65))


@pytest.fixture
def heard(tmp_path):
    return recorded(LOUD, tmp_path)


def recorded(scene, tmp_path):
    """(a function that reads the drawn drop with these lines under [drop], what was
    drawn)."""
    drawn = draw(scene, np.random.default_rng(21))
    folder = tmp_path / "drop"
    folder.mkdir()
    write(drawn, "", folder, "sound")

    def with_keys(lines: str = ""):
        text = (
            'rig = "drop"\n[drop]\nheight_mm ='
            f" {drawn.height_mm}\n{lines}\n[air]\ndensity_kg_m3 = 0.0\n"
        )
        (folder / "recording.toml").write_text(text)
        return read_recording(folder)

    return with_keys, drawn


def times_of(recording) -> np.ndarray:
    (drop,) = impacts_in_sound(recording.files[0], recording).drops
    return drop.times


def test_an_impact_struck_out_is_in_no_interval(heard):
    with_keys, drawn = heard
    recording = with_keys(f"impacts_struck_s = [{drawn.times[2] + 1e-3:.4f}]")
    np.testing.assert_allclose(
        times_of(recording)[:3], drawn.times[[0, 1, 3]], atol=3e-4
    )
    found = observe(recording)
    assert "impacts set by hand: 0 added, 1 struck out" in found.notes
    assert any(
        note.startswith("no impact: the sound at") and "struck out by hand" in note
        for note in found.notes
    )
    assert found.bounces.t_s.diff()[2] == pytest.approx(
        drawn.times[3] - drawn.times[1], abs=3e-4
    )


def test_an_impact_added_is_placed_at_its_onset(tmp_path):
    """Pointed at 2 ms beside an impact too faint to be found: to 1 ms, which is what
    there is to be had at 0 dB."""
    with_keys, drawn = recorded(replace(LOUD, db=(12, 13)), tmp_path)
    automatic = times_of(with_keys())
    missed = next(t for t in drawn.times if np.abs(automatic - t).min() > 5e-3)
    times = times_of(with_keys(f"impacts_added_s = [{missed - 2e-3:.4f}]"))
    assert len(times) == len(automatic) + 1
    assert np.abs(times - missed).min() < 1e-3


def test_a_moment_where_no_sound_is_listed_is_placed_where_the_power_jumps(tmp_path):
    """A click 6 dB over white noise, too faint for a list of three a second: within
    three stated sds and 1 ms."""
    from benchtwin.vision.evidence.sound import Sound
    from benchtwin.vision.motion.onsets import onset_near

    rng, rate = np.random.default_rng(3), 48_000
    off = []
    for _ in range(30):
        samples = rng.standard_normal(rate).astype(np.float32) * 0.01
        at = rng.integers(20_000, 28_000)
        t = np.arange(400) / rate
        samples[at : at + 400] += (
            0.04 * np.exp(-t / 3e-3) * np.sin(2 * np.pi * 4000 * t)
        ).astype(np.float32)
        time, sd = onset_near(
            Sound(tmp_path, samples, rate, 0.25, False),
            at / rate + 0.25 + rng.uniform(-3e-3, 3e-3),
        )
        off.append(((time - 0.25 - at / rate), sd))
    error, sd = np.array(off).T
    assert np.sqrt(np.mean(error**2)) < 1e-3
    assert np.mean(np.abs(error) < 3 * sd) > 0.9


def test_wrong_moments_are_told_with_file_and_key(heard):
    with_keys, drawn = heard
    with pytest.raises(
        MeasurementError,
        match=r"recording.toml: \[drop\] impacts_added_s: 99 s is not in this sound",
    ):
        observe(with_keys("impacts_added_s = [99.0]"))
    at = f"{drawn.times[1]:.4f}"
    with pytest.raises(MeasurementError, match="both name the impact"):
        observe(with_keys(f"impacts_added_s = [{at}]\nimpacts_struck_s = [{at}]"))
    every = ", ".join(f"{t:.4f}" for t in drawn.times)
    with pytest.raises(MeasurementError, match="struck out"):
        observe(with_keys(f"impacts_struck_s = [{every}]"))
    assert (
        "0.05 s is struck out by hand, but no impact was found there"
        in observe(with_keys("impacts_struck_s = [0.05]")).notes
    )


def test_the_command_line_obeys(heard, tmp_path):
    with_keys, drawn = heard
    with_keys(f"impacts_struck_s = [{drawn.times[2]:.4f}]")
    out = tmp_path / "out"
    assert (
        CliRunner()
        .invoke(app, ["measure", str(tmp_path / "drop"), "--out", str(out), "--quiet"])
        .exit_code
        == 0
    )
    bounces = pd.read_csv(out / "bounces.csv")
    assert bounces.t_s[2] == pytest.approx(drawn.times[3], abs=3e-4)
    assert "impacts set by hand" in (out / "notes.csv").read_text()
