"""Held-out figures: what share of what the baseline misses is removed, and when there is no such share."""

import math

import numpy as np
import pytest

from calibrate.diagnose.effects.effect import Effect
from calibrate.diagnose.finding import parameters_of
from calibrate.diagnose.linear import Reduced
from calibrate.diagnose.name import candidate
from calibrate.diagnose.noise import Noise
from calibrate.diagnose.problem import Problem, fit
from calibrate.diagnose.scores import HeldOut, explained, held_out, ln_evidence, unbound
from calibrate.diagnose.series import Locals, Series, problem_of


def test_removed_fraction():
    assert HeldOut.of(300.0, 120.0, 100.0).removed_fraction == pytest.approx(0.9)
    assert HeldOut.of(400.0, 100.0, 100.0).rmse_ratio == pytest.approx(0.5)
    assert HeldOut.of(300.0, 80.0, 100.0).removed_fraction > 1  # not held down: a fit below the noise is seen as such


@pytest.mark.parametrize("noise", [100.0, 100.0000001, 130.0])
def test_a_baseline_that_misses_nothing_has_no_share_to_remove(noise):
    assert math.isnan(HeldOut.of(100.0, 99.0, noise).removed_fraction)


def test_what_noise_misses_by_chance_has_no_share_to_remove():
    assert math.isnan(HeldOut.of(119.0, 99.0, 100.0, 10.0).removed_fraction)
    assert HeldOut.of(121.0, 100.0, 100.0, 10.0).removed_fraction == pytest.approx(1.0)


def session(rng: np.random.Generator, *, size: float, noise: float, common: bool):
    """Six recordings of 120 rows: a nuisance, effects "true" (put in with `size`) and "other"; noise of that sd, taken for 1, and
    in four directions that all columns share less than that, as where recordings scatter by less than was thought."""
    effects = {n: Effect(n, "flight", "1", n, 3.0, -9.0, 9.0, "drawn") for n in ("true", "other")}
    names = (*effects, "nuisance")
    shapes = np.linalg.qr(rng.normal(size=(120, 8)))[0] * 10
    quiet = np.linalg.qr(shapes)[0][:, :4]
    made = []
    for _ in range(6):
        a = shapes[:, :3] * rng.uniform(0.7, 1.3, 3)
        errors = noise * rng.normal(size=120)
        errors -= 0.5 * quiet @ (quiet.T @ errors)
        made.append(Reduced(a, shapes[:, 3:7], a @ [size, 0.0, 0.3] + errors))
    reduced = tuple(made)
    return Problem(
        "pile", tuple("abcdef"), effects, names, {"nuisance": 1.0}, np.zeros((6, 0)),
        lambda starts, values, extra=None: (reduced, lambda moved: np.zeros((6, 0))), 720, 0.1, None, common_smooth=common,
    )  # fmt: skip


@pytest.mark.parametrize("common", [True, False])
@pytest.mark.parametrize("noise", [1.0, 0.6])
def test_the_share_is_one_for_what_is_there_and_none_for_what_is_not(common, noise):
    """Mean over sessions, the noise as it was taken for, or less than that (then a floor of one a column is too high)."""
    shares = {"true": [], "other": []}
    for seed in range(60):
        problem = session(np.random.default_rng([41, seed]), size=0.8, noise=noise, common=common)
        base = fit(problem)
        for name, found in shares.items():
            found.append(held_out(fit(problem, free=(name,), start=base), base, (name,)).removed_fraction)
    assert np.mean(shares["true"]) == pytest.approx(1.0, abs=0.06)
    assert np.mean(shares["other"]) == pytest.approx(0.0, abs=0.06)


def test_a_strained_prior_is_no_sign_that_something_else_is_left():
    """An effect 30 sd out in its prior, and curves that can do its work: they gain what the prior takes, nothing without it."""
    rng = np.random.default_rng(3)
    shape, effect = rng.normal(size=(40, 2)), Effect("far", "flight", "1", "far", 1.0, -99.0, 99.0, "drawn")
    made = tuple(Reduced(shape[:, :1], shape, 30.0 * shape[:, 0] + rng.normal(size=40)) for _ in range(3))
    problem = Problem(
        "pile", tuple("abc"), {"far": effect}, ("far",), {}, np.zeros((3, 0)),
        lambda starts, values, extra=None: (made, lambda moved: np.zeros((3, 0))), 120, 0.1, None, common_smooth=True,
    )  # fmt: skip
    found = fit(problem, free=("far",), start=fit(problem))
    strained, freed = (explained(f, (), smooth=True)[0] for f in (found, unbound(found, ("far",))))
    assert strained > 50 and freed < 9  # χ² of one direction more: 9 is 3 sd


@pytest.mark.parametrize(("told", "evidence"), [(True, 0.0), (False, 10.0)])
def test_no_evidence_exceeds_the_ratio_of_likelihoods(told, evidence):
    """About a kink the slope promises a fall of χ² that no value gives; as a control the same where χ² itself is not told."""
    effect = Effect("kinked", "flight", "1", "kinked", 1.0, -99.0, 99.0, "drawn")

    def reduce(starts, values, extra=None):
        cost = 9.0 + 20.0 * abs(values[0]) if told else None  # least at nil, where its slopes are steep
        made = tuple(Reduced(np.ones((1, 1)), np.zeros((1, 0)), np.array([3.0]), cost) for _ in range(3))
        return made, lambda moved: np.zeros((3, 0))

    names = ("kinked",)
    problem = Problem("pile", tuple("abc"), {"kinked": effect}, names, {}, np.zeros((3, 0)), reduce, 120, 0.1, None)
    found = candidate(fit(problem), names, np.random.default_rng(0))
    assert found.ln_bayes == pytest.approx(evidence, abs=1.0)


