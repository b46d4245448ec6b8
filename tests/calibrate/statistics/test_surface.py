"""Response surfaces against the paper's Eq. 8 and its intervals checked by
simulation."""

import numpy as np
import pytest
from scipy import stats

from benchtwin.calibrate.procedure.published import compare
from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.designs import box_behnken
from benchtwin.calibrate.statistics.surface import (
    coefficients,
    fit_surface,
    quality,
    residual_table,
    response_grid,
)

EQ8 = [30.04, 0.5875, 0.8375, 0.775, 0.075, 0.1, 0.35, -0.0325, -0.2825, -0.2575]
NAMES = ["intercept", "A", "B", "C", "AB", "AC", "BC", "A²", "B²", "C²"]


def test_equation_8_comes_out_of_table_9(surface):
    table = coefficients(surface)
    assert table["term"].tolist() == NAMES
    np.testing.assert_allclose(table["coefficient"], EQ8, atol=1e-9)
    printed = [
        "30.04",
        "0.59",
        "0.84",
        "0.78",
        "0.075",
        "0.1",
        "0.35",
        "-0.033",
        "-0.28",
        "-0.26",
    ]
    found = compare(dict(zip(NAMES, printed)), dict(zip(NAMES, table["coefficient"])))
    assert found["follows"].all()


def test_natural_units_give_the_same_surface(surface):
    natural = coefficients(surface)["natural"].to_numpy()
    coded = np.array([[0.3, -0.7, 0.9], [1.0, 1.0, -1.0]])
    there = polynomial.matrix(surface.box.natural(coded), surface.terms) @ natural
    np.testing.assert_allclose(there, surface.mean(coded), atol=1e-8)


def test_quality_is_as_it_is_defined(surface):
    q = quality(surface).set_index("measure")["value"]
    t = residual_table(surface)
    total = np.sum((t["actual"] - t["actual"].mean()) ** 2)
    press = np.sum((t["residual"] / (1 - t["leverage"])) ** 2)
    assert q["R²"] == pytest.approx(1 - np.sum(t["residual"] ** 2) / total)
    assert q["predicted R²"] == pytest.approx(1 - press / total)
    # mean variance of a prediction at the runs is p s²/n
    se = np.sqrt(surface.variance(surface.points).mean())
    assert q["adequate precision"] == pytest.approx(np.ptp(t["predicted"]) / se)
    assert t["leverage"].sum() == pytest.approx(10)
    assert q["p of a normal scatter"] > 0.05


def test_a_spoilt_run_is_named_an_outlier(runs, box, natural):
    spoilt = runs.copy()
    spoilt.loc[0, "repose_angle_deg"] += 6
    table = residual_table(fit_surface(natural(spoilt), "repose_angle_deg", box))
    assert list(table.loc[table["outlier"], "run"]) == [1]
    assert not residual_table(fit_surface(natural(runs), "repose_angle_deg", box))[
        "outlier"
    ].any()


def test_a_response_grid_is_the_surface(surface):
    pair = ("static_friction", "rolling_friction")
    grid = response_grid(surface, *pair, steps=5, at={"restitution": 0.65})
    assert len(grid) == 25
    top = (grid["static_friction"] == 0.6) & (grid["rolling_friction"] == 0.05)
    assert grid[top]["predicted"].iloc[0] == pytest.approx(surface.mean([[1, 1, 1]])[0])


def test_intervals_cover_at_their_stated_rate(box):
    """95 % intervals of the mean; the control takes the wrong quantile (normal for t on
    7 df) and falls short."""
    rng = np.random.default_rng(0)
    design = box_behnken(box, centre_points=5)
    z = box.coded(box.points(design))
    x, at = polynomial.matrix(z, polynomial.full(3)), [[0.5, -0.5, 0.2]]
    truth = polynomial.matrix(at, polynomial.full(3)) @ EQ8
    off = []
    for _ in range(800):
        y = x @ EQ8 + 0.25 * rng.standard_normal(len(z))
        found = fit_surface(design.assign(y_deg=y), "y_deg", box)
        off.append((found.mean(at) - truth) / np.sqrt(found.variance(at)))
    # of 800: sd of the rate 0.8 %
    assert 0.925 < np.mean(abs(np.array(off)) < stats.t.ppf(0.975, 7)) < 0.975
    assert np.mean(abs(np.array(off)) < 1.96) < 0.93


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda t: t.assign(repose_angle_deg=30.0),
            "repose_angle_deg: all 17 values equal",
        ),
        (lambda t: t.assign(A=0.0), "singular design: .* A"),
        (lambda t: t.head(10), "10 terms need at least 11 runs"),
    ],
)
def test_bad_tables_are_named(runs, box, natural, change, message):
    with pytest.raises(ValueError, match=message):
        fit_surface(natural(change(runs)), "repose_angle_deg", box)


@pytest.mark.parametrize(
    ("ranges", "message"),
    [
        ({"e": (0.6, 0.6)}, "e: low must be below high"),
        ({"e": (0.5, np.inf)}, "e: limits must be finite"),
        ({}, "at least one factor"),
    ],
)
def test_bad_boxes_are_named(ranges, message):
    with pytest.raises(ValueError, match=message):
        Box.of(ranges)
