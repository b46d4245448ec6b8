"""report.html: opens with the answer, carries every figure and nothing from a network,
survives any name."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from pages import Tags, own

from benchtwin.bench.numbers import with_interval
from benchtwin.calibrate.procedure import calibrate_tables, parameters
from benchtwin.report.numbers import sentence
from benchtwin.report.page import render

PAPER = Path(__file__).parents[2] / "samples" / "soybean-paper"


@pytest.fixture(scope="module")
def paper():
    return calibrate_tables(PAPER)


@pytest.fixture(scope="module")
def page(paper):
    return render(paper)


def test_every_element_is_closed_and_nothing_is_loaded(page):
    tags = Tags()
    tags.feed(own(page))
    assert tags.open == [] and tags.loads == [] and len(tags.ids) == len(set(tags.ids))
    assert len(page.encode()) < 15e6


def test_the_answer_stands_first(page):
    text = re.sub(r"<[^>]+>", " ", own(page).split("</style>")[1])
    told = re.search(r"0\.5[34]\d* \(0\.(4[89]|50)\d* to", text)
    assert told
    first = told.start()
    assert first < 1200 and first < text.index("not resolved") < text.index(
        "Analysis of variance"
    ) < text.index("SHA-256")


def test_every_figure_has_its_place_and_finite_numbers(page):
    drawn = json.loads(
        re.search(r"const drawn = (\{.*?\});\nfor", page, re.DOTALL)[1].replace(
            "<\\/", "</"
        )
    )
    assert {
        "steel-drop",
        "steel-slide",
        "steel-roll",
        "path",
        "residuals",
        "posterior",
    } <= set(drawn)
    assert sum(k.startswith("contour-") for k in drawn) == 3
    places = set(re.findall(r'id="fig-([\w-]+)"', page))
    assert set(drawn) == places
    lines = [t.get("name", "") for t in drawn["steel-drop"]["data"]]
    assert any("bench mean 95 mm" in n for n in lines)


def test_an_interval_stands_once_and_the_convention_is_named(page, paper):
    """Of each parameter one 95 % interval; rolling friction with its model."""
    text = re.sub(r"<[^>]+>", " ", own(page).split("</style>")[1])
    body = text[: text.index("SHA-256")]
    for r in parameters(paper).itertuples():
        assert body.count(with_interval(r.value, r.low, r.high)) == 1, r
    assert "median" in body and not re.search(r"\blow\b.*\bhigh\b.*ess", body)
    assert "own centroid-to-contact distance" in body and "EDEM standard" in body


def test_what_does_not_follow_stands_beside_what_was_printed(page):
    part = page[page.index('id="printed"') :]
    row = part[part.index("pile: Table 10: Residual df") :][:200]
    assert re.findall(r">([\d.]+)</td>", row)[:2] == ["1", "7"]


def test_names_from_outside_are_text_only(paper):
    name = "<script>alert(1)</script>"
    page = render(
        replace(
            paper, title=name, refused={"pile": name}, findings=(f"finding {name}",)
        )
    )
    assert name not in page and "&lt;script&gt;alert(1)" in page


def test_a_calibration_without_a_pile_is_a_page_too(paper):
    page = render(
        replace(
            paper,
            surface=None,
            seeds={},
            joint=None,
            refused={"pile": "no pile recording"},
            finished=False,
        )
    )
    assert (
        "no pile recording" in page
        and "were still running" in page
        and "Where they were stopped, the same command goes on" in page
        and 'id="pile"' not in page
    )


def test_names_of_columns_are_written_in_words():
    assert (
        sentence("seed_restitution 0.6, run_out_mm 3")
        == "Restitution seed–seed 0.6, run-out 3."
    )
