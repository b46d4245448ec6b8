"""Does shape matter: differences between kinds of seeds, and what they mean for a
parameter."""

import numpy as np
import pandas as pd
import pytest

from benchtwin.calibrate.procedure import shape_effect as module
from benchtwin.calibrate.procedure.shape_effect import Question, shape_effect, verdict

DROP = Question(
    rig="drop",
    response="rebound_height_mm",
    unit="mm",
    parameter="restitution",
    description={"seed": {"lot": "a"}},
    values={"restitution": 0.5},
    runs=40,
    slope=300.0,
)
PILE = Question(
    rig="pile",
    response="repose_angle_deg",
    unit="deg",
    description={"seed": {"lot": "a"}},
    values={"restitution": 0.5},
    runs=40,
)


@pytest.fixture
def kinds(monkeypatch):
    """Two other kinds of seeds, without a lot to read."""
    monkeypatch.setattr(
        module,
        "other_seeds",
        lambda section: {
            "typical seed": {"lot_seed": "a:1"},
            "ellipsoids": {"length_mm": 8.0},
        },
    )


def simulator(effect_mm: float, sd: float = 2.0, missing: int = 0):
    """Ellipsoids differ by effect_mm; `missing` runs of each kind give nothing."""

    def simulate(runs):
        rows = []
        for run in runs:
            value = 80.0 + effect_mm * ("length_mm" in run.description["seed"])
            value += sd * np.random.default_rng(run.rng).standard_normal()
            rows.append({"rebound_height_mm": value, "repose_angle_deg": value})
        table = pd.DataFrame(rows)
        for k in range(missing):
            table.loc[k::40, :] = np.nan
        return table

    return simulate


def test_a_shift_of_the_reading_becomes_one_of_the_parameter(kinds):
    table = shape_effect([DROP], simulator(9.0), seed=3).set_index("seeds")
    other = table.loc["ellipsoids"]
    assert other.difference == pytest.approx(9.0, abs=3 * other.difference_sd)
    assert other.difference_sd == pytest.approx(2.0 * np.sqrt(2 / 40), rel=0.4)
    assert other.parameter_shift == pytest.approx(-other.difference / 300.0)
    said = verdict(table.reset_index())
    assert len(said) == 2 and "restitution would have come out" in said[1]
    assert (
        "is the same within" in said[0]
    )  # the control: the typical seed differs by nothing


def test_a_pile_has_an_angle_and_no_single_parameter(kinds):
    table = shape_effect([PILE], simulator(-6.0), seed=1)
    assert "parameter_shift" not in table
    assert any(
        "pile: with ellipsoids of the lot's sizes the repose angle differs by -" in line
        for line in verdict(table)
    )


def test_runs_that_gave_nothing_are_left_out(kinds):
    table = shape_effect([DROP], simulator(9.0, missing=39), seed=1)
    assert list(table["runs"]) == [1, 1, 1]
    assert "difference" not in table or table["difference"].isna().all()
    assert verdict(table) == []
