"""Curves and their inversion: the paper's Eqs. 5–7, statsmodels, intervals checked by
simulation, refusals."""

import dataclasses

import numpy as np
import pandas as pd
import pytest
import statsmodels.api as sm
from scipy import stats
from scipy.interpolate import PchipInterpolator

from benchtwin.calibrate.statistics.bench import (
    BenchMean,
    agreement,
    bench_mean,
    one_reading,
    verify,
)
from benchtwin.calibrate.statistics.curves import fit_monotone, fit_polynomial
from benchtwin.calibrate.statistics.inversion import OutsideRange, invert

REBOUND = [96, 100, 102, 97, 70, 94, 90, 93, 88, 120]
SLIDE = [18.9, 20.7, 19.6, 19.9, 18.8, 19.5, 20.4, 19.6, 19.2, 18.4]
RUN_OUT = [215, 200, 220, 200, 230, 210, 210, 225, 215, 215]


@pytest.fixture
def rng():
    return np.random.default_rng(0)


def exact(value, sd=1.0):
    return BenchMean(value, sd, 1e6, 0.0, 100)


def test_equations_5_to_7_come_out_of_the_tables(drop_rows, slide_rows, roll_rows):
    drop = fit_polynomial(drop_rows, "restitution", "rebound_height_mm", 2)
    slide = fit_polynomial(slide_rows, "static_friction", "slide_angle_deg", 1)
    roll = fit_polynomial(roll_rows, "rolling_friction", "run_out_mm", 2)
    assert drop.coefficients == pytest.approx([178.571, 98.571, -10.232], abs=1e-3)
    assert drop.r2 == pytest.approx(0.9987, abs=5e-5)
    assert slide.coefficients == pytest.approx([50, 2.5]) and slide.r2 == pytest.approx(
        1
    )
    assert roll.coefficients == pytest.approx(
        [87500, -9716.4, 298.2], abs=0.05
    ) and roll.r2 == pytest.approx(0.9874, abs=5e-5)


def test_the_papers_parameters_come_out(drop_rows, slide_rows):
    drop = invert(
        fit_polynomial(drop_rows, "restitution", "rebound_height_mm", 2),
        bench_mean(REBOUND, name="height"),
    )
    slide = invert(
        fit_polynomial(slide_rows, "static_friction", "slide_angle_deg", 1),
        bench_mean(SLIDE, name="angle"),
    )
    assert round(drop.value, 2) == 0.54 and drop.low < 0.54 < drop.high
    assert round(slide.value, 2) == 0.34 and slide.sd == pytest.approx(
        np.std(SLIDE, ddof=1) / np.sqrt(10) / 50, rel=1e-3
    )


def test_the_papers_rolling_bench_mean_lies_outside_its_own_fitted_curve(
    roll_rows, rng
):
    """Eq. 7 gives 209.8 mm at its end, x = 0.01: the bench's 214 mm asks for less. The
    monotone curve answers."""
    bench = bench_mean(RUN_OUT, name="run-out")
    curve = fit_polynomial(roll_rows, "rolling_friction", "run_out_mm", 2)
    with pytest.raises(
        OutsideRange, match=r"extend rolling_friction below 0\.01"
    ) as refused:
        invert(curve, bench)
    assert refused.value.side == "low" and 0.007 < refused.value.about < 0.01
    allowed = invert(curve, bench, beyond=0.05)
    assert allowed.value == pytest.approx(
        0.0095, abs=5e-5
    ) and "outside the simulated range" in " ".join(allowed.notes)
    monotone = fit_monotone(
        roll_rows,
        "rolling_friction",
        "run_out_mm",
        rng=rng,
        sd="sd_mm",
        repeats="repeats",
    )
    assert round(invert(monotone, bench).value, 4) == 0.0102
    with pytest.raises(ValueError, match="beyond"):
        invert(monotone, bench, beyond=0.05)


def test_unweighted_fit_agrees_with_statsmodels(drop_rows):
    x = drop_rows["restitution"].to_numpy()
    reference = sm.OLS(drop_rows["rebound_height_mm"], np.vander(x, 3)).fit()
    curve = fit_polynomial(drop_rows, "restitution", "rebound_height_mm", 2)
    at = np.array([0.47, 0.62])
    np.testing.assert_allclose(curve.coefficients, reference.params, rtol=1e-7)
    se = reference.get_prediction(np.vander(at, 3)).se_mean
    np.testing.assert_allclose(np.sqrt(curve.variance(at)), se, rtol=1e-6)


