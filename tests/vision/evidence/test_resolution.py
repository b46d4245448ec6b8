"""The grid on which readings lie, and what it leaves open of their mean."""

import numpy as np
import pytest

from benchtwin.bench.resolution import reading_step
from benchtwin.vision.evidence.readings import summarise


@pytest.mark.parametrize(
    "values, grid",
    [
        ([21.5, 22.0, 22.5, 23.0], 0.5),
        ([21.5, 22.1, 21.9], 0.1),
        ([20.0, 25.0, 30.0], 5.0),
        ([21.0, 21.0], 1.0),
        ([21.37, 22.11], 0.0),
        ([], 0.0),
    ],
)
def test_grids(values, grid):
    assert reading_step(np.array(values)) == grid


@pytest.mark.parametrize(
    "scatter, grid", [(0.02, 0.5), (0.1, 0.5), (0.3, 0.5), (0.15, 0.1)]
)
def test_means_of_rounded_readings_hold_the_truth(scatter, grid):
    """Six readings that scatter by less than their grid are mostly equal: their scatter
    says that they are exact."""
    rng, inside = np.random.default_rng(1), []
    for _ in range(400):
        truth = rng.uniform(18, 26)
        s = summarise(np.round(rng.normal(truth, scatter, 6) / grid) * grid)
        inside.append(abs(s.mean - truth) < 1.96 * np.hypot(s.sd_mean, s.sd_rounding))
    assert (
        np.mean(inside) > 0.92
    )  # 0.95 but for 0.011 by chance; a uniform error's 1.96 sd hold all of it
