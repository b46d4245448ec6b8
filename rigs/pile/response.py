"""What a heap shows as a quadratic of what is not known of it, from simulated heaps.

y = c₀ + Σ cᵢ xᵢ + Σ cᵢⱼ xᵢ xⱼ + ε, x in [0, 1]. The c have normal priors, ε is what
packings vary; its share is the one of the highest marginal likelihood (Bishop 2006,
Pattern Recognition and Machine Learning, section 3.5)."""

from dataclasses import dataclass

import numpy as np

# prior sds of linear and quadratic coefficients, in sds of the heaps
LINEAR, QUADRATIC = 2.0, 1.0
NOISE = np.geomspace(0.05, 1.0, 25)  # of a packing, in sds of the heaps


@dataclass(frozen=True, eq=False)
class Quadratic:
    """mean [unit of y], coefficients (p,), their covariance (p, p), sd of packings."""

    mean: float
    coefficients: np.ndarray
    covariance: np.ndarray
    packing_sd: float

    def at(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(d,) expected y at x (d, k), and its variance; packings not included."""
        terms = _terms(x)
        variance = (terms @ self.covariance * terms).sum(axis=1)
        return self.mean + terms @ self.coefficients, variance


def quadratic(x: np.ndarray, y: np.ndarray) -> Quadratic:
    """The quadratic of heaps at x (n, k) that show y (n,), NaN where they do not."""
    seen = np.isfinite(y)
    terms, mean, scale = _terms(x[seen]), float(y[seen].mean()), float(y[seen].std())
    prior = np.full(terms.shape[1], QUADRATIC)
    prior[: x.shape[1] + 1] = LINEAR
    target = (y[seen] - mean) / scale
    modelled = (terms * prior**2) @ terms.T

    def ln_evidence(noise: float) -> float:
        whole = modelled + noise**2 * np.eye(len(target))
        return -0.5 * (
            target @ np.linalg.solve(whole, target) + np.linalg.slogdet(whole)[1]
        )

    noise = float(max(NOISE, key=ln_evidence))
    covariance = np.linalg.inv(terms.T @ terms / noise**2 + np.diag(prior**-2))
    coefficients = covariance @ terms.T @ target / noise**2
    return Quadratic(mean, scale * coefficients, scale**2 * covariance, scale * noise)


def _terms(x: np.ndarray) -> np.ndarray:
    """(n, p): 1, x centred, and products of any two."""
    x = 2 * x - 1
    one, two = np.triu_indices(x.shape[1])
    return np.column_stack([np.ones(len(x)), x, x[:, one] * x[:, two]])
