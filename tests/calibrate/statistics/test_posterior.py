"""The posterior: closed forms, calibration by simulation, two ways of drawing, what is
resolved, what would narrow it."""

import dataclasses

import numpy as np
import pytest
from scipy import stats

from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.bench import BenchMean, bench_mean
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.designs import box_behnken
from benchtwin.calibrate.statistics.posterior import (
    Observable,
    log_posterior,
    on_grid,
    summary,
    trade_offs,
)
from benchtwin.calibrate.statistics.prior import Prior
from benchtwin.calibrate.statistics.sampling import effective_draws, sample, split_r_hat
from benchtwin.calibrate.statistics.surrogate import fit_surrogate

EQ8 = np.array(
    [30.04, 0.5875, 0.8375, 0.775, 0.075, 0.1, 0.35, -0.0325, -0.2825, -0.2575]
)


class Plane:
    """A surrogate known exactly: slope per coded unit, no error."""

    def __init__(self, box, slope):
        self.box, self.slope, self.df = box, np.asarray(slope, dtype=float), 1e6

    def evaluate(self, natural):
        return self.box.coded(natural) @ self.slope, np.zeros(len(natural))


@pytest.fixture
def rng():
    return np.random.default_rng(0)


@pytest.fixture
def angle(surrogate):
    return Observable("repose_angle_deg", surrogate, BenchMean(31.0, 0.3, 4, 0.1, 5))


def known(value, sd):
    return BenchMean(value, sd, 1e6, 0.0, 100)


def test_a_known_plane_and_normal_priors_give_the_textbook_posterior(rng):
    """Cov' = (D⁻¹ + s sᵀ/σ²)⁻¹, mean' = Cov' (D⁻¹ m + s ȳ/σ²): priors far inside a wide
    box."""
    box = Box(("a", "b"), [-10.0, -10.0], [10.0, 10.0])
    prior = Prior(box, {"a": (1.0, 1.0), "b": (-0.5, 0.5)})
    slope, value, sd = np.array([1.0, 2.0]), 1.5, 0.4
    found = sample(
        [Observable("y", Plane(box, slope * 10), known(value, sd))],
        prior,
        rng=rng,
        ess=2000,
    )
    precision = np.diag([1.0, 4.0]) + np.outer(slope, slope) / sd**2
    covariance = np.linalg.inv(precision)
    mean = covariance @ (np.array([1.0, -2.0]) + slope * value / sd**2)
    assert found.converged and not found.note
    assert (
        abs(found.draws.mean() - mean) < 4 * np.sqrt(np.diag(covariance) / 2000)
    ).all()
    np.testing.assert_allclose(
        np.cov(found.draws.T), covariance, atol=0.1 * covariance.max()
    )


def test_few_bench_readings_leave_students_tails(rng):
    """A plane seen by three readings: the posterior is t on two degrees of freedom."""
    box = Box.of({"a": (-1.0, 1.0)})
    seen = [Observable("y", Plane(box, [1.0]), BenchMean(0.0, 0.02, 2.0, 0.0, 3))]
    found = on_grid(seen, Prior.uniform(box), rng=rng, cells=4001, draws=40_000)
    for q in (0.9, 0.99):
        assert found.draws["a"].quantile(q) == pytest.approx(
            0.02 * stats.t.ppf(q, 2), rel=0.08
        )


@pytest.mark.slow
def test_ensembles_and_grid_agree(angle, rng):
    prior = Prior.uniform(angle.surrogate.box)
    chain, grid = (
        sample([angle], prior, rng=rng),
        on_grid([angle], prior, rng=rng, draws=20_000),
    )
    a, b = summary(chain).set_index("factor"), summary(grid).set_index("factor")
    assert chain.converged and grid.converged
    off = (chain.draws.mean() - grid.draws.mean()).to_numpy()
    assert (abs(off) < 0.1 * b["prior_sd"]).all() and (
        abs(a["sd"] / b["sd"] - 1) < 0.06
    ).all()
    assert (a["ess"] > 1000).all() and (a["r_hat"] < 1.01).all()


def test_the_same_seed_gives_the_same_draws():
    box = Box.of({"a": (-1.0, 1.0)})
    seen, prior = (
        [Observable("y", Plane(box, [1.0]), known(0.3, 0.2))],
        Prior.uniform(box),
    )
    one, two, other = (
        sample(seen, prior, rng=np.random.default_rng(s), ess=1, max_steps=60)
        for s in (1, 1, 2)
    )
    assert one.draws.equals(two.draws) and not one.draws.equals(other.draws)


def test_a_short_chain_is_not_called_converged(angle, rng):
    found = sample(
        [angle], Prior.uniform(angle.surrogate.box), rng=rng, ess=100_000, max_steps=150
    )
    assert not found.converged and "not converged" in found.note


