"""Drops and slides on a plate of seeds: what is read off, what a track tells, and what
they are never taken for."""

import re

import numpy as np
import pandas as pd
import pytest

from benchtwin.calibrate.procedure.bench import bench_of
from benchtwin.measure.observe import observe
from benchtwin.twin.seen import entries_of, listed
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import read_recording

G = 9806.65  # mm/s²
DROP = 'rig = "drop"\n[drop]\nheight_mm = 310\n'
SLIDE = 'rig = "slide"\n[slide]\n'
SEEDS = 'plate = "seeds"\ncoverage = 0.78\n'
CARD = "card_mm = [25, 25]\n"


def written(folder, toml: str, table: pd.DataFrame, name: str = "readings.csv"):
    folder.mkdir(parents=True)
    (folder / "recording.toml").write_text(toml)
    table.to_csv(folder / name, index=False)
    return read_recording(folder)


def by_name(recording) -> dict:
    return {q.name: q for q in observe(recording).quantities}


RISES = pd.DataFrame({"rebound_height_mm": [40.0, 60.0, 20.0, 55.0, 30.0]})
ANGLES = pd.DataFrame({"slide_angle_deg": [40.0, 47.5, 44.0, 38.5]})


def test_rises_read_off_give_no_restitution(tmp_path):
    found = by_name(written(tmp_path / "a", DROP + SEEDS, RISES))
    assert found["rebound_height"].value == 41.0
    assert found["apparent_restitution"].value == pytest.approx(np.sqrt(41 / 310))
    assert "restitution" not in found
    assert "restitution" in by_name(written(tmp_path / "b", DROP, RISES))


def test_angles_read_off_give_no_static_friction(tmp_path):
    found = by_name(written(tmp_path / "a", SLIDE + SEEDS + CARD, ANGLES))
    assert found["apparent_friction"].value == pytest.approx(np.tan(np.radians(42.5)))
    assert "static_friction" not in found and not found["slide_angle"].reason


@pytest.mark.parametrize(
    ("toml", "table", "missing"),
    [
        ('rig = "drop"\n[drop]\n', RISES, "[drop] height_mm"),
        (SLIDE, ANGLES, "[slide] card_mm"),
    ],
)
def test_what_a_calibration_would_have_to_guess_is_asked_for(
    tmp_path, toml, table, missing
):
    """The twin has a height and a card of its own: they are not taken for the
    bench's."""
    recording = written(tmp_path / "a", toml + SEEDS, table)
    with pytest.raises(MeasurementError, match=re.escape(f"{missing} is missing")):
        observe(recording)


def fall(deep: float = 310.0, rise: float = 60.0, seen: float = 1.8) -> pd.DataFrame:
    """Let go at 310 mm, `deep` above where it strikes; then off to the side, followed
    for `seen` times as long as it rises, 500 rows a second."""
    down, up = np.sqrt(2 * deep / G), np.sqrt(2 * rise / G)
    t = np.arange(0.0, down + seen * up, 0.002)
    after = np.clip(t - down, 0.0, None)
    y = np.where(
        t < down, 310 - G * t**2 / 2, 310 - deep + G * after * (up - after / 2)
    )
    noise = np.random.default_rng(1).normal(0.0, 0.1, (2, len(t)))
    return pd.DataFrame(
        {"t_s": t, "x_mm": 300 * after + noise[0], "y_mm": y + noise[1]}
    )


LOT = "[seed]\nlength_mm = 7.5\nwidth_mm = 7.1\nthickness_mm = 6.9\n"
SCALE = "[camera]\nmm_per_px = 0.25\n"


@pytest.mark.parametrize("rise", [15.0, 60.0])
def test_a_track_tells_how_far_it_rises(tmp_path, rise):
    toml = DROP + SEEDS + SCALE
    found = by_name(written(tmp_path / "a", toml, fall(rise=rise), "track.csv"))
    q = found["rebound_height"]
    assert q.value == pytest.approx(rise, abs=max(4 * q.sd, 0.3))
    assert set(found) == {"rebound_height", "apparent_restitution"}


@pytest.mark.parametrize("seen", [0.5, 0.8])
def test_a_seed_that_leaves_the_picture_still_rising(tmp_path, seen):
    """The mean of those that stay in it alone would be that of the low ones."""
    toml = DROP + SEEDS + SCALE
    left = by_name(written(tmp_path / "a", toml, fall(seen=seen), "track.csv"))
    whole = by_name(written(tmp_path / "b", toml, fall(), "track.csv"))
    q = left["rebound_height"]
    assert abs(q.value - 60) < 3 * q.sd
    assert q.sd > 1.5 * whole["rebound_height"].sd


