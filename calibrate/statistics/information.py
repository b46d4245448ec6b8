"""What one more simulation is expected to tell of the parameters, before it is run.

For observables with linear surrogates f̂(θ) = x(θ)ᵀβ, covariance V of the coefficients
and scatter σ of one run, a run at c takes

    d(θ) = (x(θ)ᵀ V x(c))² / (σ² + x(c)ᵀ V x(c))

from the variance of f̂(θ). Of the variance with which the bench's mean is compared
there, s_bench² + x(θ)ᵀ V x(θ), it leaves the rest, and the expected information is the
mean over the posterior of −½ log of that share, added up over the observables. Source:
MacKay (1992), Neural Comput. 4, 590–604."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.posterior import Observable, log_posterior
from benchtwin.calibrate.statistics.prior import Prior
from benchtwin.calibrate.statistics.surrogate import Surrogate

# draws at first and at most (a second's work), and effective ones that are enough: sds
# on 200 are good to 5 %
POINTS, MOST_POINTS, LEAST_EFFECTIVE = 20_000, 500_000, 200


@dataclass(frozen=True, eq=False)
class Weighted:
    """The posterior as weighted draws from the prior: points (n, k) in natural units,
    weights (n,) that add up to 1."""

    prior: Prior
    points: np.ndarray
    weights: np.ndarray

    @property
    def sd(self) -> np.ndarray:
        """(k,) standard deviations, natural units."""
        mean = self.weights @ self.points
        return np.sqrt(self.weights @ (self.points - mean) ** 2)

    def draw(self, n: int, rng: np.random.Generator) -> np.ndarray:
        """n points (n, k) of equal weight."""
        return self.points[rng.choice(len(self.points), n, p=self.weights)]


def weighted(
    observables: Sequence[Observable],
    prior: Prior,
    correlation: np.ndarray | None,
    rng: np.random.Generator,
) -> Weighted:
    """The posterior by importance sampling: quicker than a chain where it is not much
    narrower than the prior. Draws more, up to MOST_POINTS, until LEAST_EFFECTIVE of
    them count."""
    points, log_weight = np.empty((0, len(prior.box.names))), np.empty(0)
    while True:
        new = prior.draw(max(POINTS, 4 * len(points)), rng)
        density = log_posterior(new, list(observables), prior, correlation)
        density = density - prior.log_density(new)
        points, log_weight = np.vstack([points, new]), np.r_[log_weight, density]
        weights = np.exp(log_weight - log_weight.max())
        weights /= weights.sum()
        if 1 / np.sum(weights**2) >= LEAST_EFFECTIVE or len(points) >= MOST_POINTS:
            return Weighted(prior, points, weights)


def most_informative(
    candidates: np.ndarray,
    draws: np.ndarray,
    surfaces: Sequence[tuple[Surrogate, float]],
    names: tuple[str, ...],
    count: int,
) -> np.ndarray:
    """`count` of the candidates (n, k), each the one that tells most once those before
    it are run.

    draws: (m, k) of the posterior, natural units, columns as in `names`; surfaces: each
    with the sd of the bench's mean."""
    at = [_model(surface, candidates, names) for surface, _ in surfaces]
    there = [_model(surface, draws, names) for surface, _ in surfaces]
    known = [surface.covariance for surface, _ in surfaces]
    chosen = []
    for _ in range(count):
        information = np.zeros(len(candidates))
        for (surface, bench_sd), x, f, v in zip(surfaces, at, there, known):
            scatter = surface.noise_sd**2 + np.sum(x @ v * x, axis=1)
            taken = (f @ v @ x.T) ** 2 / scatter
            before = bench_sd**2 + np.sum(f @ v * f, axis=1)
            information -= 0.5 * np.log1p(-taken / before[:, None]).mean(axis=0)
        best = int(np.argmax(information))
        chosen.append(candidates[best])
        for k, ((surface, _), x, v) in enumerate(zip(surfaces, at, known)):
            learnt = v @ x[best]
            scatter = surface.noise_sd**2 + x[best] @ learnt
            known[k] = v - np.outer(learnt, learnt) / scatter
    return np.array(chosen)


def _model(
    surface: Surrogate, points: np.ndarray, names: tuple[str, ...]
) -> np.ndarray:
    """The surface's model matrix at points (n, k) whose columns are `names`."""
    columns = [names.index(n) for n in surface.box.names]
    return polynomial.matrix(surface.box.coded(points[:, columns]), surface.terms)