def test_an_exponent_that_is_known_to_a_hair_has_a_range():
    """χ² that falls by a million: no point of a coarse grid but the best itself is near enough."""
    from calibrate.diagnose.law import _range

    powers = np.array([-1.0, 0.0, 0.7, 2.0])
    low, high = _range(powers, np.array([0.0, 2e5, 1e6, 3e5]), 2)
    assert low <= 0.7 <= high and high - low < 0.01


def test_a_law_is_one_for_all_sessions_also_where_a_recording_says_nothing():
    from calibrate.diagnose.law import _common

    full = np.array([[1.0, 2.0, 3.0, 0.0, 0.0], [1.0, 0.0, 0.0, 4.0, 5.0]])  # one of the globals, two powers in two sessions
    np.testing.assert_array_equal(_common(Reduced(full, full[:, :0], np.ones(2)), 1, 2).a, [[1.0, 2.0, 3.0], [1.0, 4.0, 5.0]])
    assert _common(Reduced(full[:0], full[:0, :0], np.ones(0)), 1, 2).a.shape == (0, 3)


def test_what_is_a_recordings_own_pays_for_the_room_it_takes():
    """A chance of sd 1 that shows only where an effect is: the evidence is that of y = level + value·chance·shape + noise."""
    rng = np.random.default_rng(5)
    shape, y = rng.normal(size=30), rng.normal(size=30)
    effect = Effect("shaken", "sliding", "1", "size", 1.0, 0.0, 9.0, "drawn")
    series = Series("a", y, 1.0, np.full(30, np.inf), Noise(0.0, 0.0, 0.1), np.zeros((30, 0)))
    own = Locals(np.zeros((1, 2)), np.full(2, 1e-3), np.array([np.inf, 1.0]))
    problem = problem_of(
        "slide", (series,), own, lambda r, o, values: o[0] + values["shaken"] * o[1] * shape, {"shaken": effect}, {}, {}, None
    )

    def exact(value: float) -> float:
        """Of the differences from the mean: the level is free."""
        basis = np.linalg.qr(np.column_stack([np.ones(30), rng.normal(size=(30, 29))]))[0][:, 1:].T
        covariance = np.eye(29) + value**2 * np.outer(basis @ shape, basis @ shape)
        left = basis @ y
        return -0.5 * (left @ np.linalg.solve(covariance, left) + np.linalg.slogdet(covariance)[1])

    def told(value: float) -> float:
        return ln_evidence(problem.reduce(problem.starts, np.array([value]))[0], np.zeros(1))

    assert told(2.0) - told(0.0) == pytest.approx(exact(2.0) - exact(0.0), abs=1e-6)


@pytest.mark.parametrize(("seen_by", "predicts"), [(4, True), (1, False)])
def test_what_bends_something_known_is_predicted_by_the_others(seen_by, predicts):
    """An effect just like something that is known to a fifth of it. Once three recordings have bent that, the fourth follows
    without the effect; but none had to bend before. As a control only one recording has it."""
    rng = np.random.default_rng(8)
    shape = rng.normal(size=40)
    effect = Effect("level", "flight", "1", "level", 3.0, -99.0, 99.0, "drawn")
    seen = [1.0 if r < seen_by else 0.0 for r in range(4)]
    made = tuple(Reduced(np.column_stack([shape, shape]), np.zeros((40, 0)), x * shape + rng.normal(size=40)) for x in seen)
    problem = Problem(
        "pile", tuple("abcd"), {"level": effect}, ("level", "known"), {"known": 0.2}, np.zeros((4, 0)),
        lambda starts, values, extra=None: (made, lambda moved: np.zeros((4, 0))), 160, 0.1, None,
    )  # fmt: skip
    found = candidate(fit(problem), ("level",), np.random.default_rng(0))
    assert any("left-out" in flaw for flaw in found.flaws) != predicts


@pytest.mark.parametrize(("open_anyway", "least"), [(0.2, 0.92), (0.0, 0.0)])
def test_an_interval_holds_the_effect_beside_what_a_bench_leaves_open_of_it(open_anyway, least):
    """Levels of 1 ± 0.2, of which the plumb line makes the 0.2. As a control a bench that claims to leave nothing open."""
    rng, held = np.random.default_rng(12), []
    shape = rng.normal(size=40)
    effect = Effect("level", "flight", "1", "level", 3.0, -99.0, 99.0, "drawn")
    for _ in range(200):
        seen = 1.0 + 0.2 * rng.normal()
        made = tuple(Reduced(shape[:, None], np.zeros((40, 0)), seen * shape + 0.1 * rng.normal(size=40)) for _ in range(4))
        problem = Problem(
            "pile", tuple("abcd"), {"level": effect}, ("level",), {"level": open_anyway}, np.zeros((4, 0)),
            lambda starts, values, extra=None, made=made: (made, lambda moved: np.zeros((4, 0))), 160, 0.1, None,
        )  # fmt: skip
        told = parameters_of(fit(problem, free=("level",), start=fit(problem)), ("level",))["level"]
        held.append(told.low95 <= 1.0 <= told.high95)
    assert least <= np.mean(held) <= (0.995 if open_anyway else 0.8)
