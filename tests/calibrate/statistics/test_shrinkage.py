"""The surface that stands for piles in the posterior: least squares where effects show,
nearly flat where they do not."""

import numpy as np
import pytest
from scipy import stats

from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.designs import box_behnken
from benchtwin.calibrate.statistics.shrinkage import cubes, shrink
from benchtwin.calibrate.statistics.surface import fit_surface

BOX = Box(("e", "mu", "mu_r"), [0.45, 0.2, 0.01], [0.7, 0.7, 0.06])
EQ8 = np.array([30.0, 0.6, 0.8, 0.8, 0.1, 0.1, 0.35, 0.0, -0.3, -0.3])


def runs(rng, sd, effects=EQ8, bend=0.0):
    design = box_behnken(BOX, centre_points=5)
    z = BOX.coded(BOX.points(design))
    y = (
        polynomial.matrix(z, polynomial.full(3)) @ effects
        + bend * z[:, 1] ** 2 * z[:, 0]
        + sd * rng.standard_normal(len(z))
    )
    return fit_surface(design.assign(angle_deg=y), "angle_deg", BOX)


def test_effects_far_above_the_noise_are_those_of_least_squares():
    plain = runs(np.random.default_rng(0), 0.02)
    found = shrink(plain)
    points = BOX.natural(np.random.default_rng(1).uniform(-0.7, 0.7, (50, 3)))
    np.testing.assert_allclose(
        found.evaluate(points)[0], plain.evaluate(points)[0], atol=0.05
    )
    assert found.terms[:10] == plain.terms and found.noise_df == 16


def test_where_nothing_shows_the_surface_is_nearly_flat():
    corners = BOX.natural(np.array([[1, 1, 1], [-1, -1, -1], [1, -1, 1.0]]))
    nothing = np.r_[30.0, np.zeros(9)]
    own, plain = [], []
    for k in range(30):
        fitted = runs(np.random.default_rng(k), 1.0, nothing)
        own.append(shrink(fitted).evaluate(corners)[0] - 30)
        plain.append(fitted.evaluate(corners)[0] - 30)
    assert np.std(own) < 0.5 * np.std(plain)


@pytest.mark.parametrize("sd", [0.1, 1.0])
def test_prediction_intervals_cover_a_truth_with_a_cubic_part(sd):
    """Also in the corners, which a Box–Behnken design has not."""
    rng, held = np.random.default_rng(2), []
    for k in range(80):
        bend = 0.2 * rng.standard_normal()
        found = shrink(runs(np.random.default_rng(100 + k), sd, bend=bend))
        at = rng.uniform(-1, 1, (10, 3))
        truth = (
            polynomial.matrix(at, polynomial.full(3)) @ EQ8
            + bend * at[:, 1] ** 2 * at[:, 0]
        )
        mean, variance = found.evaluate(BOX.natural(at))
        held.append(
            abs(mean - truth) < stats.t.ppf(0.975, found.df) * np.sqrt(variance)
        )
    assert 0.91 <= np.mean(held) <= 0.995


def test_cubes_are_of_the_factors_that_have_squares():
    wide = (*((*t, 0) for t in polynomial.full(2)), (0, 0, 1))
    assert cubes(wide) == [(3, 0, 0), (2, 1, 0), (1, 2, 0), (0, 3, 0)]
