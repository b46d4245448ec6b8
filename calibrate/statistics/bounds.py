"""The interval of one factor, and the limits of its range that the posterior does not
exclude.

A prior that ends at a limit cuts the posterior off there, so that quantiles lie inside
the range even where the recordings exclude nothing up to its end. A limit is excluded
when a likelihood-ratio test at 5 % rejects it: where the marginal density is below
exp(−χ²₁(0.95)/2) = 0.15 of its maximum."""

import numpy as np
from scipy import stats

EXCLUDED = float(np.exp(-stats.chi2.ppf(0.95, 1) / 2))  # of the largest density
MOST = 4000  # draws that a density is estimated from
Ends = tuple[float, float]


def open_ends(draws: np.ndarray, limits: Ends) -> frozenset[str]:
    """Limits ("low", "high") that draws (n,) within them do not exclude.

    The density is a kernel estimate with the draws reflected at both limits.
    """
    thinned = draws[:: max(1, len(draws) // MOST)]
    kernel, (low, high) = stats.gaussian_kde(thinned), limits
    x = np.linspace(low, high, 201)
    density = kernel(x) + kernel(2 * low - x) + kernel(2 * high - x)
    reached = density[[0, -1]] > EXCLUDED * density.max()
    return frozenset(end for end, there in zip(("low", "high"), reached) if there)


def interval(
    draws: np.ndarray, searched: Ends, ends: frozenset[str], level: float
) -> Ends:
    """Central interval of draws (n,); one-sided where an end is open, which reaches to
    the end of what was searched: of values beyond the draws' own range nothing is
    known.

    >>> interval(np.linspace(0.5, 0.6, 101), (0.2, 0.7), frozenset({"high"}), 0.95)
    (0.505, 0.7)
    """
    tail = (1 - level) / 2 if not ends else 1 - level
    low, high = (float(v) for v in np.quantile(draws, [tail, 1 - tail]))
    low = searched[0] if "low" in ends else low
    return low, searched[1] if "high" in ends else high