def test_weighted_fit_agrees_with_statsmodels(drop_rows):
    """Without repeats the sds are taken as they are."""
    x, w = drop_rows["restitution"].to_numpy(), 1 / drop_rows["sd_mm"].to_numpy() ** 2.0
    reference = sm.WLS(drop_rows["rebound_height_mm"], np.vander(x, 3), weights=w).fit(
        cov_type="fixed scale"
    )
    curve = fit_polynomial(
        drop_rows.drop(columns="repeats"),
        "restitution",
        "rebound_height_mm",
        2,
        sd="sd_mm",
    )
    np.testing.assert_allclose(curve.coefficients, reference.params, rtol=1e-7)
    se = np.sqrt(
        np.einsum(
            "ij,jk,ik->i",
            np.vander([0.5], 3),
            reference.cov_params(),
            np.vander([0.5], 3),
        )
    )
    np.testing.assert_allclose(np.sqrt(curve.variance(0.5)), se, rtol=1e-6)


def test_a_degree_that_does_not_describe_the_rows_widens_the_error(roll_rows):
    curve = fit_polynomial(
        roll_rows, "rolling_friction", "run_out_mm", 2, sd="sd_mm", repeats="repeats"
    )
    assert curve.inflation > 20
    bench = exact(125.0)
    assert invert(curve, bench).budget["fit"] > 0.8


def test_a_monotone_curve_never_turns_and_passes_good_rows(roll_rows, rng):
    curve = fit_monotone(
        roll_rows,
        "rolling_friction",
        "run_out_mm",
        rng=rng,
        sd="sd_mm",
        repeats="repeats",
    )
    y = curve.mean(np.linspace(0.01, 0.06, 300))
    assert (np.diff(y) <= 1e-9).all()
    np.testing.assert_allclose(curve.mean(curve.x), roll_rows["run_out_mm"])
    spoilt = roll_rows.assign(run_out_mm=[216, 125, 130, 48, 36, 40])
    y = fit_monotone(spoilt, "rolling_friction", "run_out_mm", rng=rng).mean(
        np.linspace(0.01, 0.06, 300)
    )
    assert (np.diff(y) <= 1e-9).all()


def test_a_monotone_curves_error_covers_the_shape_between_sharp_rows(rng):
    """Rows good to 0.1 mm of a steeply bent run-out; the control is the redrawn rows'
    scatter alone."""
    x = np.linspace(0.01, 0.06, 6)
    between = (x[:-1, None] + [0.0025, 0.005, 0.0075]).ravel()
    rows = pd.DataFrame({"mu_r": x, "l_mm": 2.6 / (x + 0.002), "sd_mm": 0.1, "n": 10})
    curve = fit_monotone(rows, "mu_r", "l_mm", rng=rng, sd="sd_mm", repeats="n")
    off = abs(curve.mean(between) - 2.6 / (between + 0.002))
    scatter = PchipInterpolator(curve.x, curve.draws, axis=1)(between).std(axis=0)
    assert (
        np.mean(off < 2 * np.sqrt(curve.variance(between))) > 0.9
        and np.mean(off < 2 * scatter) < 0.6
    )


def true_height(x):
    return 178.571 * x**2 + 98.571 * x - 10.232


def coverage(
    fit,
    runs,
    rng,
    *,
    bench_sd=2.0,
    shared=0.5,
    sim_sd=5.0,
    repeats=5,
    change=None,
    trimmed=0,
    said=None,
):
    """Fraction of 95 % intervals that hold the truth, everything drawn anew each
    time."""
    x, hits = np.linspace(0.45, 0.65, 6), 0
    for _ in range(runs):
        single = true_height(x)[:, None] + sim_sd * rng.standard_normal((6, repeats))
        table = pd.DataFrame(
            {
                "e": x,
                "h_mm": single.mean(axis=1),
                "sd_mm": single.std(axis=1, ddof=1),
                "n": repeats,
            }
        )
        truth = rng.uniform(0.52, 0.58)
        readings = (
            true_height(truth)
            + shared * rng.standard_normal()
            + bench_sd * rng.standard_normal(10 + 2 * trimmed)
        )
        kept = np.sort(readings)[trimmed : 10 + trimmed]
        bench = bench_mean(
            kept, name="h", shared_sd=shared, trimmed=trimmed if said is None else said
        )
        curve, bench = (change or (lambda c, b: (c, b)))(fit(table, rng), bench)
        found = invert(curve, bench)
        hits += found.low <= truth <= found.high
    return hits / runs