def test_r_hat_and_effective_draws_see_what_they_are_for(rng):
    white = rng.standard_normal((4, 1000, 10, 1))
    assert split_r_hat(white)[0] == pytest.approx(1, abs=2e-3)
    assert split_r_hat(white + np.array([0, 0, 0, 1.0])[:, None, None, None])[0] > 1.05
    slow = np.zeros_like(white)
    for i in range(1, 1000):
        slow[:, i] = 0.9 * slow[:, i - 1] + white[:, i]
    assert effective_draws(white)[0] == pytest.approx(40_000, rel=0.1)
    assert effective_draws(slow)[0] == pytest.approx(
        40_000 * 0.1 / 1.9, rel=0.2
    )  # τ = (1 + ρ)/(1 − ρ)
    white[0, :, 0] = 1.0  # a walker that is stuck
    assert effective_draws(white)[0] == 0


def calibration(runs, rng, *, ignore=False, bend=0.0, sim_sd=0.4, bench_sd=0.2):
    """How often stated 90 % sets (highest density), and 90 % intervals of single
    factors, hold a truth drawn from the prior."""
    box = Box(("e", "mu", "mu_r"), [0.55, 0.4, 0.03], [0.65, 0.6, 0.05])
    prior, design = Prior.uniform(box), box_behnken(box, centre_points=5)
    z = box.coded(box.points(design))

    def truth(coded):
        return polynomial.matrix(coded, polynomial.full(3)) @ EQ8 + bend * (
            coded[:, 0] * coded[:, 1] ** 2 - coded[:, 2] ** 3 / 2
        )

    sets, singles = 0, 0.0
    for _ in range(runs):
        table = design.assign(y_deg=truth(z) + sim_sd * rng.standard_normal(len(z)))
        fitted = fit_surrogate(table, "y_deg", box)
        if ignore:
            fitted = dataclasses.replace(fitted, covariance=0 * fitted.covariance)
        at = prior.draw(1, rng)
        readings = (
            truth(box.coded(at))
            + 0.05 * rng.standard_normal()
            + bench_sd * rng.standard_normal(8)
        )
        seen = [
            Observable(
                "y_deg", fitted, bench_mean(readings, name="y_deg", shared_sd=0.05)
            )
        ]
        found = on_grid(seen, prior, rng=rng, cells=15, draws=1000)
        density = log_posterior(found.draws.to_numpy(), seen, prior)
        sets += log_posterior(at, seen, prior)[0] >= np.quantile(density, 0.1)
        low, high = np.quantile(found.draws, [0.05, 0.95], axis=0)
        singles += np.mean((low <= at[0]) & (at[0] <= high))
    return sets / runs, singles / runs


def test_stated_90_percent_sets_hold_the_truth_90_percent_of_the_time(rng):
    sets, singles = calibration(240, rng)
    assert 0.85 < sets < 0.95 and 0.86 < singles < 0.94


def test_ignoring_the_surrogates_error_holds_it_far_less_often(rng):
    sets, _ = calibration(100, rng, ignore=True)
    assert sets < 0.7


@pytest.mark.slow
@pytest.mark.parametrize("bend", [0.0, 0.3, 1.0])
def test_sets_hold_the_truth_also_where_the_surface_is_no_quadratic(rng, bend):
    sets, singles = calibration(1000, rng, bend=bend, sim_sd=0.3)
    assert 0.87 < sets < (1.0 if bend else 0.93) and 0.87 < singles < 0.95


def test_one_angle_ties_parameters_that_it_does_not_tell_apart(rng):
    """Along the line that gives the reading one parameter falls as the other rises; a
    parameter that is seen by itself as well is tied to none."""
    box = Box.of({"a": (-1.0, 1.0), "b": (-1.0, 1.0)})
    sums = Observable("a + b", Plane(box, [1.0, 1.0]), known(0.2, 0.1))
    alone = Observable("a", Plane(Box.of({"a": (-1.0, 1.0)}), [1.0]), known(0.1, 0.01))
    prior = Prior.uniform(box)
    tied = trade_offs(on_grid([sums], prior, rng=rng, cells=101), ["a", "b"])
    assert tied[["one", "other"]].to_numpy().tolist() == [["a", "b"]]
    assert tied["correlation"][0] < -0.9
    apart = on_grid([sums, alone], prior, rng=rng, cells=401)
    assert trade_offs(apart, ["a", "b"]).empty


def test_the_mode_is_the_densest_point_and_gives_what_the_bench_shows(angle, rng):
    prior = Prior.uniform(angle.surrogate.box)
    found = on_grid([angle], prior, rng=rng, draws=4000)
    at = np.array([list(found.mode.values())])
    drawn = log_posterior(found.draws.to_numpy(), [angle], prior)
    assert log_posterior(at, [angle], prior)[0] >= drawn.max()
    assert abs(found.tension["z"][0]) < 0.5


def test_medians_need_not_be_a_point_of_the_valley(rng):
    """Why a set is exported and not the medians: of three parameters whose product is
    seen, the medians' product is off by many sds, the mode's is not."""

    class Product:
        box, df = Box.of({n: (0.1, 4.0) for n in "abc"}), 1e6

        def evaluate(self, natural):
            return natural.prod(axis=1), np.zeros(len(natural))

    seen = [Observable("abc", Product(), known(1.0, 0.05))]
    found = on_grid(seen, Prior.uniform(Product.box), rng=rng, cells=61)
    assert found.draws.median().prod() > 1.3
    assert abs(np.prod(list(found.mode.values())) - 1) < 0.05


