"""The fit of any problem, on one that bends: a valley."""

from dataclasses import replace

import numpy as np
import pytest

from benchtwin.infer.effect import Effect
from benchtwin.infer.least_squares import FastChi2
from benchtwin.infer.linear import Reduced
from benchtwin.infer.noise import Noise
from benchtwin.infer.problem import Problem, fit
from benchtwin.infer.series import Locals, Series, problem_of


def valley(turns: int, seen: list | None = None, bent: float = 2.0) -> Problem:
    """Rosenbrock's: χ² = (bent (y − x²))² + (3 − x)²; beside it a half_ln_det, which no
    χ² holds."""

    def reduce(starts, values, extra=None):
        x, y = values
        a = np.array([[2 * bent * x, -bent], [1.0, 0.0]])
        left = np.array([bent * (y - x**2), 3.0 - x])
        if seen is not None:
            seen.append(tuple(values))
        return (
            Reduced(a, np.zeros((2, 0)), left + a @ values, half_ln_det=5.0),
        ), lambda moved: np.zeros((1, 0))

    return Problem(
        "valley",
        ("one",),
        {},
        ("x", "y"),
        {"x": 1e3, "y": 1e3},
        np.zeros((1, 0)),
        reduce,
        2,
        0.0,
        None,
        turns,
    )


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_chi2_after_a_refused_step_is_that_of_the_returned_values(turns):
    """Not what a step further promises, nil; nor with the half_ln_det."""
    found = fit(valley(turns))
    x, y = found.values
    assert found.chi2 == pytest.approx(
        (2 * (y - x**2)) ** 2 + (3 - x) ** 2 + (x**2 + y**2) / 1e6
    )
    assert found.chi2 <= 9.0


def test_fit_converges_to_the_minimum():
    """Of a plane in the first turn after the step, whatever the priors' sizes; of a
    valley only at its end."""
    seen: list = []
    assert (
        fit(valley(20, seen, bent=0.0)).values[0] == pytest.approx(3.0)
        and len(seen) == 2
    )
    assert fit(valley(60)).values == pytest.approx([3.0, 9.0], rel=1e-2)


def test_repeated_fits_are_cached():
    """The same from the same start is the same fit; of another problem with the same
    space, only where it begins is known."""
    seen: list = []
    problem = valley(20, seen, bent=0.0)
    base = fit(problem)
    again = fit(problem, start=base)
    assert len(seen) == 3 and fit(problem, start=base) is again and len(seen) == 3
    held = fit(replace(problem, known_sd={"x": 1.0, "y": 1e3}), start=base)
    assert held.values[0] == pytest.approx(1.5) and seen[3:] == [tuple(held.values)]


@pytest.mark.parametrize("shows", ["wind", "wind.gusts"])
def test_strong_effects_are_not_shrunk_by_the_prior(shows):
    """Eight sds out it costs ln 2 + 8, not 32, and stands .7 of their sds from where
    the rows put it, 2.4 with a normal's tail; within two sds the prior is the normal
    that is stated. So do the further parameters of its group."""
    names = ("wind", "wind.gusts")
    effects = {
        n: Effect(
            n,
            "flight",
            "1",
            "",
            0.3,
            -3.0,
            3.0,
            "",
            group="" if n == "wind" else "wind",
        )
        for n in names
    }

    def shown(value: float):
        a = 10.0 * np.array([[n == shows for n in names]])

        def reduce(starts, values, extra=None):
            return (
                Reduced(a, np.zeros((1, 0)), np.array([10.0 * value])),
            ), lambda moved: np.zeros((1, 0))

        problem = Problem(
            "line", ("one",), effects, names, {}, np.zeros((1, 0)), reduce, 1, 0.0, None
        )
        return fit(problem, free=("wind",), start=fit(problem))

    strong, weak = shown(2.4), shown(0.3)
    assert strong.by_name[shows] == pytest.approx(2.4, abs=0.8 * strong.sd(shows))
    shrunk = 100.0 / (100.0 + 0.3**-2)  # of the normal prior
    assert weak.by_name[shows] == pytest.approx(0.3 * shrunk)
    a, b = strong.reduced[0].a * strong.prior_sd, strong.reduced[0].b
    information = a.T @ a + np.eye(2)
    least = float(b @ b - b @ a @ np.linalg.solve(information, a.T @ b))
    tail = -0.5 * (least + np.linalg.slogdet(information)[1]) + 0.5 * np.log1p(
        100.0 * 0.3**2
    )
    assert tail == pytest.approx(-np.log(2.0) - 8.0, abs=1.0)


def test_marquardt_steps_follow_a_curved_valley():
    """By Marquardt's steps, in as many turns as leave it at the valley's head by halved
    ones."""

    def cost(starts, values):
        return (10.0 * (values[1] - values[0] ** 2)) ** 2 + (3.0 - values[0]) ** 2

    halved = valley(30, bent=10.0)
    assert fit(halved).chi2 > 5.0
    fast = FastChi2(cost, lambda starts, values, wanted: halved.reduce(starts, values))
    assert fit(replace(halved, fast_chi2=fast)).chi2 < 0.1


def test_fit_about_a_kink_returns_the_best_point():
    """Every step promises what it does not keep, and each χ² is within what is
    tolerated of the one before."""
    seen: list = []

    def reduce(starts, values, extra=None):
        seen.append(values[0])
        cost = 8.0 if len(seen) == 3 else 8.5
        return (
            Reduced(np.ones((1, 1)), np.zeros((1, 0)), values + 1.0, cost),
        ), lambda moved: np.zeros((1, 0))

    problem = Problem(
        "kink",
        ("one",),
        {},
        ("x",),
        {"x": 1e3},
        np.zeros((1, 0)),
        reduce,
        2,
        0.0,
        None,
        40,
    )
    found = fit(problem)
    assert found.chi2 == pytest.approx(8.0, abs=1e-4) and found.values[0] == seen[2]
    assert len(seen) < 15  # nor does it go on for ever


def test_locals_settle_where_one_multiplies_a_global():
    """y = (a + c s)(1 + g s) + d s²: c g is in neither's derivative, so that a step
    along the valley a g + c leaves it, where d does not follow. c is 0 ± 0.05, and the
    fit begins where it is a/2. Derivatives that are known give the same."""
    s, white = np.linspace(0, 1, 50), Noise(0.0, 0.0, 0.1)
    lag = np.r_[np.inf, np.ones(49)]

    def predict(r, own, values):
        a, c, d = own
        return (a + c * s) * (1 + values["g"] * s) + d * s**2

    size = np.array([1.0, 2.0, 3.0])
    rows = [predict(0, [a, 0.0, 0.3], {"g": 0.5}) for a in size]
    own = Locals(np.zeros((3, 3)), np.full(3, 1e-6), np.array([1e3, 0.05, 1e3]))
    begun = np.column_stack([size, size / 2, np.full(3, 0.3)])
    for known in ({}, {2: s**2}):
        series = tuple(
            Series("one", y, 1e-5, lag, white, np.zeros((50, 0)), known) for y in rows
        )
        problem = problem_of(
            "product",
            series,
            own,
            predict,
            {},
            {"g": 1.0},
            {"g": 1.0},
            None,
            max_iterations=5,
            smooth=True,
        )
        found = fit(replace(problem, starts=begun))
        assert found.values[0] == pytest.approx(0.5, abs=0.02)
