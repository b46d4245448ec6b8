"""What a further test would leave: closed forms, and what measuring then leaves."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from benchtwin.calibrate.statistics.bench import BenchMean
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.next_test import BenchTest, what_next
from benchtwin.calibrate.statistics.posterior import Observable, on_grid
from benchtwin.calibrate.statistics.prior import Prior


class Plane:
    """A surrogate known exactly: slope per coded unit."""

    def __init__(self, box, slope):
        self.box, self.slope, self.df = box, np.asarray(slope, dtype=float), 1e6

    def evaluate(self, natural):
        return self.box.coded(natural) @ self.slope, np.zeros(len(natural))


def known(value, sd):
    return BenchMean(value, sd, 1e6, 0.0, 100)


@pytest.fixture(scope="module")
def posterior():
    """Two independent standard normal parameters."""
    box = Box(("a", "b"), [-8.0, -8.0], [8.0, 8.0])
    prior = Prior(box, {"a": (0.0, 1.0), "b": (0.0, 1.0)})
    rng = np.random.default_rng(0)
    draws = pd.DataFrame(prior.draw(40_000, rng), columns=["a", "b"])
    flat = Observable("y", Plane(box, [1.0, 1.0]), known(0.0, 1e3))
    return replace(on_grid([flat], prior, rng=rng), draws=draws)


def a_test(posterior, name: str, *slopes, noise=1.0) -> BenchTest:
    """A test of planes; noise: variance of each, or their covariance."""
    planes = tuple(Plane(posterior.prior.box, slope) for slope in slopes)
    covariance = noise * np.eye(len(slopes)) if np.ndim(noise) == 0 else noise
    return BenchTest(name, planes, covariance, 1, 4.0)


def test_one_reading_leaves_what_the_closed_form_says(posterior):
    """Variance left (D − D s sᵀ D/(sᵀDs + r²)); here D = 1."""
    tests = [a_test(posterior, "both", [8.0, 8.0]), a_test(posterior, "a", [8.0, 0.0])]
    table = what_next(posterior, tests, ["a", "b"]).set_index("test")
    assert table.loc["both", "variance_left"] == pytest.approx(2 / 3, rel=0.02)
    assert table.loc["a", "sd_left_a"] == pytest.approx(np.sqrt(0.5), rel=0.02)
    assert table.loc["a", "sd_left_b"] == pytest.approx(1, rel=0.01)
    # (1 + s sᵀ + t tᵀ)⁻¹ = [[3, 1], [1, 2]]⁻¹, trace 1, of 2
    assert table.loc["both", "pick"] == 1 and table.loc["a", "pick"] == 2
    assert table.loc["a", "variance_left_after"] == pytest.approx(0.5, rel=0.02)


def test_two_readings_of_one_run_are_taken_together(posterior):
    """Cov' = (1 + S R⁻¹ Sᵀ)⁻¹: var a = 1/(1 + 1/0.8), of readings a and b with the
    variances 0.8 and 0.2."""
    both = a_test(posterior, "both", [8.0, 0.0], [0.0, 8.0], noise=np.diag([0.8, 0.2]))
    row = what_next(posterior, [both], ["a", "b"]).iloc[0]
    assert row["sd_left_a"] == pytest.approx(np.sqrt(1 / (1 + 5 / 4)), rel=0.02)
    assert row["sd_left_b"] == pytest.approx(np.sqrt(1 / (1 + 5)), rel=0.02)


def test_readings_that_err_together_tell_less(posterior):
    """Of two readings of a + b that share their whole error, one counts."""
    plane, together = [8.0, 0.0], np.array([[1.0, 0.999], [0.999, 1.0]])
    alone = a_test(posterior, "one", plane)
    twice = a_test(posterior, "twice", plane, plane, noise=together)
    apart = a_test(posterior, "apart", plane, plane)
    told = what_next(posterior, [alone, twice, apart], ["a", "b"])
    left = told.set_index("test")["variance_left"]
    assert left["twice"] == pytest.approx(left["one"], abs=0.003)
    assert left["apart"] < left["one"] - 0.02
    assert told["test"].iloc[0] == "apart"


def test_what_is_not_asked_for_does_not_count(posterior):
    """A good test of b alone leaves all of a."""
    told = what_next(posterior, [a_test(posterior, "b", [0.0, 8.0], noise=0.01)], ["a"])
    assert told["variance_left"][0] == pytest.approx(1.0, abs=0.01)
    assert [c for c in told if c.startswith("sd_left")] == ["sd_left_a"]


def test_it_foretells_what_measuring_then_leaves(surrogate):
    """Mean posterior variance over 40 imagined measurements, against the table."""
    rng, prior = np.random.default_rng(0), Prior.uniform(surrogate.box)
    angle = Observable("angle", surrogate, BenchMean(31.0, 0.3, 4, 0.1, 5))
    before = on_grid([angle], prior, rng=rng, draws=8000)
    second = Plane(surrogate.box, [1.0, -0.7, 0.2])
    test = BenchTest("second", (second,), np.array([[0.04]]), 1, 0.0)
    told = what_next(before, [test], surrogate.box.names)["variance_left"][0]
    left = []
    for at in before.draws.sample(40, random_state=1).to_numpy():
        value = float(second.evaluate(at[None])[0][0] + 0.2 * rng.standard_normal())
        both = [angle, Observable("second", second, known(value, 0.2))]
        after = on_grid(both, prior, rng=rng, cells=21, draws=2000)
        left.append((after.draws.var() / prior.sd**2).sum())
    foretold = np.mean(left) / (before.draws.var() / prior.sd**2).sum()
    assert foretold == pytest.approx(told, rel=0.12)


def test_a_test_of_what_the_posterior_has_not_is_refused(posterior):
    other = Plane(Box(("c",), [0.0], [1.0]), [1.0])
    with pytest.raises(ValueError, match="depends on c"):
        what_next(posterior, [BenchTest("c", (other,), np.eye(1), 1, 1.0)], ["a"])
