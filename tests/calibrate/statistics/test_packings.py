"""Surfaces through runs on common packings: against statsmodels' mixed model, and how
often their intervals hold the truth."""

import numpy as np
import pandas as pd
import pytest
import statsmodels.api as sm
from scipy import stats

from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.anova import anova_table
from benchtwin.calibrate.statistics.assessment import coefficients, quality
from benchtwin.calibrate.statistics.bench import pooled_mean
from benchtwin.calibrate.statistics.designs import box_behnken
from benchtwin.calibrate.statistics.packings import decorrelate
from benchtwin.calibrate.statistics.reduction import reduce
from benchtwin.calibrate.statistics.residuals import residual_table
from benchtwin.calibrate.statistics.surface import fit_surface

TRUTH = np.array(
    [30.04, 0.5875, 0.8375, 0.775, 0.075, 0.1, 0.35, -0.0325, -0.2825, -0.2575]
)


def campaign(box, rng, packings=4, shared=0.6, own=0.4):
    """Every point of a Box–Behnken design (one centre) on the same packings, and three
    more centres on packings of their own."""
    design = box_behnken(box, centre_points=1)
    table = pd.concat(
        [design.assign(packing=b) for b in range(packings)], ignore_index=True
    )
    centres = pd.concat(
        [design[design["point"] == "centre"].assign(packing=100 + i) for i in range(3)]
    )
    table = pd.concat([table, centres], ignore_index=True)
    level = dict(
        zip(
            table["packing"].unique(),
            shared * rng.standard_normal(table["packing"].nunique()),
        )
    )
    x = polynomial.matrix(box.coded(box.points(table)), polynomial.full(3))
    return table.assign(
        y_deg=x @ TRUTH
        + table["packing"].map(level)
        + own * rng.standard_normal(len(table))
    )


def test_coefficients_and_errors_agree_with_a_mixed_model(box):
    table = campaign(box, np.random.default_rng(3))
    ours = fit_surface(table, "y_deg", box, packing="packing")
    x = polynomial.matrix(ours.points, ours.terms)
    reference = sm.MixedLM(table["y_deg"], x, groups=table["packing"]).fit(reml=True)
    assert ours.shared == pytest.approx(
        float(reference.cov_re.iloc[0, 0]) / reference.scale, rel=1e-3
    )
    assert ours.residual_ms == pytest.approx(reference.scale, rel=1e-4)
    np.testing.assert_allclose(
        ours.coefficients, reference.fe_params, rtol=1e-4, atol=1e-5
    )
    # the mixed model's errors come from a numerical Hessian: half a percent;
    # generalised least squares with the same λ is exact
    np.testing.assert_allclose(coefficients(ours)["se"], reference.bse_fe, rtol=1e-2)
    same = table["packing"].to_numpy()[:, None] == table["packing"].to_numpy()
    exact = sm.GLS(table["y_deg"], x, sigma=np.eye(len(x)) + ours.shared * same).fit()
    np.testing.assert_allclose(coefficients(ours)["se"], exact.bse, rtol=1e-7)


def coverage(box, runs, *, packing):
    """How often 95 % intervals hold the truth: of factor B's coefficient, and of the
    mean at a point; mean se of the former."""
    rng = np.random.default_rng(0)
    where = box.natural([[0.4, 0.3, -0.2]])
    level = polynomial.matrix([[0.4, 0.3, -0.2]], polynomial.full(3)) @ TRUTH
    effect, mean, se = 0, 0, []
    for _ in range(runs):
        surface = fit_surface(campaign(box, rng), "y_deg", box, packing=packing)
        row, (at, variance) = coefficients(surface).iloc[2], surface.evaluate(where)
        effect += row["low"] <= TRUTH[2] <= row["high"]
        reach = stats.t.ppf(0.975, surface.residual_df) * np.sqrt(variance[0])
        mean += abs(at[0] - level[0]) <= reach
        se.append(row["se"])
    return effect / runs, mean / runs, np.mean(se)


def test_effects_gain_and_intervals_still_cover(box):
    """The control takes the runs for independent: effects are then better known than it
    says."""
    effect, mean, se = coverage(box, 200, packing="packing")
    naive_effect, _, naive_se = coverage(box, 100, packing=None)
    assert 0.91 < effect < 0.98 and 0.89 < mean < 0.98
    assert naive_effect >= 0.98
    assert naive_se / se == pytest.approx(
        np.sqrt(1 + 0.6**2 / 0.4**2), rel=0.1
    )  # √gain = 1/√(1 − ρ)


def test_nothing_shared_gives_the_ordinary_surface_back(box):
    rng = np.random.default_rng(8)
    table = campaign(box, rng, shared=0.0)
    y = table.assign(
        y_deg=table["y_deg"] - table.groupby("packing")["y_deg"].transform("mean") * 1.0
    )
    surface, plain = (
        fit_surface(y, "y_deg", box, packing="packing"),
        fit_surface(y, "y_deg", box),
    )
    assert surface.shared == 0 and surface.df == plain.df
    np.testing.assert_allclose(
        surface.covariance, plain.covariance, rtol=1e-9, atol=1e-12
    )


def test_analysis_of_variance_and_diagnostics_hold_together(box):
    table = campaign(box, np.random.default_rng(1))
    surface = fit_surface(table, "y_deg", box, packing="packing")
    t = anova_table(surface).set_index("source")
    assert t.loc["Total", "sum_of_squares"] == pytest.approx(
        t.loc[["Model", "Residual"], "sum_of_squares"].sum()
    )
    assert (
        t.loc["Residual", "df"]
        == t.loc[["Lack of fit", "Pure error"], "df"].sum()
        == len(table) - 10
    )
    assert residual_table(surface)["leverage"].sum() == pytest.approx(10)
    assert 0 < quality(surface).r2_predicted < quality(surface).r2 < 1
    assert surface.noise_sd == pytest.approx(
        np.hypot(0.6, 0.4), rel=0.6
    ) and surface.noise_sd > np.sqrt(surface.residual_ms)
    assert reduce(surface).surface.shared == surface.shared
    assert (
        surface.df == 4 + 3 - 1
    )  # the mean level is known from seven packings, not from all runs


def test_packings_that_tell_nothing_are_refused():
    x, y = np.ones((4, 1)), np.arange(4.0)
    for labels in ([1, 2, 3, 4], [1, 1, 1, 1]):
        with pytest.raises(ValueError, match="packing"):
            decorrelate(x, y, np.array(labels))


def test_scatter_of_few_readings_is_pooled_unless_the_f_test_contradicts():
    alone = pooled_mean([30.0], name="pile", scatter_sd=1.5, df=20)
    assert (alone.scatter_sd, alone.df, alone.n) == (1.5, 20, 1)
    both = pooled_mean([29.0, 31.0], name="pile", scatter_sd=1.5, df=20)
    assert both.df == 21 and both.scatter_sd == pytest.approx(
        np.sqrt((2.0 + 20 * 2.25) / 21 / 2)
    )
    quiet = pooled_mean([30.0, 30.01, 29.99], name="pile", scatter_sd=1.5, df=20)
    assert quiet.df == 2 and quiet.scatter_sd < 0.01
    assert (
        pooled_mean([29.0, 31.0], name="pile", scatter_sd=1.5, df=20, pooled=False).df
        == 1
    )
