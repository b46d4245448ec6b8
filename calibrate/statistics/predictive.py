"""What a system shows whose parameters are uncertain and whose packings scatter:
intervals, and the share of either.

n runs, each with parameters drawn from a posterior and a packing of its own, scatter by
τ² + σ²; m runs at one set of parameters, each on a packing of its own, by σ² alone: a
one-way random-effects layout. With s_n², s_m² the two sample variances,

    (n − 1) s_n²/(τ² + σ²) ~ χ²(n − 1),  (m − 1) s_m²/σ² ~ χ²(m − 1),

prior uniform in τ and log σ (Gelman 2006, Bayesian Analysis 1, 515), on a grid. The
mean of k further packings is then normal about the mean of the n runs with variance τ²
+ σ²/k + (τ² + σ²)/n, averaged over the grid. Assumes that runs scatter normally and
packings alike everywhere."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats
from scipy.optimize import brentq

from benchtwin.bench.language import tr

LEVEL, NORMAL_95 = 0.95, 1.959964
# runs below which a sample variance says next to nothing: with so many its own sd is 82
# and 100 % of it
LEAST_DRAWS, LEAST_PACKINGS = 4, 3
GRID = (120, 80)  # steps of τ and σ
# of the grid's likeliest point: what is less likely moves no interval
LEAST_WEIGHT = 1e-6
REACH = 8.0  # how far both are looked for, in the larger of the sample sds


@dataclass(frozen=True, eq=False)
class Predictive:
    """mean: of the runs at drawn parameters, n of them; tau, sigma, weight: (g,) points
    of the grid and their probability."""

    mean: float
    n: int
    tau: np.ndarray
    sigma: np.ndarray
    weight: np.ndarray

    @property
    def parameter_sd(self) -> float:
        """Median of τ, which no packing scatter is in."""
        return self._median(self.tau)

    @property
    def packing_sd(self) -> float:
        """Median of σ."""
        return self._median(self.sigma)

    def half_width(self, packings: float = 1.0, level: float = LEVEL) -> float:
        """mean ± this holds the mean of so many further packings (np.inf: of all there
        could be) with probability `level`."""
        tau2, sigma2 = self.tau**2, self.sigma**2
        sd = np.sqrt(tau2 + sigma2 / packings + (tau2 + sigma2) / self.n)

        def beyond(half: float) -> float:
            return float(self.weight @ (2 * stats.norm.sf(half / sd))) - (1 - level)

        return float(brentq(beyond, 0.0, 20 * float(sd.max())))

    def _median(self, of: np.ndarray) -> float:
        order = np.argsort(of)
        return float(of[order][np.searchsorted(np.cumsum(self.weight[order]), 0.5)])


def predictive(draws: ArrayLike, repeats: ArrayLike) -> Predictive:
    """draws: (n,) runs at parameters drawn from the posterior; repeats: (m,) runs at
    one set of parameters; every run on a packing of its own.

    Raises ValueError for fewer than LEAST_DRAWS and LEAST_PACKINGS, for what is not
    finite, and without any scatter."""
    y, r = np.asarray(draws, dtype=float), np.asarray(repeats, dtype=float)
    if y.size < LEAST_DRAWS or r.size < LEAST_PACKINGS:
        raise ValueError(
            tr(
                "{} runs at drawn parameters and {} at one set: at least {} and {} are"
                " needed",
                y.size,
                r.size,
                LEAST_DRAWS,
                LEAST_PACKINGS,
            )
        )
    if not (np.isfinite(y).all() and np.isfinite(r).all()):
        raise ValueError(tr("a run's angle is not finite"))
    drawn, packed = float(y.var(ddof=1)), float(r.var(ddof=1))
    if not min(drawn, packed) > 0:
        raise ValueError(
            tr(
                "runs on different packings gave the very same angle: there is no"
                " scatter"
            )
        )
    low, high = np.sqrt(min(drawn, packed)) / REACH, REACH * np.sqrt(max(drawn, packed))
    tau, sigma = np.meshgrid(
        np.linspace(0.0, high, GRID[0]), np.geomspace(low, high, GRID[1]), indexing="ij"
    )
    both = tau**2 + sigma**2
    log_weight = -0.5 * (y.size - 1) * (np.log(both) + drawn / both) - 0.5 * (
        r.size - 1
    ) * (2 * np.log(sigma) + packed / sigma**2)
    weight = np.exp(log_weight - log_weight.max())
    there = weight > LEAST_WEIGHT
    weight = weight[there] / weight[there].sum()
    return Predictive(float(y.mean()), y.size, tau[there], sigma[there], weight)
