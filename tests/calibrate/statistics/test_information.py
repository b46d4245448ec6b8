"""Which simulation comes next: what a run is said to tell is what it does tell, and no
run is chosen for what another tells."""

from types import SimpleNamespace

import numpy as np
import pytest

from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.bench import BenchMean
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.information import most_informative, weighted
from benchtwin.calibrate.statistics.posterior import Observable, on_grid
from benchtwin.calibrate.statistics.prior import Prior

BOX = Box(("a", "b"), [0.0, 0.0], [1.0, 1.0])
TERMS = ((0, 0), (1, 0), (0, 1))


def surface(coded: np.ndarray, noise_sd: float = 0.5):
    """Least squares through runs at coded points: covariance σ² (XᵀX)⁻¹."""
    x = polynomial.matrix(coded, TERMS)
    covariance = noise_sd**2 * np.linalg.inv(x.T @ x)
    return SimpleNamespace(
        box=BOX, terms=TERMS, covariance=covariance, noise_sd=noise_sd
    )


CROWDED = np.array(
    [[-1, -1], [-1, -0.9], [-0.9, -1.0], [-1, 1.0]]
)  # little is known of a


def test_the_run_that_is_chosen_lowers_the_variance_most_of_all():
    rng = np.random.default_rng(0)
    candidates, draws = rng.uniform(0, 1, (30, 2)), rng.uniform(0, 1, (200, 2))
    x, f = (
        polynomial.matrix(BOX.coded(CROWDED), TERMS),
        polynomial.matrix(BOX.coded(draws), TERMS),
    )
    start = surface(BOX.coded(CROWDED))

    def after(point):
        row = polynomial.matrix(BOX.coded([point]), TERMS)
        v = 0.25 * np.linalg.inv(np.vstack([x, row]).T @ np.vstack([x, row]))
        return np.log(0.04 + np.sum(f @ v * f, axis=1)).mean()

    chosen = most_informative(candidates, draws, [(start, 0.2)], BOX.names, 1)[0]
    best = min(candidates, key=after)
    np.testing.assert_array_equal(chosen, best)
    assert (
        after(chosen) < after(np.array([0.0, 0.0])) - 0.1
    )  # control: another run where runs are tells less


def test_the_second_run_counts_what_the_first_will_tell():
    corners = np.array([[1.0, 0.0], [1.0, 0.02], [0.0, 1.0], [0.0, 0.98]])
    few = surface(
        np.array([[-1, -1], [-0.9, -1.0], [-1, -0.9]]), noise_sd=0.05
    )  # of a as little is known as of b
    draws = np.random.default_rng(1).uniform(0, 1, (200, 2))
    first, second = most_informative(corners, draws, [(few, 0.2)], BOX.names, 2)
    assert {int(first[0]), int(second[0])} == {
        0,
        1,
    }  # one for each, not the same corner twice


def test_importance_sampling_gives_the_grids_posterior():
    class Line:
        box, df = BOX, 40

        def evaluate(self, natural):
            return np.asarray(natural) @ [1.0, 2.0], np.full(len(natural), 0.02**2)

    seen = [
        Observable(
            "angle",
            Line(),
            BenchMean(1.5, scatter_sd=0.1, df=20.0, shared_sd=0.0, n=21),
        )
    ]
    rng, prior = np.random.default_rng(2), Prior.uniform(BOX)
    found = weighted(seen, prior, None, rng)
    grid = on_grid(seen, prior, rng=rng, cells=201, draws=20_000).draws
    np.testing.assert_allclose(
        found.weights @ found.points, grid.mean(), atol=0.01
    )  # 20,000 draws: ± 0.002
    np.testing.assert_allclose(found.sd, grid.std(), rtol=0.04)
    assert found.draw(50, rng).shape == (
        50,
        2,
    ) and found.weights.sum() == pytest.approx(1)