def by_polynomial(table, rng):
    return fit_polynomial(table, "e", "h_mm", 2, sd="sd_mm", repeats="n")


def by_unweighted(table, rng):
    return fit_polynomial(table, "e", "h_mm", 2)


def by_monotone(table, rng):
    return fit_monotone(table, "e", "h_mm", rng=rng, sd="sd_mm", repeats="n")


@pytest.mark.parametrize("fit", [by_polynomial, by_unweighted])
def test_intervals_cover_at_their_stated_rate(fit, rng):
    assert 0.93 < coverage(fit, 500, rng) < 0.975


@pytest.mark.slow
@pytest.mark.parametrize("fit", [by_polynomial, by_unweighted, by_monotone])
@pytest.mark.parametrize("bench_sd", [1.0, 5.0, 12.0])
def test_intervals_cover_at_their_stated_rate_over_many(fit, bench_sd, rng):
    """93–97 % for polynomials; a monotone curve is known less well between rows and may
    cover more."""
    assert (
        0.93
        < coverage(fit, 1500, rng, bench_sd=bench_sd)
        < (0.985 if fit is by_monotone else 0.97)
    )


def test_ignoring_any_part_of_the_error_covers_too_little(rng):
    """The controls: without the fit's error, without the measuring error."""

    def no_fit(curve, bench):
        return dataclasses.replace(curve, covariance=0 * curve.covariance), bench

    def no_measuring(curve, bench):
        return curve, dataclasses.replace(bench, shared_sd=0.0)

    assert coverage(by_polynomial, 300, rng, bench_sd=2.0, change=no_fit) < 0.8
    assert (
        coverage(
            by_polynomial,
            300,
            rng,
            bench_sd=1.0,
            sim_sd=1.0,
            shared=3.0,
            change=no_measuring,
        )
        < 0.8
    )


def test_trimmed_readings_need_the_trimmed_error(rng):
    """The control does not say that the extremes were left out."""
    assert (
        0.925
        < coverage(
            by_polynomial, 400, rng, bench_sd=8.0, shared=0.0, sim_sd=1.0, trimmed=1
        )
        < 0.98
    )
    assert (
        coverage(
            by_polynomial,
            400,
            rng,
            bench_sd=8.0,
            shared=0.0,
            sim_sd=1.0,
            trimmed=1,
            said=0,
        )
        < 0.9
    )


def test_two_roots_the_one_along_the_trend_is_taken_and_the_other_named():
    x = np.linspace(0, 1, 9)
    table = pd.DataFrame({"mu": x, "y_mm": 100 * (x - 0.7) ** 2})
    found = invert(fit_polynomial(table, "mu", "y_mm", 2), exact(4.0, 0.1))
    assert found.value == pytest.approx(0.5, abs=1e-4)
    assert found.roots == pytest.approx((0.5, 0.9), abs=1e-4)
    assert (
        "ambiguous: mu 0.9" in found.notes[0]
        and "turns within the range" in found.notes[1]
    )
    assert found.high < 0.7


@pytest.mark.parametrize(
    ("value", "slope", "side"),
    [(3.0, 1, "high"), (-1.0, 1, "low"), (3.0, -1, "low"), (-1.0, -1, "high")],
)
def test_outside_the_range_the_side_to_extend_is_named(value, slope, side):
    x = np.linspace(0, 1, 6)
    curve = fit_polynomial(
        pd.DataFrame({"mu": x, "y_deg": slope * (2 * x - 1) + 1}), "mu", "y_deg", 1
    )
    with pytest.raises(
        OutsideRange, match="above 1" if side == "high" else "below 0"
    ) as refused:
        invert(curve, exact(value))
    assert refused.value.side == side and refused.value.about == pytest.approx(
        1.5 if side == "high" else -0.5
    )


def test_an_interval_that_meets_the_end_of_the_range_says_so(slide_rows):
    curve = fit_polynomial(slide_rows, "static_friction", "slide_angle_deg", 1)
    found = invert(curve, exact(15.5, 1.0))
    assert found.low == 0.25 and "cut off at 0.25" in found.notes[0]


