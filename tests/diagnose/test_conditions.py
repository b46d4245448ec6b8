"""Parameters that follow what the recordings state, from folders of readings alone; a
control that must fail."""

import numpy as np
import pandas as pd
import pytest
import tomli_w

from benchtwin.diagnose.bench import diagnose_bench
from benchtwin.diagnose.words import lines

PLATES = {"steel": 0.36, "glass": 0.33, "rubber": 0.42}


def bench(folder, friction, conditions):
    """A recording of five readings for each of the conditions, at this friction."""
    rng = np.random.default_rng(3)
    for k, (mu, stated) in enumerate(zip(friction, conditions, strict=True)):
        at = folder / f"slide-{k:02d}"
        at.mkdir(parents=True)
        told = {
            "rig": "slide",
            "seed": {"length_mm": 7.5},
            "slide": {"tilt_rate_deg_s": 2.0},
            "conditions": stated,
        }
        (at / "recording.toml").write_text(tomli_w.dumps(told))
        angles = np.degrees(np.arctan(mu + 0.003 * rng.standard_normal(5)))
        pd.DataFrame({"slide_angle_deg": np.round(2 * angles) / 2}).to_csv(
            at / "readings.csv", index=False
        )
    return folder


def test_each_level_of_a_condition_in_words_has_its_value(tmp_path):
    plates = list(PLATES) * 2
    diagnosis = diagnose_bench(
        bench(tmp_path, [PLATES[p] for p in plates], [{"plate": p} for p in plates])
    )
    found = diagnosis.findings["slide"]
    assert found.verdict == "name" and found.names == ("static_friction-follows-plate",)
    follow = found.follows[0]
    mean = np.mean(list(PLATES.values()))
    assert follow.levels == tuple(PLATES) and follow.shape == "levels"
    for plate, point in zip(follow.levels, follow.curve, strict=True):
        size = point.size
        assert size.value == pytest.approx(
            PLATES[plate] - mean, abs=0.006
        )  # half a degree is 0.010 of friction; ten readings
        assert size.low95 < size.value < size.high95
    glass = found.to_json()["follows"][0]["curve"][1]
    assert glass["at"] == "glass" and glass["value"] < 0
    assert any("beside the mean of all: steel" in line for line in lines(diagnosis))


def test_a_condition_that_nothing_follows_is_not_named(tmp_path):
    found = diagnose_bench(
        bench(tmp_path, [0.36] * 6, [{"plate": p} for p in list(PLATES) * 2])
    ).findings["slide"]
    assert found.verdict == "none" and not found.names


def test_conditions_that_cannot_be_told_apart_or_used_are_said(tmp_path):
    stated = [
        {"plate": p, "moisture_pct": 10.0 + k, "room": "A"}
        for k, p in enumerate(list(PLATES) * 2)
    ]
    del stated[2]["moisture_pct"]
    notes = " ".join(
        diagnose_bench(bench(tmp_path, [0.36] * 6, stated)).findings["slide"].notes
    )
    assert "room is the same in all" in notes
    assert "moisture_pct is not stated in 1 of 6" in notes
    assert "moisture_pct goes with the order" in notes