def test_two_observables_together_narrow_more_than_either(angle, rng):
    prior = Prior.uniform(angle.surrogate.box)
    drop = Observable(
        "drop", Plane(Box.of({"restitution": (0.55, 0.65)}), [1.0]), known(0.2, 0.1)
    )
    alone, both = (
        on_grid([angle], prior, rng=rng),
        on_grid([angle, drop], prior, rng=rng),
    )
    assert summary(both)["sd_ratio"][0] < 0.25 < 0.7 < summary(alone)["sd_ratio"][0]
    assert both.draws["restitution"].mean() == pytest.approx(0.61, abs=0.003)


def test_errors_shared_by_two_observables_are_worth_less(rng):
    """Two readings of one thing: sd² (1 + ρ)/2, in closed form for a plane."""
    box = Box.of({"a": (-1.0, 1.0)})
    two = [Observable(n, Plane(box, [1.0]), known(0.0, 0.1)) for n in ("one", "two")]
    for rho in (0.0, 0.6, 0.99):
        correlation = np.array([[1, rho], [rho, 1]])
        found = on_grid(
            two,
            Prior.uniform(box),
            rng=rng,
            cells=801,
            draws=20_000,
            correlation=correlation,
        )
        assert found.draws["a"].std() == pytest.approx(
            0.1 * np.sqrt((1 + rho) / 2), rel=0.03
        )


def test_errors_whose_covariance_was_estimated_have_hotellings_tails():
    """Four means of four readings each, covariance from the same readings: T² exceeds
    its 95 % limit as often as F says, and the density is a function of T² alone."""
    rng, m, n = np.random.default_rng(3), 3, 8
    box = Box.of({"a": (-1.0, 1.0)})
    root, beyond = (
        np.linalg.cholesky(np.array([[1, 0.9, 0], [0.9, 1, 0.3], [0, 0.3, 1.0]])),
        0,
    )
    limit = (n - 1) * m / (n - m) * stats.f.ppf(0.95, m, n - m)
    for _ in range(2000):
        x = rng.standard_normal((n, m)) @ root.T
        sd, r = x.std(axis=0, ddof=1) / np.sqrt(n), np.corrcoef(x.T)
        seen = [
            Observable(
                f"y{k}",
                Plane(box, [0.0]),
                BenchMean(x[:, k].mean(), sd[k], n - 1, 0.0, n),
            )
            for k in range(m)
        ]
        density = log_posterior(np.zeros((1, 1)), seen, Prior.uniform(box), r)[0]
        met = [
            dataclasses.replace(o, bench=dataclasses.replace(o.bench, value=0.0))
            for o in seen
        ]
        best = log_posterior(np.zeros((1, 1)), met, Prior.uniform(box), r)[0]
        square = (np.exp(2 * (best - density) / n) - 1) * (n - 1)
        beyond += square > limit
    assert beyond / 2000 == pytest.approx(0.05, abs=0.015)


def test_a_bench_value_nothing_reaches_is_named(surrogate, rng):
    far = Observable("repose_angle_deg", surrogate, BenchMean(40.0, 0.3, 4, 0.0, 5))
    found = on_grid([far], Prior.uniform(surrogate.box), rng=rng)
    assert (
        not found.tension["reached"][0]
        and "no parameters of the box give the bench's repose_angle_deg" in found.note
    )
    near = on_grid(
        [dataclasses.replace(far, bench=BenchMean(31.0, 0.3, 4, 0.0, 5))],
        Prior.uniform(surrogate.box),
        rng=rng,
    )
    assert near.tension["reached"][0] and not near.note


def test_priors_are_uniform_or_cut_off_normals(rng):
    box = Box(("a", "b"), [0.0, 0.0], [1.0, 1.0])
    prior = Prior(box, {"b": (0.9, 0.3)})
    x = prior.draw(20_000, rng)
    cut = stats.truncnorm(-3, 1 / 3, loc=0.9, scale=0.3)
    assert (
        stats.kstest(x[:, 0], "uniform").pvalue > 0.01
        and stats.kstest(x[:, 1], cut.cdf).pvalue > 0.01
    )
    np.testing.assert_allclose(prior.sd, [1 / np.sqrt(12), cut.std()])
    y = np.array([[0.5, 0.2], [0.1, 0.8], [0.1, 1.1]])
    log = prior.log_density(y)
    assert log[2] == -np.inf and log[1] - log[0] == pytest.approx(
        cut.logpdf(0.8) - cut.logpdf(0.2)
    )


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"x": (0, 1)}, "prior for x"),
        ({"a": (0, 0)}, "prior for a"),
        ({"a": (np.nan, 1)}, "prior for a"),
    ],
)
def test_bad_priors_are_named(given, message):
    with pytest.raises(ValueError, match=message):
        Prior(Box.of({"a": (0, 1)}), given)
