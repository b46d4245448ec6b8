"""Linear algebra of a linearised problem: b_r = A_r θ + S_r s + ε, locals
eliminated."""

from dataclasses import dataclass

import numpy as np

from benchtwin.bench import distributions as stats


@dataclass(frozen=True, eq=False)
class Reduced:
    """One recording, linearised."""

    a: np.ndarray  # (m, G): columns of the globals
    smooth: np.ndarray  # (m, …): of its smooth curves
    b: np.ndarray  # (m,): data at θ = 0
    # at the point of linearisation with the locals' prior, if known
    chi2: float | None = None
    half_ln_det: float = 0.0  # ½ ln det of the marginalised locals
    own: np.ndarray | None = None  # (L, L): triangle of the locals, globals given


def stacked(reduced: tuple[Reduced, ...]) -> tuple[np.ndarray, np.ndarray]:
    """A (M, G) and b (M,) of all recordings."""
    return np.vstack([r.a for r in reduced]), np.concatenate([r.b for r in reduced])


def ridge(
    a: np.ndarray, b: np.ndarray, prior_sd: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float]:
    """Minimiser θ (G,) of |b − aθ|² + |θ/sd|² (sd 0: fixed), its covariance, and the
    minimum."""
    kept = prior_sd > 0
    scaled = a[:, kept] * prior_sd[kept]
    information = scaled.T @ scaled + np.eye(kept.sum())
    values = np.zeros(len(prior_sd))
    covariance = np.zeros((len(prior_sd), len(prior_sd)))
    inverse = np.linalg.inv(information)
    u = inverse @ (scaled.T @ b)
    values[kept] = prior_sd[kept] * u
    covariance[np.ix_(kept, kept)] = prior_sd[kept][:, None] * inverse * prior_sd[kept]
    return values, covariance, float(((b - scaled @ u) ** 2).sum() + (u**2).sum())


def projector(a: np.ndarray, prior_sd: np.ndarray):
    """x → P x, which marginalises the globals with prior_sd > 0."""
    scaled = a[:, prior_sd > 0] * prior_sd[prior_sd > 0]
    inverse = np.linalg.inv(scaled.T @ scaled + np.eye(scaled.shape[1]))
    return lambda x: x - scaled @ (inverse @ (scaled.T @ x))


def fall_of_chi2(columns: np.ndarray, project, b: np.ndarray) -> tuple[float, int]:
    """By how much `columns` (M, k) lower χ² beside the projected globals, and their
    rank."""
    return fall_in(columns.T @ project(columns), columns.T @ project(b))


def fall_in(gram: np.ndarray, right: np.ndarray) -> tuple[float, int]:
    """The same by the columns' Gram matrix (k, k) and product with the data (k,)."""
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    values, vectors = np.linalg.eigh(gram / np.outer(scale, scale))
    kept = values > 1e-8
    seen = vectors[:, kept].T @ (right / scale)
    return float((seen**2 / values[kept]).sum()), int(kept.sum())


def beside_globals(reduced: tuple[Reduced, ...], prior_sd: np.ndarray):
    """Columns (M, K) behind the globals', projection that marginalises the globals, b
    (M,)."""
    a, b = stacked(reduced)
    a, columns = np.split(a, [len(prior_sd)], axis=1)
    return columns, projector(a, prior_sd), b


def chance(fall: float, freedom: int, doubt: np.ndarray) -> float:
    """P(χ² > fall), averaged over `doubt`: draws of the true over the estimated noise
    power."""
    return float(stats.chi2.sf(fall / doubt, freedom).mean())
