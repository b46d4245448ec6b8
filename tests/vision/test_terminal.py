"""What a batch prints: a long one its answers and what needs a look, a short one every
row."""

from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from benchtwin.vision.measurement import DOUBTFUL, FAILED, GOOD
from benchtwin.vision.summary import Line
from benchtwin.vision.terminal import MOST_ROWS, show_results

LINE = Line(
    "bench",
    "drop",
    "restitution",
    "",
    8,
    0.5,
    0.49,
    0.51,
    "1",
    0.013,
    0.001,
    0.0,
    0,
    0,
    (),
)


def table(rows: int) -> pd.DataFrame:
    found = [
        (f"drop-{k:02d}", "rebound_speed", 1.2, 0.01, "m/s", GOOD, "")
        for k in range(rows)
    ]
    found += [("odd", "restitution", 0.6, 0.01, "1", DOUBTFUL, "it was cut")]
    found += [("none", "restitution", float("nan"), 0.1, "1", FAILED, "black")]
    return pd.DataFrame(
        found,
        columns=["recording", "quantity", "value", "sd", "unit", "quality", "reason"],
    )


@pytest.fixture
def printed(capsys):
    def of(rows, means, notes=(), not_read=()):
        show_results(table(rows), means, notes, not_read, Path("results"))
        return capsys.readouterr().out

    return of


def test_a_long_batch_prints_its_answer_first_and_then_only_what_needs_a_look(printed):
    means = [replace(LINE, quantity="rebound_speed", unit="m/s"), LINE]
    out = printed(MOST_ROWS, means)
    assert (
        out.index("0.5000 (0.4900 to 0.5100)")
        < out.index("it was cut")
        < out.index("black")
        < out.index(f"{MOST_ROWS} good, 1 doubtful, 1 failed")
    )
    assert (
        "rebound_speed" not in out
        and "drop-00" not in out
        and len(out.splitlines()) < 15
    )


def test_a_short_batch_prints_every_row_and_every_mean(printed):
    out = printed(3, [replace(LINE, quantity="rebound_speed", unit="m/s"), LINE])
    assert (
        all(f"drop-0{k}" in out for k in range(3))
        and "drop rebound_speed" in out
        and "drop restitution" in out
    )


def test_where_the_answer_itself_was_not_measured_the_next_quantity_stands_for_it(
    printed,
):
    out = printed(
        MOST_ROWS,
        [
            replace(LINE, quantity="rebound_height", unit="mm"),
            replace(LINE, quantity="impact_speed", unit="m/s"),
        ],
    )
    assert "rebound_height" in out and "impact_speed" not in out


def test_files_that_were_not_read_are_named_however_many_notes_there_are(printed):
    notes = [("drop", f"note {k}") for k in range(20)]
    out = printed(
        MOST_ROWS,
        [LINE],
        [*notes, ("bench", "not read: x.doc")],
        [("bench", "not read: x.doc")],
    )
    assert "x.doc" in out and "note 3" not in out
    assert "note 3" in printed(MOST_ROWS, [LINE], notes[:5])
