"""Which limits of its range a posterior excludes, and the interval that follows."""

import numpy as np
import pytest
from scipy import stats

from benchtwin.calibrate.statistics.bounds import interval, open_ends

LIMITS = (0.2, 0.7)
# of a kernel estimate that is good to some percent: draws of a usual calibration
N = 4000


def cut_off(mean: float, sd: float) -> np.ndarray:
    """A normal posterior within LIMITS."""
    ends = [(limit - mean) / sd for limit in LIMITS]
    return stats.truncnorm(*ends, mean, sd).rvs(N, random_state=1)


@pytest.mark.parametrize(
    ("mean", "sd", "ends"),
    [
        (0.45, 0.04, set()),  # well inside: the control
        (0.64, 0.02, set()),  # near the limit, but three sds from it
        (0.65, 0.05, {"high"}),  # one sd from it
        (0.25, 0.05, {"low"}),
        (0.9, 0.1, {"high"}),  # the mode lies beyond what was simulated
        (0.45, 2.0, {"low", "high"}),  # nothing is told
    ],
)
def test_a_limit_is_open_where_the_posterior_does_not_exclude_it(mean, sd, ends):
    assert open_ends(cut_off(mean, sd), LIMITS) == ends


def test_the_density_and_not_a_share_of_the_range_decides():
    """1.96 sds from the mode a likelihood-ratio test at 5 % changes sides; 1.6 and 2.4
    are clear of the kernel's error."""
    for sd in (0.003, 0.03):
        assert open_ends(cut_off(0.7 - 1.6 * sd, sd), LIMITS) == {"high"}
        assert open_ends(cut_off(0.7 - 2.4 * sd, sd), LIMITS) == set()


def test_an_open_end_makes_the_interval_one_sided_and_reaches_to_what_was_searched():
    draws = cut_off(0.65, 0.05)
    low, high = interval(draws, (0.1, 0.9), frozenset({"high"}), 0.95)
    assert high == 0.9 and np.mean(draws > low) == pytest.approx(0.95, abs=1e-3)
    inside = interval(draws, (0.1, 0.9), frozenset(), 0.95)
    assert np.mean(draws < inside[0]) == pytest.approx(
        np.mean(draws > inside[1]), abs=1e-3
    )
