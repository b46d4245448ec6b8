"""Scatter of bounces: variance components by REML, beside what was measured badly and beside a flexible law.

A long seed's bounce exchanges translation and spin: its e and its kicks are wide random variables, wider the faster it turns
beside its fall. The scatter is read from the impacts themselves. Patterson & Thompson (1971), Biometrika 58, 545.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.optimize import minimize
from scipy.special import polygamma

TAILS = 4.0  # degrees of freedom of bounces' Student scatter: most contacts stick, a few slide or touch twice
TURNS = 8
LEAST_WEIGHT = 1e-3
LEAST_FREEDOM = 3


@dataclass(frozen=True, eq=False)
class Scatter:
    """covariance (m, m) of the rows, measuring error included, widened as Student's t at 95 % because it is known from few rows;
    log_level_sd: what its doubt has beyond, in the far tails."""

    covariance: np.ndarray
    log_level_sd: float


def scatter_of(
    y: np.ndarray,
    design: np.ndarray,
    measured: np.ndarray,
    components: list[np.ndarray],
    floor: float,
) -> Scatter | None:
    """Rows y (m,) about a free law `design` (m, p); measured (m, m): covariance of the measuring; components (m, m) each of unit
    size, the first at least `floor`² large. None where too few rows are left to tell a scatter."""
    freedom = len(y) - np.linalg.matrix_rank(design) if len(y) else 0
    if freedom < LEAST_FREEDOM:
        return None
    starts = (np.ones(len(y)), _weights(_robust(y, design, floor) ** 2))
    whole = max((_settled(y, design, measured, components, floor, w) for w in starts), key=lambda found: found[0])[1]
    whole = whole * (TAILS + 3) / (TAILS + 1)  # what such weights make of the information, at most
    few = _freedom(whole, design)
    wider = (stats.t.ppf(0.975, few) / stats.norm.ppf(0.975)) ** 2
    return Scatter(wider * whole, 0.5 * float(np.sqrt(polygamma(1, few / 2))))


def _settled(y, design, measured, components, floor: float, weight: np.ndarray) -> tuple[float, np.ndarray]:
    """Weights and variances in turn, until they agree: ln of Student's likelihood, about, and the covariance."""
    at = None
    for _ in range(TURNS):
        rows = [components[0] / weight, components[1] / weight, *components[2:]]  # diagonal ones: they are what has outliers
        spread, at = _fitted(y, design, measured, rows, floor, at)
        whole = measured + spread
        square = _standardised(y, design, whole) ** 2 / weight
        before, weight = weight, _weights(square)
        if np.abs(weight - before).max() < 0.05:
            break
    size = np.log(np.diag(whole) * before).sum()
    return -0.5 * float(size + (TAILS + 1) * np.log1p(square / TAILS).sum()), whole


def _robust(y: np.ndarray, design: np.ndarray, floor: float) -> np.ndarray:
    """Residuals (m,) about the law of least absolute deviations, over their own spread."""
    weight = np.ones(len(y))
    for _ in range(20):
        root = np.sqrt(weight)[:, None]
        left = y - design @ np.linalg.lstsq(root * design, root[:, 0] * y, rcond=None)[0]
        weight = 1 / np.maximum(np.abs(left), 0.1 * floor)
    spread = 1.4826 * float(np.median(np.abs(left))) * math.sqrt(len(y) / max(len(y) - design.shape[1], 1))
    return left / (spread + floor)


def _weights(square: np.ndarray) -> np.ndarray:
    """Of rows with these squared standardised residuals, under Student's t."""
    return np.maximum((TAILS + 1) / (TAILS + square), LEAST_WEIGHT)


def _freedom(whole: np.ndarray, design: np.ndarray) -> int:
    """Of the scatter of those rows that decide: the precise ones, within twice the least variance."""
    variance = np.diag(whole)
    precise = design[variance < 2 * variance.min()]
    return max(len(precise) - int(np.linalg.matrix_rank(precise)), 1)


def _fitted(y, design, known, components, floor: float, at):
    """The sum of the components at the largest restricted likelihood, and ln of their sizes, to begin with the next time."""
    basis = np.linalg.qr(design)[0]
    left = np.linalg.svd(np.eye(len(y)) - basis @ basis.T)[0][:, : len(y) - basis.shape[1]]
    seen, fixed, parts = left.T @ y, left.T @ known @ left, [left.T @ v @ left for v in components]
    usual = float(np.mean(seen**2)) + floor**2

    def sizes(u: np.ndarray) -> np.ndarray:
        variance = usual * np.exp(np.clip(u, -14, 6))
        variance[0] += floor**2
        variance[2:] = np.minimum(variance[2:], variance[0])  # seeds differ by no more than bounces of one seed do
        return variance

    def loss(u: np.ndarray) -> float:
        whole = fixed + sum(s * v for s, v in zip(sizes(u), parts, strict=True))
        try:
            triangle = np.linalg.cholesky(whole + 1e-10 * np.trace(whole) / len(whole) * np.eye(len(whole)))
        except np.linalg.LinAlgError:  # one row so far off that the others' scatter is lost beside it
            return np.inf
        return float(2 * np.log(np.diag(triangle)).sum() + (np.linalg.solve(triangle, seen) ** 2).sum() + 0.02 * (u**2).sum())

    starts = [np.full(len(parts), -2.0), np.r_[-6.0, np.full(len(parts) - 1, -1.0)]] if at is None else [at]
    ends = [minimize(loss, u, method="Nelder-Mead", options={"maxfev": 200, "fatol": 0.01}) for u in starts]
    best = min(ends, key=lambda end: end.fun)
    return sum(s * v for s, v in zip(sizes(best.x), components, strict=True)), best.x


def _standardised(y: np.ndarray, design: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """|residual| beside the law over its sd (m,), a row's own pull upon the law being spread over all."""
    inverse = np.linalg.inv(whole)
    law = np.linalg.pinv(design.T @ inverse @ design) @ design.T @ inverse @ y
    spare = max(len(y) - design.shape[1], 1)
    return np.abs(y - design @ law) / np.sqrt(np.diag(whole) * spare / len(y))
