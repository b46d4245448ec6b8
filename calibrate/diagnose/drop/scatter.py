"""Scatter of bounces: variance components by REML, beside what was measured badly and beside a flexible law.

A long seed's bounce exchanges translation and spin: its e and its kicks are wide random variables, wider the faster it turns
beside its fall. The scatter is read from the impacts themselves. Patterson & Thompson (1971), Biometrika 58, 545.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.special import polygamma

FAR_OFF = 3.5  # standardised residuals beyond are no normal scatter: such an impact counts for less
LEAST_FREEDOM = 3


@dataclass(frozen=True, eq=False)
class Scatter:
    """covariance (m, m) of the rows, measuring error included; log_level_sd: sd of the logarithm of its size."""

    covariance: np.ndarray
    log_level_sd: float


def scatter_of(
    y: np.ndarray, design: np.ndarray, measured: np.ndarray, components: list[np.ndarray], floor: float
) -> Scatter | None:
    """Rows y (m,) about a free law `design` (m, p); measured (m, m): covariance of the measuring; components (m, m) each of unit
    size, the first at least `floor`² large. None where too few rows are left to tell a scatter."""
    freedom = len(y) - np.linalg.matrix_rank(design) if len(y) else 0
    if freedom < LEAST_FREEDOM:
        return None
    known = measured.copy()
    for _ in range(3):
        whole = known + _fitted(y, design, known, components, floor)
        far = _standardised(y, design, whole)
        if not (far > FAR_OFF).any():
            break
        known = known + np.diag(np.where(far > FAR_OFF, ((far / 3) ** 2 - 1) * np.diag(whole), 0.0))
    return Scatter(whole, float(np.sqrt(polygamma(1, freedom / 2))))


def _fitted(y, design, known, components, floor: float) -> np.ndarray:
    """The sum of the components at the largest restricted likelihood."""
    basis = np.linalg.qr(design)[0]
    left = np.linalg.svd(np.eye(len(y)) - basis @ basis.T)[0][:, : len(y) - basis.shape[1]]
    seen, fixed, parts = left.T @ y, left.T @ known @ left, [left.T @ v @ left for v in components]
    usual = float(np.mean(seen**2)) + floor**2

    def sizes(u: np.ndarray) -> np.ndarray:
        variance = usual * np.exp(np.clip(u, -14, 6))
        variance[0] += floor**2
        return variance

    def loss(u: np.ndarray) -> float:
        whole = fixed + sum(s * v for s, v in zip(sizes(u), parts, strict=True))
        triangle = np.linalg.cholesky(whole + 1e-14 * usual * np.eye(len(whole)))
        return float(2 * np.log(np.diag(triangle)).sum() + (np.linalg.solve(triangle, seen) ** 2).sum() + 0.02 * (u**2).sum())

    starts = [np.full(len(parts), -2.0), np.r_[-6.0, np.full(len(parts) - 1, -1.0)]]
    ends = [minimize(loss, u, method="Nelder-Mead", options={"maxfev": 200, "fatol": 0.01}) for u in starts]
    best = min(ends, key=lambda end: end.fun)
    return sum(s * v for s, v in zip(sizes(best.x), components, strict=True))


def _standardised(y: np.ndarray, design: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """|residual| over its sd (m,), each as the other rows predict it."""
    inverse = np.linalg.inv(whole)
    gram = design.T @ inverse @ design
    project = inverse - inverse @ design @ np.linalg.pinv(gram) @ design.T @ inverse
    return np.abs(project @ y) / np.sqrt(np.maximum(np.diag(project), 1e-300))
