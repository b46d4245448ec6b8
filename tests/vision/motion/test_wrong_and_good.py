"""Numbers that were wrong and called good: falls, sounds, readings, films, summaries.
All are drawn or computed here."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from drawn_sound import SCENES, draw_session, write
from synthetic.film import Look, film, write_video
from synthetic.motion import draw_drop

from benchtwin.measure.observe import observe, observe_or_fail
from benchtwin.rigs.drop.keys import Drop
from benchtwin.vision.find_recordings import find_recordings
from benchtwin.vision.measurement import BELIEVED, Observation, Quantity
from benchtwin.vision.recording import Air, Camera, Recording, Seed, read_recording
from benchtwin.vision.summary import summarise

G = 9.80665
NO_AIR = "[air]\ndensity_kg_m3 = 0\n"
WHITE = {scene.name: scene for scene in SCENES}["white"]


def recorded(
    folder: Path, table: pd.DataFrame, name: str, more: str = ""
) -> Observation:
    folder.mkdir(parents=True)
    (folder / "recording.toml").write_text(f'rig = "drop"\n{more}')
    table.to_csv(folder / name, index=False)
    return observe(read_recording(folder))


def by_name(found: Observation) -> dict[str, Quantity]:
    return {q.name: q for q in found.quantities}


def gates(a: float) -> pd.DataFrame:
    """Times of a fall from rest at six places, to 10 µs and 0.05 mm."""
    fallen = np.array([0.12, 0.2, 0.33, 0.5, 0.7, 0.85])
    time = np.round(np.sqrt(2 * fallen / a), 5)
    return pd.DataFrame(
        {"y_mm": -1000 * fallen, "t_s": time, "sd_s": 1e-5, "sd_mm": 0.05}
    )


def fall(a: float, rows: int, sd_mm: float = 0.05) -> pd.DataFrame:
    time = np.linspace(0, 0.4, rows)
    high = 900 - 500 * a * time**2
    return pd.DataFrame({"t_s": time, "x_mm": 0.0, "y_mm": high, "sd_mm": sd_mm})


@pytest.mark.parametrize("a", [9.4, 9.81, 10.2])
def test_falls_past_gates_tell_their_own_acceleration(a, tmp_path):
    found = recorded(tmp_path / "a", gates(a), "gates.csv", NO_AIR)
    told = by_name(found)["fall_acceleration"]
    assert told.value == pytest.approx(a, rel=1e-3)
    assert told.quality == "good" and told.sd < 2e-3 * a


@pytest.mark.parametrize("rows", [6, 9, 12, 20])
@pytest.mark.parametrize("a", [9.4, 10.2])
def test_falls_of_few_rows_do_too(a, rows, tmp_path):
    found = recorded(tmp_path / "a", fall(a, rows), "track.csv", NO_AIR)
    told = by_name(found)["fall_acceleration"]
    assert told.value == pytest.approx(a, rel=0.01)
    assert told.sd == pytest.approx(0.01 * a, rel=0.3)  # of a scale that is not stated


def test_a_number_at_its_prior_is_not_measured():
    """An sd above two thirds of what was believed before says so, whoever makes it, and
    stays so through every change; one below does not."""
    vague = Quantity("friction", 0.3, 0.07, "1", believed_sd=0.1)
    assert vague.quality == "doubtful" and vague.reason == BELIEVED
    assert replace(vague, sd_common=0.01).reason == BELIEVED
    assert Quantity("friction", 0.3, 0.06, "1", believed_sd=0.1).quality == "good"
    assert Quantity("friction", 0.3, 0.07, "1").quality == "good"


def session(folder: Path, e: np.ndarray, height_mm: float, pauses: np.ndarray, more=""):
    """Drops of one seed in one sound without handling."""
    folder.mkdir()
    scene = replace(WHITE, db=(25, 35))
    rng = np.random.default_rng(len(more) + len(e))
    drawn = draw_session(scene, e, height_mm, rng, 0, pauses)
    write(drawn[0], "", folder, "sound")
    (folder / "recording.toml").write_text(f'rig = "drop"\n{NO_AIR}{more}')
    return by_name(observe(read_recording(folder)))


@pytest.mark.parametrize("more", ["", "[drop]\nheight_mm = 150\n"])
def test_evenly_spaced_first_impacts_are_no_bounces(more, tmp_path):
    """Drops 1.35 s apart, e 0.5: each bounces by itself, to 37.5 mm."""
    found = session(tmp_path / "s", np.full(6, 0.5), 150, np.full(6, 1.35), more)
    assert found["rebound_height"].value == pytest.approx(37.5, abs=0.1)
    assert found["restitution_normal"].value == pytest.approx(0.5, abs=0.02)
    assert (found["restitution"].quality == "good") == bool(more)


def test_uneven_pauses_make_no_bounces_either(tmp_path):
    rng = np.random.default_rng(5)
    e = rng.normal(0.5, 0.03, 6)
    found = session(tmp_path / "s", e, 150, rng.uniform(0.7, 1.6, 6))
    high = found["rebound_height"]
    assert abs(high.value - float(np.mean(e**2)) * 150) < 2 * high.sd < 10


def test_thuds_without_a_bounce_are_no_good_rebound(tmp_path):
    """Times of impacts 1.35 s apart: no interval shrinks."""
    times = pd.DataFrame({"t_s": 0.5 + 1.35 * np.arange(10)})
    found = by_name(recorded(tmp_path / "a", times, "impacts.csv"))
    assert not [q for q in found.values() if q.quality == "good"]


@pytest.mark.parametrize("g", [9.795, 9.82])
def test_heights_of_sounds_hold_with_the_gravity_of_the_place(g, tmp_path):
    """Where most people live; the times alone are exact to 1e-5."""
    e, fast = 0.6, math.sqrt(2 * g * 0.25)
    times = 0.3 + np.cumsum([0, *(2 * fast * e**k / g for k in range(1, 6))])
    table = pd.DataFrame({"t_s": times, "sd_s": 1e-6})
    more = f"[drop]\nheight_mm = 250\n{NO_AIR}"
    high = by_name(recorded(tmp_path / "a", table, "impacts.csv", more))
    off = high["rebound_height"].value - 1000 * e**2 * 0.25
    assert abs(off) < 1.96 * high["rebound_height"].sd < 0.2
    assert high["rebound_height"].sd_common > 0.9 * high["rebound_height"].sd


BOUNCES = [round(1200 * 0.8 ** (2 * k), -1) for k in range(1, 8)]


def test_heights_of_successive_bounces_are_no_repeats(tmp_path):
    table = pd.DataFrame({"rebound_height_mm": BOUNCES})
    more = "[drop]\nheight_mm = 1200\n"
    found = by_name(recorded(tmp_path / "a", table, "readings.csv", more))
    assert {q.quality for q in found.values()} == {"doubtful"}
    assert "column bounce" in found["restitution"].reason


@pytest.mark.parametrize("from_zero", [True, False])
def test_numbered_bounces_give_the_restitution_of_each(from_zero, tmp_path):
    high = ([1200.0] if from_zero else []) + BOUNCES
    first = 0 if from_zero else 1
    table = pd.DataFrame({"bounce": range(first, 8), "rebound_height_mm": high})
    more = "" if from_zero else "[drop]\nheight_mm = 1200\n"
    found = by_name(recorded(tmp_path / "a", table, "readings.csv", more))
    assert list(found) == ["restitution"]
    assert found["restitution"].value == pytest.approx(0.8, abs=0.01)
    assert found["restitution"].quality == "good"


def test_each_row_may_state_its_height(tmp_path):
    heights = np.repeat([100.0, 250.0, 400.0, 800.0], 2)
    rebounds = np.round(0.8 * heights - 8)
    table = pd.DataFrame({"height_mm": heights, "rebound_height_mm": rebounds})
    found = recorded(tmp_path / "a", table, "readings.csv")
    right = float(np.mean(np.sqrt(rebounds / heights)))
    assert by_name(found)["restitution"].value == pytest.approx(right, abs=1e-3)
    assert found.readings["height_mm"].tolist() == [100, 250, 400, 800]
    assert "rebound_height" not in by_name(found)


def test_only_like_is_averaged_with_like(tmp_path):
    """Rebounds from three stated heights are no repeats; their restitution may be."""
    for k, high in enumerate((100, 200, 400)):
        table = pd.DataFrame({"rebound_height_mm": [high / 4]})
        recorded(
            tmp_path / f"d{k}", table, "readings.csv", f"[drop]\nheight_mm = {high}\n"
        )
    entries = find_recordings(tmp_path)
    lines = summarise(observe_or_fail(entry, observe) for entry in entries)
    heights = [line for line in lines if line.quantity == "rebound_height"]
    assert [line.n for line in heights] == [1, 1, 1]
    assert heights[0].conditions == "height_mm = 100"
    (together,) = [line for line in lines if line.quantity == "restitution"]
    assert together.n == 3 and together.mean == pytest.approx(0.5)


def test_seeds_of_two_kinds_are_not_averaged():
    def one(kind: str, value: float) -> Observation:
        told = (Quantity("restitution", value, 0.01, "1"),)
        return Observation(f"{kind}{value}", "drop", told, stated={"kind": kind})

    lines = summarise([one("maize", 0.5), one("maize", 0.52), one("wheat", 0.3)])
    assert [(line.conditions, line.n) for line in lines] == [
        ("kind = maize", 2),
        ("kind = wheat", 1),
    ]


def filmed(folder: Path, name: str, frames, shown: float, times=None, **camera):
    recording = Recording(
        name,
        folder / name,
        "drop",
        "video",
        (),
        camera=Camera(mm_per_px=0.5, **camera),
        drop=Drop(height_mm=150),
        seed=Seed(length_mm=8.7, width_mm=6.8, thickness_mm=6.8, mass_g=0.25),
        air=Air(density_kg_m3=0),
    )
    return observe(write_video(recording, frames, fps=shown, times=times))


@pytest.fixture(scope="module")
def frames() -> list[np.ndarray]:
    """240 frames a second of a drop from 150 mm, e 0.55."""
    motion = draw_drop(height_mm=150, restitution=0.55, rest_s=0.05, max_bounces=3)
    return list(film(motion, Look(noise=1.0), np.random.default_rng(1), fps=240))


def test_gravity_tells_a_slow_motion(frames, tmp_path):
    found = filmed(tmp_path, "slow", frames, 30)
    told = by_name(found)
    assert told["restitution_normal"].value == pytest.approx(0.55, abs=0.003)
    assert told["impact_speed"].value == pytest.approx(
        math.sqrt(2 * G * 0.15), rel=0.01
    )
    assert any("240 frames per second" in note for note in found.notes)


def test_no_slow_motion_of_a_usual_kind_is_in_doubt(frames, tmp_path):
    """Shown 3.43 times slower: neither rate nor scale is believed, in any file; a ratio
    that air leaves alone is as it is."""
    found = filmed(tmp_path, "odd", frames, 70)
    (good,) = [q for q in found.quantities if q.quality == "good"]
    assert good.name == "restitution_normal"
    assert good.value == pytest.approx(0.55, abs=0.003)
    assert "good" not in {*found.bounces.quality}


def test_gaps_in_the_time_stamps_are_kept_beside_a_stated_rate(frames, tmp_path):
    kept = np.array([k for k in range(len(frames)) if k % 3 != 1])
    some = [frames[k] for k in kept]
    found = filmed(tmp_path, "gaps", some, 240, kept / 240, fps=240)
    told = by_name(found)["restitution_normal"]
    assert told.value == pytest.approx(0.55, abs=0.003)
    assert any("time stamps the film lacks" in note for note in found.notes)


def test_a_film_on_its_side_keeps_its_numbers_and_its_picture(frames, tmp_path):
    aside = [np.ascontiguousarray(np.rot90(frame)) for frame in frames]
    found = filmed(tmp_path, "aside", aside, 240, fps=240)
    told = by_name(found)["restitution_normal"]
    assert told.value == pytest.approx(0.55, abs=0.003)
    assert np.ptp(found.pictures["track"]) > 100


def bounces_heard(e: float, height_mm: float, count: int = 6) -> np.ndarray:
    """Times of impacts after a fall, without air."""
    fast = math.sqrt(2 * G * height_mm / 1000)
    hops = [2 * fast * e**k / G for k in range(1, count)]
    return 0.3 + np.concatenate([[0.0], np.cumsum(hops)])


@pytest.mark.parametrize("height", [400, 4000])
def test_a_first_impact_that_was_missed_leaves_nothing_good(height, tmp_path):
    """Or a height in another unit: the bounces behind tell that one of both is so."""
    times = bounces_heard(0.6, 400)[height == 400 :]
    more = f"{NO_AIR}[drop]\nheight_mm = {height}\n"
    found = recorded(tmp_path / "a", pd.DataFrame({"t_s": times}), "impacts.csv", more)
    assert not [q for q in found.quantities if q.quality == "good"]
    assert "the first impact is missing" in by_name(found)["rebound_height"].reason
    assert (found.bounces.quality == "doubtful").all()


def test_pauses_that_shorten_are_no_rebound_of_metres(tmp_path):
    times = pd.DataFrame({"t_s": [0.5, 1.85, 3.15, 4.4, 5.6]})
    found = by_name(recorded(tmp_path / "a", times, "impacts.csv", NO_AIR))
    assert not [q for q in found.values() if q.quality == "good"]


def test_a_bounce_whose_predecessor_was_not_read_has_no_restitution(tmp_path):
    """Bounces 1, 2 and 4 of e² = 1/2: the fourth fell from what nobody read."""
    table = pd.DataFrame({"bounce": [1, 2, 4], "rebound_height_mm": [200, 100, 25]})
    more = "[drop]\nheight_mm = 400\n"
    found = by_name(recorded(tmp_path / "a", table, "readings.csv", more))
    assert found["restitution"].value == pytest.approx(math.sqrt(0.5), abs=1e-3)


def test_few_rows_contradict_a_scale_too(tmp_path):
    """Lengths 5 % too large, which are known to 1 %."""
    motion = draw_drop(height_mm=400, restitution=0.6, rest_s=0.0)
    ends = [bounce["t_s"] for bounce in motion.truth["bounces"]]
    time = np.linspace(0, 0.97 * ends[1], 12)
    high = 1.05 * (motion.path(time)[1] - 3.4)
    table = pd.DataFrame({"t_s": time, "x_mm": 0.0, "y_mm": high, "sd_mm": 0.05})
    found = by_name(recorded(tmp_path / "a", table, "track.csv", NO_AIR))
    for name in ("rebound_height", "impact_speed", "rebound_speed"):
        assert "free fall gives" in found[name].reason
