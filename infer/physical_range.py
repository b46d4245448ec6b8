"""How probable is it that normal quantities all lie in their physical ranges?"""

import numpy as np
from scipy.special import log_ndtr

SWEEPS = 4  # after which two quantities have converged to some 1e-2
ALIKE = 0.2  # correlation above which quantities are not taken as independent
OUTSIDE = 1e-3  # probability of this, below which a range does not matter
LEAST_NARROWING = 1e-10  # relative to the marginal variance


def ln_within(
    mean: np.ndarray, covariance: np.ndarray, low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """ln P (...) that normal x (..., k) of this mean and covariance (..., k, k) lies
    between low and high (k,): jointly where a range matters to quantities that are
    alike."""
    sd = np.sqrt(np.einsum("...ii->...i", covariance))
    total = np.array(_truncated((low - mean) / sd, (high - mean) / sd)[0].sum(-1))
    correlation = covariance / (sd[..., :, None] * sd[..., None, :])
    alike = np.abs(correlation - np.eye(len(low))).max((-2, -1)) > ALIKE
    asked = alike & (total < -OUTSIDE)
    if asked.any():
        total[asked] = _ln_jointly_within(mean[asked], covariance[asked], low, high)
    return total


def _ln_jointly_within(
    mean: np.ndarray, covariance: np.ndarray, low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """ln P (n,) of means (n, k) and covariances (n, k, k).

    Expectation propagation: each range is replaced by a Gaussian factor that has its
    moments beside all others. Exact for one quantity and for independent ones. Source:
    Cunningham, Hennig & Lacoste-Julien (2011), arXiv:1111.6832."""
    unit = np.eye(mean.shape[-1])
    narrow, pull = np.zeros(mean.shape), np.zeros(mean.shape)  # τ and ν of the factors
    ln_factor = np.zeros(mean.shape)  # of a factor exp(−τ x²/2 + ν x)
    for _ in range(SWEEPS):
        for i in range(len(low)):
            solved = np.linalg.inv(unit + covariance * narrow[..., None, :])
            now = solved @ covariance
            at = solved @ (mean + (covariance @ pull[..., None])[..., 0])[..., None]
            variance = now[..., i, i]
            kept = 1 - narrow[..., i] * variance
            cavity = variance / kept
            centre = (at[..., i, 0] - pull[..., i] * variance) / kept
            sd = np.sqrt(cavity)
            ln_p, shift, share = _truncated(
                (low[i] - centre) / sd, (high[i] - centre) / sd
            )
            narrow[..., i] = np.maximum(1 / share - 1, LEAST_NARROWING) / cavity
            wide = 1 + narrow[..., i] * cavity
            pull[..., i] = (wide * (centre + sd * shift) - centre) / cavity
            fits = pull[..., i] ** 2 * cavity + 2 * pull[..., i] * centre
            fits = (fits - narrow[..., i] * centre**2) / wide
            ln_factor[..., i] = ln_p + 0.5 * (np.log(wide) - fits)
    solved = np.linalg.inv(unit + covariance * narrow[..., None, :])
    now = solved @ covariance
    start = (solved @ mean[..., None])[..., 0]
    fits = np.einsum("...i,...ij,...j->...", pull, now, pull)
    fits += ((2 * pull - narrow * mean) * start).sum(-1)
    return ln_factor.sum(-1) + 0.5 * (np.linalg.slogdet(solved)[1] + fits)


def _truncated(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, ...]:
    """ln P(a < z < b) of standard normal z, accurate in far tails, and mean and
    variance of z there."""
    flipped = a > 0
    low, high = np.where(flipped, -b, a), np.where(flipped, -a, b)
    upper, lower = log_ndtr(high), log_ndtr(low)
    ln_p = upper + np.log1p(-np.exp(np.minimum(lower - upper, -1e-12)))
    at_low, at_high = (_density_over(x, ln_p) for x in (low, high))
    mean = at_low - at_high
    ends = _finite(low) * at_low - _finite(high) * at_high
    variance = np.clip(1 + ends - mean**2, 1e-6, 1.0)
    return ln_p, np.where(flipped, -mean, mean), variance


def _density_over(x: np.ndarray, ln_p: np.ndarray) -> np.ndarray:
    """Density of the standard normal at x over exp(ln_p)."""
    return np.exp(-0.5 * (x**2 + np.log(2 * np.pi)) - ln_p)


def _finite(x: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(x), x, 0.0)
