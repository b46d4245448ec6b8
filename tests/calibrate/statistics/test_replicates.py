"""Packing noise, replicates and power against statsmodels and by simulation; what
common packings save."""

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from statsmodels.formula import api as smf
from statsmodels.stats.anova import anova_lm
from statsmodels.stats.power import TTestIndPower

from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.assessment import coefficients
from benchtwin.calibrate.statistics.designs import box_behnken
from benchtwin.calibrate.statistics.replicates import (
    Noise,
    common_packing,
    packing_noise,
    plan,
    power,
)
from benchtwin.calibrate.statistics.surface import fit_surface


@pytest.fixture
def rng():
    return np.random.default_rng(0)


@pytest.fixture
def design(box):
    return box_behnken(box, centre_points=5)


def test_the_interval_of_the_noise_covers_at_its_rate(rng):
    tables = (pd.DataFrame({"y_deg": 1.3 * rng.standard_normal(6)}) for _ in range(800))
    hits = [n.low < 1.3 < n.high for n in (packing_noise(t, "y_deg") for t in tables)]
    assert 0.76 < np.mean(hits) < 0.84
    groups = pd.DataFrame({"y_deg": [1.0, 3.0, 11.0, 13.0], "point": [0, 0, 1, 1]})
    noise = packing_noise(groups, "y_deg", point="point")
    assert (noise.sd, noise.df) == (pytest.approx(np.sqrt(2)), 2)


def test_power_of_one_factor_at_two_levels_is_the_two_sample_t_tests():
    coded = np.array([[-1.0], [1.0]])
    for r in (3, 8):
        expected = TTestIndPower().power(effect_size=1.2, nobs1=r, alpha=0.05)
        assert power(coded, 1.2 * 0.7, 0.7, r, terms="linear") == pytest.approx(
            expected, rel=1e-6
        )


def test_the_power_stated_is_the_power_had(design, box, rng):
    """Two runs a point, effect 1°, noise 0.9°: how often the factor is found by the
    regression itself."""
    coded = box.coded(box.points(design))
    twice = pd.concat([design, design], ignore_index=True)
    z = box.coded(box.points(twice))
    stated = power(coded, 1.0, 0.9, 2)
    found = [
        coefficients(
            fit_surface(twice.assign(y_deg=0.5 * z[:, 1] + noise), "y_deg", box)
        )["p"][2]
        < 0.05
        for noise in 0.9 * rng.standard_normal((300, len(z)))
    ]
    assert np.mean(found) == pytest.approx(stated, abs=0.085) and 0.3 < stated < 0.9


def test_more_noise_smaller_effects_and_more_power_need_more_runs(design, box):
    coded = box.coded(box.points(design))
    measured = Noise(1.3, 5, 1.0, 2.2, 0.8)
    base = plan(coded, 1.5, measured)
    assert base.reached and base.replicates > base.replicates_at_estimate >= 1
    assert plan(coded, 1.0, measured).replicates > base.replicates
    assert plan(coded, 1.5, measured, wanted=0.95).replicates > base.replicates
    assert (
        base.table["power_cautious"].iloc[-1]
        >= 0.8
        > base.table["power_cautious"].iloc[-2]
    )
    short = plan(coded, 0.2, measured, most=5)
    assert not short.reached and "even 5 runs" in short.statement


def layout(rng, points, packings, shared, own):
    p, q = np.meshgrid(range(points), range(packings), indexing="ij")
    y = (
        2.0 * p
        + shared * rng.standard_normal(packings)[q]
        + own * rng.standard_normal((points, packings))
    )
    return pd.DataFrame({"point": p.ravel(), "packing": q.ravel(), "y_deg": y.ravel()})


def paired(table):
    return common_packing(table, "y_deg", point="point", packing="packing")


