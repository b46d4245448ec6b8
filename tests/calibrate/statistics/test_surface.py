"""Response surfaces against the paper's Eq. 8, statsmodels, and intervals checked by
simulation."""

import numpy as np
import pandas as pd
import pytest
import statsmodels.api as sm
from scipy import stats
from statsmodels.stats.outliers_influence import OLSInfluence

from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.assessment import (
    coefficients,
    natural_coefficients,
    quality,
    response_grid,
)
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.designs import box_behnken
from benchtwin.calibrate.statistics.published_values import compare
from benchtwin.calibrate.statistics.reduction import reduce
from benchtwin.calibrate.statistics.residuals import normality, residual_table
from benchtwin.calibrate.statistics.surface import fit_surface, leverage

EQ8 = [30.04, 0.5875, 0.8375, 0.775, 0.075, 0.1, 0.35, -0.0325, -0.2825, -0.2575]


@pytest.fixture
def reference(surface):
    return sm.OLS(
        surface.response, polynomial.matrix(surface.points, surface.terms)
    ).fit()


def test_equation_8_comes_out_of_table_9(surface):
    assert surface.term_names == [
        "intercept",
        "A",
        "B",
        "C",
        "AB",
        "AC",
        "BC",
        "A²",
        "B²",
        "C²",
    ]
    np.testing.assert_allclose(surface.coefficients, EQ8, atol=1e-9)


def test_natural_units_give_the_same_surface(surface):
    b = natural_coefficients(surface)
    x = surface.box.natural([0.3, -0.7, 0.9])
    letters = dict(zip("ABC", x))
    value = sum(
        c
        * np.prod([letters[ch] ** (2 if "²" in t else 1) for ch in t if ch in letters])
        for t, c in b.items()
    )
    assert value == pytest.approx(surface.mean([0.3, -0.7, 0.9])[0], abs=1e-9)
    assert len(b) == 10


def test_natural_units_of_a_reduced_model_bring_back_the_lower_terms(surface):
    only_bc = fit_surface(
        _natural(surface), "repose_angle_deg", surface.box, terms=((0, 0, 0), (0, 1, 1))
    )
    assert list(natural_coefficients(only_bc).index) == ["intercept", "B", "C", "BC"]


def _natural(surface):
    return pd.DataFrame(
        surface.box.natural(surface.points), columns=surface.names
    ).assign(repose_angle_deg=surface.response)


def test_fit_agrees_with_statsmodels(surface, reference):
    table = coefficients(surface)
    np.testing.assert_allclose(table["coefficient"], reference.params, rtol=1e-9)
    np.testing.assert_allclose(table["se"], reference.bse, rtol=1e-9)
    np.testing.assert_allclose(table["p"], reference.pvalues, rtol=1e-7)
    np.testing.assert_allclose(table[["low", "high"]], reference.conf_int(), rtol=1e-8)


def test_quality_agrees_with_statsmodels(surface, reference):
    q = quality(surface)
    press = np.sum(OLSInfluence(reference).resid_press ** 2)
    assert [q.r2, q.r2_adjusted, q.press] == pytest.approx(
        [reference.rsquared, reference.rsquared_adj, press], rel=1e-9
    )
    assert q.r2_predicted == pytest.approx(1 - press / reference.centered_tss)
    se = reference.get_prediction().se_mean
    assert q.adequate_precision == pytest.approx(
        np.ptp(reference.fittedvalues) / np.sqrt(np.mean(se**2))
    )


def test_residual_diagnostics_agree_with_statsmodels(surface, reference):
    influence, table = OLSInfluence(reference), residual_table(surface)
    np.testing.assert_allclose(table["leverage"], influence.hat_matrix_diag, rtol=1e-9)
    np.testing.assert_allclose(
        table["student_internal"], influence.resid_studentized_internal, rtol=1e-8
    )
    np.testing.assert_allclose(
        table["student_external"], influence.resid_studentized_external, rtol=1e-8
    )
    np.testing.assert_allclose(table["cook"], influence.cooks_distance[0], rtol=1e-8)
    assert leverage(surface).sum() == pytest.approx(10)
    assert normality(surface).p > 0.05


def test_a_spoilt_run_is_named_an_outlier(runs, box, natural):
    spoilt = runs.copy()
    spoilt.loc[0, "repose_angle_deg"] += 6
    table = residual_table(fit_surface(natural(spoilt), "repose_angle_deg", box))
    assert list(table.loc[table["outlier"], "run"]) == [1]
    assert not residual_table(fit_surface(natural(runs), "repose_angle_deg", box))[
        "outlier"
    ].any()


