"""results.xlsx holds what result.json and the tables hold."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchtwin.bench.numbers import with_interval
from benchtwin.bench.workbook import WORKBOOK, write_workbook
from benchtwin.calibrate.procedure import calibrate_tables, parameters
from benchtwin.report.spreadsheet import sheets

PAPER = Path(__file__).parents[2] / "samples" / "soybean-paper"


@pytest.fixture(scope="module")
def paper():
    return calibrate_tables(PAPER)


@pytest.fixture(scope="module")
def found(paper, tmp_path_factory):
    out = tmp_path_factory.mktemp("out")
    write_workbook(out / WORKBOOK, sheets(paper))
    return pd.read_excel(out / "results.xlsx", sheet_name=None, engine="openpyxl")


def test_five_sheets(found):
    assert list(found) == [
        *("parameters", "posterior", "correlations"),
        *("means over repeats", "units and methods"),
    ]


def test_parameters_are_those_of_the_result(paper, found):
    told, read = parameters(paper), found["parameters"]
    assert read["parameter"].tolist() == told["parameter"].tolist()
    numbers = ["value", "low", "high", "most_probable_set"]  # 16 digits are written
    assert np.allclose(read[numbers], told[numbers], rtol=1e-15, atol=0)
    assert read["status"].tolist() == told["status"].tolist()
    assert not {"low", "high", "median"} & set(found["posterior"])


def test_correlations_are_the_draws_own(paper, found):
    read = found["correlations"].set_index("parameter")
    draws = paper.joint.posterior.draws
    assert np.allclose(read, np.corrcoef(draws.to_numpy().T), rtol=0, atol=1e-12)
    assert list(read.index) == list(read.columns) == list(draws.columns)


def test_means_are_the_benchs(paper, found):
    read = found["means over repeats"].set_index("rig")
    assert read.loc["drop", ["reading", "unit", "n"]].tolist() == [
        *("rebound_height_mm", "mm", 10),
    ]
    assert read.loc["drop", "mean"] == 95.0  # of the printed readings
    assert set(read.index) == {"drop", "slide", "roll", "pile"}


def test_methods_say_convention_source_and_version(found, paper):
    told = found["units and methods"].set_index("what")["value or method"]
    paragraph = told["in words"]
    assert "EDEM" in paragraph and "95 ± 5.4 mm (n = 10)" in paragraph
    assert "printed simulations" in paragraph and "95%" in paragraph
    median = parameters(paper).set_index("parameter").loc["restitution"]
    told_of = with_interval(median["value"], median["low"], median["high"])
    assert told_of in paragraph and "not resolved" in paragraph
    assert "Ding et al." in told["seed: source"] and "version of benchtwin" in told


def test_a_bench_of_one_rig_has_its_sheets_too(paper):
    none = replace(paper, seeds={}, joint=None, steel={})
    assert [len(t) for t in sheets(none).values()][:4] == [0, 0, 0, 0]
