"""Least-squares lines: exact where they must be, and a standard error that covers
although the roughness is correlated."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from benchtwin.vision.pile.line import fit_line


def rough_line(rng, n=600, slope=0.5, sd=4.0, length=10.0):
    rough = gaussian_filter1d(rng.normal(size=3 * n), length / np.sqrt(2))[n : 2 * n]
    x = np.arange(n, dtype=float)
    return x, slope * x + sd * rough / rough.std()


def test_a_straight_line_comes_out_exactly():
    x = np.arange(50.0)
    line = fit_line(x, 3 - 0.7 * x)
    assert line.slope == pytest.approx(-0.7, abs=1e-12)
    assert line.at(10) == pytest.approx(-4.0)
    assert line.angle_deg == pytest.approx(-np.degrees(np.arctan(0.7)))


def coverage(sd_of, runs=400):
    """Fraction of runs whose 95 % interval, slope ± 1.96 sd, holds the true slope."""
    hits = 0
    for i in range(runs):
        rng = np.random.default_rng([7, i])
        x, y = rough_line(rng, length=rng.uniform(3, 15))
        line = fit_line(x, y)
        hits += abs(line.slope - 0.5) <= 1.96 * sd_of(line, x)
    return hits / runs


def test_the_standard_error_covers_under_correlated_roughness():
    # 400 runs: ± 2.2 % is two standard errors of a coverage of 95 %
    assert 0.90 <= coverage(lambda line, x: line.slope_sd) <= 0.98


def test_the_textbook_standard_error_would_not():
    white = lambda line, x: line.rms / np.sqrt(np.sum((x - x.mean()) ** 2))  # noqa: E731
    assert coverage(white) < 0.6


def test_a_few_points_far_off_are_left_out():
    rng = np.random.default_rng(1)
    x = np.arange(200.0)
    y = 0.3 * x + rng.normal(0, 0.5, 200)
    y[20:30] -= 40
    line = fit_line(x, y)
    assert line.outlier_share == pytest.approx(0.05, abs=0.01)
    assert line.slope == pytest.approx(
        0.3, abs=0.003
    )  # 4 sd of a slope over 200 points of sd 0.5


def test_an_s_shape_is_seen_and_grains_are_not():
    x = np.linspace(-1, 1, 400)
    cubic_share = fit_line(200 * x, 100 * np.tanh(2 * x))
    assert cubic_share.cubic_share > 0.6
    assert (
        np.degrees(np.arctan(cubic_share.slope_high) - np.arctan(cubic_share.slope_low))
        > 20
    )
    shares = [
        fit_line(*rough_line(np.random.default_rng([3, i]))).cubic_share
        for i in range(100)
    ]
    assert np.mean(np.array(shares) > 0.6) <= 0.02


@pytest.mark.parametrize("n", [0, 5, 7])
def test_too_few_points_are_refused(n):
    with pytest.raises(ValueError, match="at least 8 points"):
        fit_line(np.arange(n), np.arange(n))
