"""Unlisted physics in words and in the twin: a law of speed that is on nobody's list is
found, and the twin that is run with it is nearer to what was recorded."""

from dataclasses import replace
from pathlib import Path

import falling
import numpy as np
import pytest
import rolling
import sliding
from benchtwin.diagnose.bench import Diagnosis
from benchtwin.diagnose.rerun import resimulate_all
from benchtwin.diagnose.words import lines
from benchtwin.rigs.drop.diagnose import diagnose_drop
from benchtwin.rigs.roll.diagnose import diagnose_roll
from benchtwin.rigs.slide.diagnose import diagnose_slide

DIAGNOSE = {"drop": diagnose_drop, "roll": diagnose_roll, "slide": diagnose_slide}


def diagnosed(rig: str, seen: list):
    return DIAGNOSE[rig](seen, np.random.default_rng(0))


def run_again(finding, seen: list, folder: Path) -> Diagnosis:
    one = Diagnosis(Path(), {finding.rig: finding}, {finding.rig: seen}, {}, ())
    return resimulate_all(one, folder, pictures=False, say=lambda text: None)


def errors(diagnosis: Diagnosis) -> tuple[float, float]:
    """Of the twin without and with the law."""
    (twin,) = diagnosis.twins.values()
    return twin.total()[:2]


def steep_slides(size: float) -> list:
    """Friction that grows as the cube of speed, by `size` at 0.3 m/s."""
    bench = replace(
        sliding.AIRLESS, friction=lambda v, x: size * (v / 0.3) ** 3, rates=(1.0, 5.0)
    )
    return sliding.slides(bench, 4, np.random.default_rng(1))


def steep_rolls() -> list:
    """Resistance as the cube of speed, 0.01 of the weight at 0.5 m/s."""
    bench = rolling.Bench(steep=(0.01, 0.5, 3.0))
    rng = np.random.default_rng(1)
    return rolling.rolls(bench, 6, rng, lengths=(30.0, 60.0))


def braked_drops() -> list:
    """A force as the fourth power of speed, 0.05 of the weight at 2 m/s."""
    bench = falling.Bench(fps=500.0, braked=(0.05, 2.0, 4.0), stated_away_mm=2000.0)
    return falling.tracks(bench, 4, np.random.default_rng(1))


def test_slides_with_a_concealed_power_of_speed(tmp_path):
    seen = steep_slides(0.02)
    found = diagnosed("slide", seen)
    assert found.verdict == "unknown" and found.names == ()
    assert "a friction that grows with speed to the power" in found.law
    size, law = found.effects["law"].size, found.laws["law"]
    at = float(law.meaning.split()[-2])  # "… at 0.3 m/s"
    assert size.low95 < 0.02 * (at / 0.3) ** 3 < size.high95
    again = run_again(found, seen, tmp_path)
    before, after = errors(again)
    assert after < 0.4 * before
    assert "  run again with this law, the twin is off by" in lines(again)[1]
    assert again.to_json()["rigs"]["slide"]["twin"]["effects"] == ["law"]
    # as a control, as much of the opposite
    wrong = {"law": tuple(-v for v in found.left_out["law"])}
    before, after = errors(run_again(replace(found, left_out=wrong), seen, tmp_path))
    assert after > 1.3 * before


def test_slides_with_nothing_concealed_have_no_law(tmp_path):
    seen = steep_slides(0.0)
    found = diagnosed("slide", seen)
    assert found.verdict == "none" and not found.laws and not found.law
    assert not run_again(found, seen, tmp_path).twins


def test_a_law_of_place_is_said_and_why_the_twin_was_not_run(tmp_path):
    bench = replace(sliding.LIGHT, friction=lambda v, x: 0.1 * x)
    seen = sliding.slides(bench, 4, np.random.default_rng(1))
    found = diagnosed("slide", seen)
    assert found.verdict == "unknown" and "the way slid" in found.law
    (twin,) = run_again(found, seen, tmp_path).twins.values()
    assert not twin.compared and twin.in_words() == (
        "the twin was not run again: law: the twin knows no friction that goes with the"
        " way slid"
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rig", "drawn", "words"),
    [
        ("roll", steep_rolls, "a force against the motion as speed to the power"),
        ("drop", braked_drops, "against the motion that goes as speed to the power"),
    ],
)
def test_rolls_and_flights_with_a_concealed_power_of_speed(rig, drawn, words, tmp_path):
    seen = drawn()
    found = diagnosed(rig, seen)
    assert found.verdict == "unknown" and found.names == () and words in found.law
    before, after = errors(run_again(found, seen, tmp_path))
    assert after < 0.6 * before


@pytest.mark.slow
def test_impacts_with_a_concealed_law_of_restitution(tmp_path):
    bench = falling.Bench(fps=500.0, e=lambda speed, count: 0.4 + 0.12 * speed)
    heights = [0.310, 0.100, 0.030]
    seen = falling.tracks(bench, 9, np.random.default_rng(2), heights=heights)
    found = diagnosed("drop", seen)
    assert found.verdict == "unknown"
    assert found.law.startswith("the restitution rises with speed of impact")
    before, after = errors(run_again(found, seen, tmp_path))
    assert after < 0.7 * before
