"""Scatter of bounces: variance components by REML, beside measuring errors and a law.

A long seed exchanges translation and spin in a bounce, so e and kicks vary widely.
Source: Patterson & Thompson (1971), Biometrika 58, 545.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components
from scipy.special import polygamma

from benchtwin.bench import distributions as stats
from benchtwin.bench.robust import robust_sd

# degrees of freedom of bounces' Student scatter: most contacts stick, a few slide or
# touch twice
TAILS = 4.0
MAX_ITERATIONS = 8
LEAST_WEIGHT = 1e-3
LEAST_FREEDOM = 3
MOST_LOSS = (TAILS + 3) / (
    TAILS + 1
)  # of information by the weights, where the scatter is Student's t itself
SCALE_LOSS = 3 / (TAILS + 3)  # of information on the scale
USUAL_ROWS = 2.0  # rows that the prior of a scatter is worth
LEAST_VALUE = 1e-15  # of the largest: a smaller eigenvalue is none
VAGUE = 0.1  # prior information on ln of a variance component


@dataclass(frozen=True, eq=False)
class Scatter:
    """Scatter of rows about a law."""

    covariance: np.ndarray  # (m, m), measuring included, widened as Student's t at 95 %
    log_level_sd: float  # uncertainty beyond that
    aicc: float  # of the law


def scatter_of(
    y: np.ndarray,
    design: np.ndarray,
    measured: np.ndarray,
    components: list[np.ndarray],
    floor: float,
    asked: int = 0,
    most: float = math.inf,
    usual: tuple[float, ...] = (),
) -> Scatter | None:
    """Scatter of rows y (m,) about a law `design` (m, p); None where too few rows
    remain.

    asked: column from which on an effect may be asked about; measured (m, m):
    covariance of measuring; components (m, m): of unit size, the first at least floor²
    large, the second at most most²; usual: expected sds of components, each worth
    USUAL_ROWS rows, 0 for none."""
    design = _independent(design)
    if len(y) - design.shape[1] < LEAST_FREEDOM:
        return None
    starts = (np.ones(len(y)), _weights(_robust(y, design, floor) ** 2))
    settled = [
        _settled(y, design, measured, components, (floor, most), usual, w)
        for w in starts
    ]
    likelihood, parts, square = max(settled, key=lambda found: found[0])
    loss = _loss_of_weighting(square)
    few = max(
        _freedom(measured, parts, design, asked)
        * (1 - SCALE_LOSS * (loss - 1) / (MOST_LOSS - 1)),
        1.0,
    )
    wider = loss * (stats.t.ppf(0.975, few) / stats.norm.ppf(0.975)) ** 2
    level_sd = 0.5 * float(np.sqrt(polygamma(1, few / 2)))
    numbers = (
        design.shape[1] + 1
    )  # Akaike's criterion: Hurvich & Tsai (1989), Biometrika 76, 297
    aicc = -2 * likelihood + 2 * numbers * len(y) / max(len(y) - numbers - 1, 0.5)
    return Scatter(wider * (measured + sum(parts)), level_sd, aicc)


def _independent(design: np.ndarray) -> np.ndarray:
    """Its columns without those that depend linearly on earlier ones."""
    kept: list[int] = []
    for k in range(design.shape[1]):
        if len(design) and np.linalg.matrix_rank(design[:, [*kept, k]]) > len(kept):
            kept.append(k)
    return design[:, kept]


def _settled(
    y,
    design,
    measured,
    components,
    bounds: tuple[float, float],
    usual: tuple[float, ...],
    weight: np.ndarray,
):
    """Student weights and variances in turn: likelihood, components, squared
    residuals."""
    at = None
    for _ in range(MAX_ITERATIONS):
        rows = [
            components[0] / weight,
            components[1] / weight,
            *components[2:],
        ]  # diagonal components have outliers
        parts, at = _fitted(y, design, measured, rows, bounds, usual, at)
        whole = measured + sum(parts)
        square = _standardised(y, design, whole) ** 2 / weight
        before, weight = weight, _weights(square)
        if np.abs(weight - before).max() < 0.05:
            break
    size = np.log(np.diag(whole) * before).sum()
    return (
        -0.5 * float(size + (TAILS + 1) * np.log1p(square / TAILS).sum()),
        parts,
        square,
    )


def _robust(y: np.ndarray, design: np.ndarray, floor: float) -> np.ndarray:
    """Residuals (m,) about the law of least absolute deviations, over their spread."""
    weight = np.ones(len(y))
    for _ in range(20):
        root = np.sqrt(weight)[:, None]
        left = (
            y - design @ np.linalg.lstsq(root * design, root[:, 0] * y, rcond=None)[0]
        )
        weight = 1 / np.maximum(np.abs(left), 0.1 * floor)
    spread = robust_sd(left) * math.sqrt(len(y) / max(len(y) - design.shape[1], 1))
    return left / (spread + floor)


def _weights(square: np.ndarray) -> np.ndarray:
    """Student's t weights of rows with these squared standardised residuals."""
    return np.maximum((TAILS + 1) / (TAILS + square), LEAST_WEIGHT)


def _loss_of_weighting(square: np.ndarray) -> float:
    """Variance inflation by weights, mean w mean ψ²/(mean ψ')², ψ = w x (Huber
    1964)."""
    weight = _weights(square)
    slope = float(((TAILS + 1) * (TAILS - square) / (TAILS + square) ** 2).mean())
    loss = float(weight.mean() * (weight**2 * square).mean()) / max(slope, 0.3) ** 2
    return float(np.clip(loss, 1.0, MOST_LOSS))


