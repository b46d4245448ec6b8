"""What more minutes of a test would leave: closed forms."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from benchtwin.calibrate.statistics.bench import BenchMean
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.next_test import BenchTest, after_minutes
from benchtwin.calibrate.statistics.posterior import Observable, on_grid
from benchtwin.calibrate.statistics.prior import Prior


class Plane:
    """A surrogate known exactly: slope per coded unit."""

    def __init__(self, box, slope):
        self.box, self.slope, self.df = box, np.asarray(slope, dtype=float), 1e6

    def evaluate(self, natural):
        return self.box.coded(natural) @ self.slope, np.zeros(len(natural))


@pytest.fixture(scope="module")
def posterior():
    """Two independent standard normal parameters."""
    box = Box(("a", "b"), [-8.0, -8.0], [8.0, 8.0])
    prior = Prior(box, {"a": (0.0, 1.0), "b": (0.0, 1.0)})
    rng = np.random.default_rng(0)
    draws = pd.DataFrame(prior.draw(40_000, rng), columns=["a", "b"])
    flat = Observable("y", Plane(box, [1.0, 1.0]), BenchMean(0.0, 1e3, 1e6, 0.0, 9))
    return replace(on_grid([flat], prior, rng=rng), draws=draws)


def test_two_readings_of_one_run_are_taken_together(posterior):
    """Cov' = (1 + n/ρ S Sᵀ)⁻¹ with n runs of 4 in 20 minutes: var a = 1/(1 + 5/4), of
    readings a and b with variances 4 and 1."""
    box = posterior.prior.box
    planes = (Plane(box, [8.0, 0.0]), Plane(box, [0.0, 8.0]))
    test = BenchTest("both", planes, np.diag([4.0, 1.0]), 4.0)
    row = after_minutes(posterior, [test], ["a", "b"], 20.0).iloc[0]
    assert row["runs"] == 5
    assert row["sd_left_a"] == pytest.approx(np.sqrt(1 / (1 + 5 / 4)), rel=0.02)
    assert row["sd_left_b"] == pytest.approx(np.sqrt(1 / (1 + 5)), rel=0.02)


def test_readings_that_err_together_tell_less(posterior):
    """Of two readings of a + b that share their whole error, one counts."""
    plane = Plane(posterior.prior.box, [8.0, 8.0])
    alone = BenchTest("one", (plane,), np.array([[1.0]]), 20.0)
    together = np.array([[1.0, 0.999], [0.999, 1.0]])
    twice = BenchTest("twice", (plane, plane), together, 20.0)
    apart = BenchTest("apart", (plane, plane), np.eye(2), 20.0)
    told = after_minutes(posterior, [alone, twice, apart], ["a", "b"], 20.0)
    left = told.set_index("test")["variance_left"]
    assert left["twice"] == pytest.approx(left["one"], abs=0.003)
    assert left["apart"] < left["one"] - 0.02
    assert told["test"].iloc[0] == "apart"


def test_what_is_not_asked_for_does_not_count(posterior):
    """A quick test of b alone leaves all of a."""
    plane = Plane(posterior.prior.box, [0.0, 8.0])
    test = BenchTest("b", (plane,), np.array([[0.01]]), 1.0)
    told = after_minutes(posterior, [test], ["a"], 20.0)
    assert told["variance_left"][0] == pytest.approx(1.0, abs=0.01)
    assert list(told.columns)[-1] == "sd_left_a"
