"""The mean over repeats: its interval holds, errors in common are not averaged away,
outliers are named and never dropped."""

import numpy as np
import pandas as pd
import pytest

from benchtwin.vision.measurement import Observation, Quantity, failed
from benchtwin.vision.summary import Line, as_table, summarise


def drop(
    name: str, value: float, sd: float = 0.001, common: float = 0.0, **known
) -> Observation:
    quantity = Quantity("restitution", value, sd, "1", sd_common=common)
    return Observation(name, "drop", (quantity,), bench="soy", **known)


def only(observations: list[Observation]) -> Line:
    (line,) = summarise(observations)
    return line


def test_the_mean_its_interval_and_what_measuring_explains():
    line = only(
        [drop(str(i), value, sd=0.01) for i, value in enumerate((0.50, 0.52, 0.54))]
    )
    assert (line.n, line.mean, line.scatter, line.measuring) == pytest.approx(
        (3, 0.52, 0.02, 0.01)
    )
    assert line.high - line.mean == pytest.approx(
        4.302653 * 0.02 / np.sqrt(3)
    )  # Student's t of two degrees of freedom


@pytest.mark.parametrize(("sessions", "share"), [(1, 1.0), (4, 0.5)])
def test_an_error_in_common_is_averaged_over_sessions_only(sessions, share):
    repeats = [
        drop(str(i), 0.5, sd=0.01, common=0.01, session=str(i % sessions))
        for i in range(8)
    ]
    line = only(repeats)
    assert line.common == pytest.approx(0.01 * share)
    assert line.high - line.mean == pytest.approx(
        1.96 * 0.01 * share
    )  # equal readings: no scatter


def test_intervals_hold_with_errors_of_both_kinds():
    rng = np.random.default_rng(5)
    held = []
    for _ in range(1000):
        shared = rng.normal(0, 0.004)
        values = 0.5 + shared + rng.normal(0, 0.01, 6)
        line = only(
            [
                drop(
                    str(i),
                    v,
                    sd=float(np.hypot(0.003, 0.004)),
                    common=0.004,
                    session="a",
                )
                for i, v in enumerate(values)
            ]
        )
        held.append(line.low < 0.5 < line.high)
    assert (
        0.94 < np.mean(held) <= 0.99
    )  # 1,000 draws: sd .007; t and normal halves in quadrature are slightly wide
    alone = [only([drop("a", 0.5 + rng.normal(0, 0.01), sd=0.003)]) for _ in range(300)]
    assert (
        np.mean([line.low < 0.5 < line.high for line in alone]) < 0.7
    )  # the control: an sd that is too small fails


def test_an_outlier_is_named_and_stays_in_the_mean():
    values = [0.500, 0.503, 0.498, 0.501, 0.55]
    line = only([drop(f"drop-{i}", v) for i, v in enumerate(values)])
    assert line.outliers == ("drop-4",)
    assert line.mean == pytest.approx(np.mean(values))


def test_one_group_in_a_hundred_without_outliers_names_one():
    rng = np.random.default_rng(7)
    named = [
        bool(
            only(
                [drop(str(i), v) for i, v in enumerate(0.5 + rng.normal(0, 0.01, 6))]
            ).outliers
        )
        for _ in range(1000)
    ]
    assert np.mean(named) < 0.025  # 1 % is meant; sd of the count .003


def test_readings_of_two_materials_are_no_repeats_of_each_other():
    """One recording each, of ten readings: told apart by the word, and by the number
    as well."""
    counted = pd.DataFrame({"quantity": ["restitution"], "n": [10], "sd": [0.02]})
    for levels in ({"plate": "steel"}, {"plate": "glass"}), ({"t": 5.0}, {"t": 25.0}):
        read = [
            drop(str(i), 0.4 + 0.2 * i, conditions=level, readings=counted)
            for i, level in enumerate(levels)
        ]
        assert [line.mean for line in summarise(read)] == [0.4, pytest.approx(0.6)]


def test_conditions_part_the_repeats_where_there_are_repeats_at_their_levels():
    plates = [
        drop(str(i), 0.5, conditions={"plate": "AB"[i % 2], "moisture_pct": 10.0 + i})
        for i in range(6)
    ]
    assert [(line.conditions, line.n) for line in summarise(plates)] == [
        ("plate = A", 3),
        ("plate = B", 3),
    ]


def test_doubtful_and_failed_repeats_are_counted():
    doubtful = Observation(
        "c",
        "drop",
        (Quantity("restitution", 0.5, 0.01, "1").doubt("blurred"),),
        bench="soy",
    )
    lost = Observation(
        "d", "drop", (failed("restitution", "1", "no film"),), bench="soy"
    )
    line = only([drop("a", 0.5), drop("b", 0.5), doubtful, lost])
    assert (line.n, line.doubtful, line.not_measured) == (3, 1, 1)
    assert as_table([line])["n"].tolist() == [3]
    assert summarise([lost]) == []