def _freedom(
    measured: np.ndarray, parts: list[np.ndarray], design: np.ndarray, asked: int
) -> float:
    """Degrees of freedom ν = 2/var ln(information) of the least certain column asked
    about.

    From the restricted information ½ tr(P V_i P V_j) of the variance components.
    Sources: Satterthwaite (1946), Biometrics Bulletin 2, 110; Kenward & Roger (1997),
    Biometrics 53, 983."""
    inverse = np.linalg.inv(measured + sum(parts))
    free = [_beside(inverse, design) @ part for part in parts]
    information = 0.5 * np.array([[float((a * b.T).sum()) for b in free] for a in free])
    variance = np.linalg.inv(information + VAGUE * np.eye(len(parts)))
    worst = 0.0
    for k in range(min(asked, design.shape[1] - 1), design.shape[1]):
        pull = (_beside(inverse, design[:, :1]) if k else inverse) @ design[:, k]
        size = float(design[:, k] @ pull)
        share = np.array([float(pull @ part @ pull) for part in parts]) / max(
            size, 1e-300
        )
        worst = max(worst, float(share @ variance @ share))
    return 2 / max(worst, 1e-9)


def _beside(inverse: np.ndarray, design: np.ndarray) -> np.ndarray:
    """V⁻¹ − V⁻¹ X (Xᵀ V⁻¹ X)⁺ Xᵀ V⁻¹."""
    return (
        inverse
        - inverse
        @ design
        @ np.linalg.pinv(design.T @ inverse @ design)
        @ design.T
        @ inverse
    )


def _fitted(
    y,
    design,
    known,
    components,
    bounds: tuple[float, float],
    expected: tuple[float, ...],
    at,
):
    """The components at the largest restricted likelihood, and ln of their sizes."""
    spot = _blocks([known, *components])
    fixed, parts = _cut(known, spot, 1.0), [_cut(v, spot, 0.0) for v in components]
    inside = spot < len(y)
    rows = np.where(
        inside[..., None], np.column_stack([design, y])[np.where(inside, spot, 0)], 0.0
    )
    floor, most = bounds
    left = y - design @ np.linalg.lstsq(design, y, rcond=None)[0]
    usual = float((left**2).sum()) / (len(y) - design.shape[1]) + floor**2
    jitter = 1e-10 * np.eye(spot.shape[1])

    def sizes(u: np.ndarray) -> np.ndarray:
        variance = usual * np.exp(np.clip(u, -14, 6))
        variance[0] += floor**2
        variance[1] = min(variance[1], most**2)
        variance[2:] = np.minimum(
            variance[2:], variance[0]
        )  # variance between seeds is at most that within
        return variance

    def loss(u: np.ndarray) -> float:
        found = sizes(u)
        whole = fixed + sum(s * v for s, v in zip(found, parts, strict=True))
        try:
            triangle = np.linalg.cholesky(whole + usual * jitter)
        except (
            np.linalg.LinAlgError
        ):  # one row so far off that the others' scatter is lost beside it
            return np.inf
        white = np.linalg.solve(triangle, rows).reshape(-1, rows.shape[-1])
        gram = white.T @ white
        values, vectors = np.linalg.eigh(gram[:-1, :-1])
        values = np.maximum(values, LEAST_VALUE * values[-1])
        chance = 2 * np.log(np.diagonal(triangle, axis1=1, axis2=2)).sum()
        chance += np.log(values).sum()
        chance += gram[-1, -1] - ((gram[-1, :-1] @ vectors) ** 2 / values).sum()
        beforehand = sum(
            np.log(v) + sd**2 / v for v, sd in zip(found, expected, strict=False) if sd
        )
        return float(chance + USUAL_ROWS * beforehand + 0.02 * (u**2).sum())

    starts = (
        [np.full(len(parts), -2.0), np.r_[-6.0, np.full(len(parts) - 1, -1.0)]]
        if at is None
        else [at]
    )
    ends = [
        minimize(loss, u, method="Nelder-Mead", options={"maxfev": 120, "fatol": 0.01})
        for u in starts
    ]
    best = min(ends, key=lambda end: end.fun)
    return [s * v for s, v in zip(sizes(best.x), components, strict=True)], best.x


def _blocks(matrices: list[np.ndarray]) -> np.ndarray:
    """(B, k) rows of the blocks common to all these matrices (m, m); m pads shorter
    blocks."""
    count, member = connected_components(
        csr_matrix(sum(m != 0 for m in matrices)), directed=False
    )
    rows = [np.flatnonzero(member == b) for b in range(count)]
    return np.array(
        [
            np.pad(r, (0, max(map(len, rows)) - len(r)), constant_values=len(member))
            for r in rows
        ]
    )


def _cut(matrix: np.ndarray, spot: np.ndarray, beyond: float) -> np.ndarray:
    """(B, k, k) blocks of a matrix; beyond: on the diagonal of the padding."""
    whole = np.zeros((len(matrix) + 1, len(matrix) + 1))
    whole[:-1, :-1], whole[-1, -1] = matrix, beyond
    blocks = whole[spot[:, :, None], spot[:, None, :]]
    absent = spot == len(matrix)
    blocks[
        absent[:, :, None] & absent[:, None, :] & ~np.eye(spot.shape[1], dtype=bool)
    ] = 0.0
    return blocks


def _standardised(y: np.ndarray, design: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """|residual| of each row (m,) about the law of the others, over its sd; 0 if not
    testable."""
    inverse = np.linalg.inv(whole)
    own = _beside(inverse, design)
    spare = np.diag(own) > 1e-9 * np.diag(inverse)
    return np.where(
        spare, np.abs(own @ y) / np.sqrt(np.where(spare, np.diag(own), 1.0)), 0.0
    )
