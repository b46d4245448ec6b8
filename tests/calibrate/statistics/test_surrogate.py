"""What stands for piles in the posterior: least squares where effects show, nearly flat
where they do not."""

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.designs import box_behnken
from benchtwin.calibrate.statistics.surface import fit_surface
from benchtwin.calibrate.statistics.surrogate import fit_surrogate

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
    return design.assign(angle_deg=y)


def test_effects_far_above_the_noise_are_those_of_least_squares():
    table = runs(np.random.default_rng(0), 0.02)
    found = fit_surrogate(table, "angle_deg", BOX)
    plain = fit_surface(table, "angle_deg", BOX)
    points = np.random.default_rng(1).uniform(-0.7, 0.7, (50, 3))
    np.testing.assert_allclose(
        found.evaluate(BOX.natural(points))[0], plain.mean(points), atol=0.05
    )
    assert found.terms[:10] == plain.terms and found.noise_df == 16


def test_where_nothing_shows_the_surface_is_nearly_flat():
    corners = np.array([[1, 1, 1], [-1, -1, -1], [1, -1, 1.0]])
    nothing = np.r_[30.0, np.zeros(9)]
    own, plain = [], []
    for k in range(30):
        table = runs(np.random.default_rng(k), 1.0, nothing)
        found = fit_surrogate(table, "angle_deg", BOX)
        own.append(found.evaluate(BOX.natural(corners))[0] - 30)
        plain.append(fit_surface(table, "angle_deg", BOX).mean(corners) - 30)
    assert np.std(own) < 0.5 * np.std(plain)


@pytest.mark.parametrize("sd", [0.1, 1.0])
def test_prediction_intervals_cover_a_truth_with_a_cubic_part(sd):
    """Also in the corners, which a Box–Behnken design has not; and they are no wider
    for it than those of a single run."""
    rng, held, sds = np.random.default_rng(2), [], []
    for k in range(80):
        bend = 0.2 * rng.standard_normal()
        table = runs(np.random.default_rng(100 + k), sd, bend=bend)
        found = fit_surrogate(table, "angle_deg", BOX)
        at = rng.uniform(-1, 1, (10, 3))
        truth = (
            polynomial.matrix(at, polynomial.full(3)) @ EQ8
            + bend * at[:, 1] ** 2 * at[:, 0]
        )
        mean, variance = found.evaluate(BOX.natural(at))
        held.append(
            abs(mean - truth) < stats.t.ppf(0.975, found.df) * np.sqrt(variance)
        )
        sds.append(np.sqrt(variance).mean())
    assert np.mean(held) >= 0.91 and np.mean(sds) < 1.1 * sd


def test_effects_of_thousands_of_standard_deviations_are_not_shrunk():
    """A slide's onset scatters by hundredths of a degree and moves by degrees."""
    x = np.repeat(np.linspace(0.27, 0.45, 5), 4)
    rng = np.random.default_rng(3)
    y = np.degrees(np.arctan(x)) + 0.002 * rng.standard_normal(20)
    table = pd.DataFrame({"mu": x, "angle_deg": y})
    found = fit_surrogate(table, "angle_deg", Box.of({"mu": (0.27, 0.45)}))
    at = np.linspace(0.27, 0.45, 50)
    off = found.evaluate(at[:, None])[0] - np.degrees(np.arctan(at))
    assert abs(off).max() < 0.005 and 0.001 < found.noise_sd < 0.004


def test_cubes_are_of_the_factors_that_are_curved():
    wide = Box(("a", "b", "c"), [0, 0, 0], [1, 1, 1])
    rng = np.random.default_rng(0)
    table = pd.DataFrame(rng.random((30, 3)), columns=["a", "b", "c"])
    found = fit_surrogate(table.assign(y=table["a"]), "y", wide, curved=2)
    cubes = [t for t in found.terms if sum(t) == 3]
    assert cubes == [(3, 0, 0), (2, 1, 0), (1, 2, 0), (0, 3, 0)]
    assert [t for t in found.terms if t[2]] == [(0, 0, 1)]


@pytest.mark.parametrize(("n", "value"), [(3, 1.0), (20, 5.0)])
def test_runs_that_show_nothing_are_refused(n, value):
    table = pd.DataFrame({"a": np.linspace(0, 1, n), "y": [value] * n})
    with pytest.raises(ValueError, match=f"y: {n} runs"):
        fit_surrogate(table, "y", Box.of({"a": (0.0, 1.0)}))