def test_correlation_of_common_packings_covers_at_its_rate(rng):
    truth = 0.8**2 / (0.8**2 + 1.0**2)
    found = [paired(layout(rng, 6, 8, 0.8, 1.0)) for _ in range(400)]
    hits = [p.low < truth < p.high for p in found]
    assert 0.86 < np.mean(hits) < 0.94


def test_correlation_is_that_of_the_two_way_analysis_of_variance(rng):
    table = layout(rng, 5, 7, 0.8, 1.0)
    ms = anova_lm(smf.ols("y_deg ~ C(point) + C(packing)", table).fit())["mean_sq"]
    between = (ms["C(packing)"] - ms["Residual"]) / 5
    assert paired(table).correlation == pytest.approx(
        between / (between + ms["Residual"])
    )


def test_common_packings_are_called_worth_it_only_where_they_are(rng):
    with_, without = (
        paired(layout(rng, 6, 10, 1.0, 0.5)),
        paired(layout(rng, 6, 10, 0.0, 1.0)),
    )
    assert with_.worth_it and with_.gain > 2 and not without.worth_it
    assert with_.gain == pytest.approx(1 / (1 - with_.correlation))


def test_the_gain_is_the_variance_that_effects_lose(rng):
    """Variance of a difference between two points: fresh packings over common ones,
    1/(1 − ρ)."""
    common = [
        layout(rng, 2, 4, 1.0, 0.7).groupby("point")["y_deg"].mean().diff().iloc[1]
        for _ in range(500)
    ]
    fresh = np.sqrt(1.0**2 + 0.7**2) * rng.standard_normal((500, 2, 4))
    ratio = np.var(fresh.mean(axis=2)[:, 1] - fresh.mean(axis=2)[:, 0]) / np.var(common)
    assert ratio == pytest.approx(1 + 1 / 0.49, rel=0.25)


def test_a_correlation_lowers_the_plan_by_its_gain(design, box):
    coded, noise = box.coded(box.points(design)), Noise(2.0, 20, 1.8, 2.3, 0.8)
    assert plan(coded, 1.0, noise, correlation=0.5).replicates == pytest.approx(
        plan(coded, 1.0, noise).replicates / 2, abs=1
    )


def test_main_effects_use_the_designs_own_leverage(design, box):
    coded = box.coded(box.points(design))
    x = polynomial.matrix(coded, polynomial.full(3))
    se = 1.0 * np.sqrt(np.linalg.inv(x.T @ x)[1, 1])
    assert se == pytest.approx(1 / np.sqrt(8))
    shift, limit = 0.6 / se, stats.t.ppf(0.975, 7)
    assert power(coded, 1.2, 1.0, 1) == pytest.approx(
        stats.nct.sf(limit, 7, shift) + stats.nct.cdf(-limit, 7, shift)
    )


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: packing_noise(pd.DataFrame({"y_deg": [1.0]}), "y_deg"),
            "y_deg: packing noise needs at least two",
        ),
        (
            lambda: packing_noise(pd.DataFrame({"y_deg": [1.0, 1.0]}), "y_deg"),
            "did their packings differ",
        ),
        (lambda: plan(np.eye(3), 0.0, Noise(1, 3, 1, 1, 0.8)), "effect"),
        (
            lambda: plan(np.eye(3), 1.0, Noise(1, 3, 1, 1, 0.8), correlation=1.0),
            "correlation",
        ),
        (
            lambda: power(np.array([[-1.0], [1.0]]), 1.0, 1.0, 1, terms="linear"),
            "no degrees of freedom",
        ),
        (lambda: paired(layout(np.random.default_rng(0), 2, 2, 1, 1).head(3)), "gaps"),
    ],
)
def test_bad_input_is_named(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_an_effect_that_nobody_could_miss_has_power_one(design):
    coded = design.filter(like="_coded").to_numpy()
    assert [
        power(coded, 1.5, sd, n) for sd, n in ((0.06, 1), (0.2, 2), (0.01, 3))
    ] == pytest.approx([1.0, 1.0, 1.0])