def test_prediction_agrees_with_statsmodels(surface, reference):
    where = np.array([[0.65, 0.55, 0.04], [0.56, 0.41, 0.05]])
    x = polynomial.matrix(surface.box.coded(where), surface.terms)
    expected = reference.get_prediction(x).summary_frame()
    mean, variance = surface.evaluate(where)
    assert surface.lack_sd == 0
    found = np.column_stack([mean, np.sqrt(variance)])
    np.testing.assert_allclose(found, expected[["mean", "mean_se"]], rtol=1e-9)


def test_equation_8_as_printed_follows_from_table_9(surface):
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
    found = compare(
        dict(zip(surface.term_names, printed)),
        dict(zip(surface.term_names, surface.coefficients)),
    )
    assert found["follows"].all()


def test_a_response_grid_is_the_surface(surface):
    grid = response_grid(
        surface,
        "static_friction",
        "rolling_friction",
        steps=5,
        at={"restitution": 0.65},
    )
    assert len(grid) == 25
    corner = grid[
        (grid["static_friction"] == 0.6) & (grid["rolling_friction"] == 0.05)
    ].iloc[0]
    assert corner["predicted"] == pytest.approx(surface.mean([[1, 1, 1]])[0])
    for bad in (
        ("static_friction", "static_friction", {}),
        ("static_friction", "mu", {}),
        (*surface.names[:2], {"mu": 1.0}),
    ):
        with pytest.raises(ValueError, match="two different factors"):
            response_grid(surface, *bad[:2], at=bad[2])


def test_reduction_keeps_the_significant_terms_and_hierarchy(surface):
    reduced = reduce(surface)
    assert (
        list(reduced.steps["term"]) == ["A²", "AB", "AC"]
        and (reduced.steps["p"] > 0.05).all()
    )
    # B² and C² (p .06 and .08 beside all the others) become significant once those
    # three no longer take degrees of freedom
    assert reduced.surface.term_names == ["intercept", "A", "B", "C", "BC", "B²", "C²"]
    reference = sm.OLS(
        surface.response, polynomial.matrix(surface.points, reduced.surface.terms)
    ).fit()
    np.testing.assert_allclose(
        reduced.surface.coefficients, reference.params, rtol=1e-9
    )
    assert (reference.pvalues < 0.05).all()


def test_reduction_keeps_a_weak_factor_of_a_strong_interaction(box):
    rng = np.random.default_rng(1)
    design = box_behnken(box, centre_points=5)
    coded = box.coded(box.points(design))
    design["y_deg"] = (
        30 + 2 * coded[:, 1] * coded[:, 2] + 0.1 * rng.standard_normal(len(design))
    )
    assert {"B", "C", "BC"} <= set(
        reduce(fit_surface(design, "y_deg", box)).surface.term_names
    )


def test_lack_of_fit_is_added_to_the_error_only_where_it_is_there(box):
    rng = np.random.default_rng(3)
    design = box_behnken(box, centre_points=5)
    z = box.coded(box.points(design))
    noise = 0.2 * rng.standard_normal(len(design))
    bent = fit_surface(
        design.assign(y_deg=z[:, 0] + 3 * z[:, 0] ** 2 * z[:, 1] + noise), "y_deg", box
    )
    plain = fit_surface(design.assign(y_deg=z[:, 0] + noise), "y_deg", box)
    assert bent.lack_sd > 0.5 and plain.lack_sd == 0
    assert bent.variance([[0, 0, 0]])[0] > bent.lack_sd**2


def test_intervals_cover_at_their_stated_rate(box):
    """95 % intervals of mean and further run; the control takes the wrong quantile
    (normal for t on 7 df) and falls short."""
    rng = np.random.default_rng(0)
    design = box_behnken(box, centre_points=5)
    z = box.coded(box.points(design))
    truth, where = np.array(EQ8), np.array([[0.5, -0.5, 0.2]])
    x = polynomial.matrix(z, polynomial.full(3))
    at = polynomial.matrix(where, polynomial.full(3)) @ truth
    first = fit_surface(
        design.assign(y_deg=x @ truth + 0.25 * rng.standard_normal(len(z))),
        "y_deg",
        box,
    )
    leverage_at = first.variance(where)[0] / first.residual_ms
    y = x @ truth + 0.25 * rng.standard_normal((4000, len(z)))
    beta = y @ x @ first.inverse
    s2 = np.sum((y - beta @ x.T) ** 2, axis=1) / first.residual_df
    off = abs(beta @ polynomial.matrix(where, first.terms)[0] - at) / np.sqrt(
        s2 * leverage_at
    )
    assert 0.94 < np.mean(off < stats.t.ppf(0.975, first.df)) < 0.96
    assert np.mean(off < 1.96) < 0.93


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