def test_the_budget_names_what_matters(drop_rows):
    curve = fit_polynomial(
        drop_rows, "restitution", "rebound_height_mm", 2, sd="sd_mm", repeats="repeats"
    )
    wide = invert(curve, bench_mean(REBOUND, name="h", shared_sd=0.5))
    assert (
        sum(wide.budget.values()) == pytest.approx(1)
        and wide.budget["bench scatter"] > 0.9
    )
    sharp = invert(curve, bench_mean([95, 95.1, 94.9], name="h", shared_sd=0.0))
    assert sharp.budget["simulation scatter"] > 0.9 and sharp.sd < wide.sd / 3


def test_contradicting_recordings_are_flagged():
    names = ["one", "two", "three", "four"]
    table = agreement(names, [10.0, 10.1, 9.9, 12.0], [0.1] * 4)
    assert list(table.loc[table["contradicts"], "name"]) == ["four"]
    assert agreement(["one", "two"], [10.0, 11.0], [0.1, 0.1])["contradicts"].all()
    assert not agreement(names[:3], [10.0, 10.1, 9.9], [0.1] * 3)["contradicts"].any()


def test_verification_is_welchs_test_with_the_papers_relative_error(rng):
    simulated = 94 + 4 * rng.standard_normal(10)
    found = verify(simulated, bench_mean(REBOUND, name="height"), name="height")
    reference = stats.ttest_ind(simulated, REBOUND, equal_var=False)
    assert (found.t, found.p) == pytest.approx(
        (reference.statistic, reference.pvalue), rel=1e-9
    )
    assert (
        found.relative_error == pytest.approx(abs(simulated.mean() - 95) / 95)
        and found.agrees
    )
    assert not verify(
        simulated + 20, bench_mean(REBOUND, name="height"), name="height"
    ).agrees
    with pytest.raises(ValueError, match="height: verification needs at least two"):
        verify([94.0], bench_mean(REBOUND, name="height"), name="height")


def test_one_reading_takes_its_scatter_from_elsewhere():
    assert one_reading(
        31.0, name="angle", scatter_sd=1.3, df=4, shared_sd=0.1
    ).sd == pytest.approx(np.hypot(1.3, 0.1))
    with pytest.raises(ValueError, match="angle: one reading needs"):
        one_reading(31.0, name="angle", scatter_sd=0.0, df=4)


@pytest.mark.parametrize(
    ("readings", "options", "message"),
    [
        ([5.0], {}, "rebound: 1 reading has no scatter"),
        ([5.0, 5.0, 5.0], {}, "rebound: all 3 readings equal"),
        ([5.0, np.nan], {}, "rebound: reading 2 is not finite"),
        ([5.0, 6.0], {"shared_sd": -1.0}, "must not be negative"),
    ],
)
def test_bad_readings_are_named(readings, options, message):
    with pytest.raises(ValueError, match=message):
        bench_mean(readings, name="rebound", **options)


def test_equal_readings_of_a_coarse_scale_take_the_stated_error():
    assert bench_mean(
        [5.0, 5.0, 5.0, 5.0], name="rebound", reading_sd=0.4
    ).scatter_sd == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("change", "options", "message"),
    [
        (lambda t: t.assign(run_out_mm=5.0), {}, "run_out_mm: all 6 values equal"),
        (lambda t: t.head(2), {}, "rolling_friction: degree 2 needs at least 3"),
        (lambda t: t.head(3), {}, "leave nothing to see the error"),
        (
            lambda t: t.assign(sd_mm=-1.0),
            {"sd": "sd_mm"},
            "column sd_mm: row 1 is negative",
        ),
        (
            lambda t: t.assign(repeats=0),
            {"sd": "sd_mm", "repeats": "repeats"},
            "column repeats: row 1 is below 1",
        ),
        (
            lambda t: t.assign(repeats=1),
            {"sd": "sd_mm", "repeats": "repeats"},
            "one run a row",
        ),
        (
            lambda t: t.assign(sd_mm=[0, 1, 1, 1, 1, 1]),
            {"sd": "sd_mm"},
            "row 1 is zero",
        ),
    ],
)
def test_bad_rows_are_named(roll_rows, change, options, message):
    with pytest.raises(ValueError, match=message):
        fit_polynomial(
            change(roll_rows), "rolling_friction", "run_out_mm", 2, **options
        )


def test_runs_without_any_scatter_weigh_alike(slide_rows):
    curve = fit_polynomial(
        slide_rows.assign(sd_deg=0.0, n=3),
        "static_friction",
        "slide_angle_deg",
        1,
        sd="sd_deg",
        repeats="n",
    )
    assert curve.coefficients == pytest.approx([50, 2.5]) and not curve.absolute