def test_a_seed_of_which_nothing_is_seen_after_the_impact_has_no_rise(tmp_path):
    """It is not one that stays."""
    toml = DROP + SEEDS + SCALE
    recording = written(tmp_path / "a", toml, fall(seen=0.01), "track.csv")
    with pytest.raises(MeasurementError, match="next to nothing is seen"):
        observe(recording)


def test_a_seed_that_falls_through_a_gap_is_told_by_its_fall(tmp_path):
    """The board lies 6.9 mm below the tops, a hollow 1.3 mm; where the height is known
    to 5 mm only, nobody can tell."""
    known = DROP + "height_sd_mm = 1\n" + SEEDS + SCALE + LOT
    through = written(tmp_path / "a", known, fall(deep=316.5), "track.csv")
    with pytest.raises(MeasurementError, match="struck the board in a gap"):
        observe(through)
    hollow = written(tmp_path / "b", known, fall(deep=311.3), "track.csv")
    assert by_name(hollow)["rebound_height"].value == pytest.approx(60, abs=1)
    by_hand = DROP + SEEDS + SCALE + LOT
    unknown = written(tmp_path / "c", by_hand, fall(deep=316.5), "track.csv")
    assert by_name(unknown)["rebound_height"].value == pytest.approx(60, abs=1)


def test_a_card_of_two_seeds_is_one_sentence(tmp_path):
    """They cover 42 mm² each."""
    small = SLIDE + SEEDS + "card_mm = [14, 8]\n" + LOT
    recording = written(tmp_path / "a", small, ANGLES)
    with pytest.raises(MeasurementError, match="about 2 seeds have room"):
        observe(recording)
    three = SLIDE + SEEDS + "card_mm = [14, 12]\n" + LOT
    assert "slide_angle" in by_name(written(tmp_path / "b", three, ANGLES))


def test_impacts_that_were_heard_are_refused(tmp_path):
    heard = pd.DataFrame({"t_s": [0.0, 0.2, 0.35]})
    recording = written(tmp_path / "a", DROP + SEEDS, heard, "impacts.csv")
    with pytest.raises(MeasurementError, match="film it, or read the height"):
        observe(recording)


def slide_track(end_mm: float) -> pd.DataFrame:
    """A card that hops 3 mm at 20°, and slides off from 40° on, 100 mm a second."""
    t = np.arange(0.0, 22.0, 0.02)
    x = 3.0 * (t > 10) + np.clip(100 * (t - 20), 0.0, end_mm - 3.0)
    return pd.DataFrame({"t_s": t, "x_mm": x, "y_mm": 0.0, "tilt_deg": 2 * t})


def test_a_track_tells_the_angle_at_which_the_card_had_gone(tmp_path):
    """20 mm, 17 of them in 0.17 s, in which the plate turns by 0.34°."""
    toml = SLIDE + SEEDS + CARD + "[camera]\nmm_per_px = 0.25\n"
    found = by_name(written(tmp_path / "a", toml, slide_track(60.0), "track.csv"))
    assert found["slide_angle"].value == pytest.approx(40.34, abs=0.02)
    short = written(tmp_path / "b", toml, slide_track(10.0), "track.csv")
    with pytest.raises(MeasurementError, match="goes 10 mm, and counts as slid off"):
        observe(short)


def test_another_plate_is_one_sentence(tmp_path):
    with pytest.raises(MeasurementError, match="plate = 'maize': must be") as said:
        written(tmp_path / "a", DROP + 'plate = "maize"\n', RISES)
    assert "another kind do not tell seed on seed" in str(said.value)


def test_they_are_never_seed_on_steel(tmp_path):
    written(tmp_path / "both" / "steel", DROP, RISES)
    written(tmp_path / "both" / "seeds", DROP + SEEDS, 1.5 * RISES)
    rigs = bench_of(tmp_path / "both").rigs
    assert rigs["drop"].values.mean() == 41.0
    assert rigs["seed-drop"].values.mean() == 61.5
    written(tmp_path / "alone" / "seeds", SLIDE + SEEDS + CARD, ANGLES)
    assert set(bench_of(tmp_path / "alone").rigs) == {"seed-slide"}


def test_a_diagnosis_says_that_it_does_not_judge_them(tmp_path):
    written(tmp_path / "b" / "steel", DROP, RISES)
    written(tmp_path / "b" / "seeds", DROP + SEEDS, RISES)
    said = {entry.recording: entry.aside for entry in listed(tmp_path / "b")}
    assert said["steel"] == ""
    assert "does not judge plates of seeds yet" in said["seeds"]
    assert [e.id for e in entries_of(tmp_path / "b", "drop").entries] == ["steel"]
