"""The table, and the time left."""

import math

import pytest

from benchtwin.twin.campaign.progress import Progress, Tally
from benchtwin.twin.campaign.results import Measurement, Outcome, in_order

GOOD = Measurement("slide_angle", 18.5, 0.2, "deg")
RATIO = Measurement("restitution", 0.5, 0.01, "1", "doubtful", "short")


@pytest.fixture
def results():
    done = Outcome("a", "done", (GOOD, RATIO), {"slide_angle_deg": 18.4}, seconds=2.0)
    failed = Outcome("b", "failed", reason="Stopped: too fast", rerun="python -m …")
    return in_order(["b", "a", "c", "a"], {"a": done, "b": failed})


def test_rows_stand_in_the_order_of_the_jobs(results):
    table = results.table
    assert list(table.key) == ["b", "a", "c", "a"]
    assert list(table.status) == ["failed", "done", "missing", "done"]
    assert results.counts() == {"done": 2, "unmeasured": 0, "failed": 1, "missing": 1}


def test_columns_have_units(results):
    row = results.table.iloc[1]
    assert (
        row.slide_angle_deg,
        row.slide_angle_sd_deg,
        row.restitution,
        row.restitution_sd,
    ) == (18.5, 0.2, 0.5, 0.01)
    assert (row.true_slide_angle_deg, row.quality, row.seconds) == (
        18.4,
        "doubtful",
        2.0,
    )


def test_a_failure_says_why_and_how_to_run_it(results):
    row = results.table.iloc[0]
    assert (row.reason, row.rerun) == (
        "Stopped: too fast",
        "python -m …",
    ) and math.isnan(row.slide_angle_deg)
    assert [o.key for o in results.failed] == ["b"]


def test_no_jobs_make_an_empty_table():
    assert in_order([], {}).table.empty and list(in_order([], {}).table.columns)[
        :2
    ] == ["key", "status"]


def test_time_left_follows_jobs_of_the_same_kind(monkeypatch):
    now = [100.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    tally = Tally(
        {"p1": "pile", "p2": "pile", "d1": "drop", "d2": "drop", "d3": "drop"}
    )
    assert math.isnan(tally.progress(1, 0).left_s)
    tally.add(Outcome("p1", "done", seconds=60.0), found=True)
    tally.add(Outcome("d1", "done", seconds=1.0), found=False)
    assert tally.progress(1, 0).left_s == 62.0
    assert tally.progress(2, 0).left_s == 31.0
    now[0] += 10.0  # one of them has been running since
    assert tally.progress(1, 0).left_s == 52.0
    assert tally.progress(4, 1).running == 2


def test_progress_reads_as_a_sentence():
    p = Progress(33, 12, 3, 1, 2, 0, 200.0)
    assert (
        str(p) == "12 of 33 done, 1 failed, 2 running, about 3 min left"
        and p.left == 21
    )
    assert str(Progress(3, 3, 0, 0, 0, 0, 0.0)) == "3 of 3 done"
