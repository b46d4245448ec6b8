"""Questions to the reduced space of a fitted baseline: projected scores, what freeing something explains, evidence, prediction.

With nuisances n of prior sd T marginalised,  P = I − A_n (A_nᵀA_n + T⁻²)⁻¹ A_nᵀ,  a candidate's column a has the score
z = aᵀPb / √(aᵀPa), normal with variance 1 where the baseline is true. Rao (1948); Kass & Raftery (1995) for the evidence.
"""

from dataclasses import dataclass

import numpy as np

from calibrate.diagnose.drop.baseline import Fit, ridge
from calibrate.diagnose.drop.reduction import Reduced
from calibrate.diagnose.effects.drop import EFFECTS


@dataclass(frozen=True, eq=False)
class Scores:
    """names (m,) of columns, their normal scores z (m,) with covariance (m, m); unit (m,): a score of 1 in the effect's unit."""

    names: tuple[str, ...]
    z: np.ndarray
    covariance: np.ndarray
    unit: np.ndarray


def stacked(reduced: tuple[Reduced, ...]) -> tuple[np.ndarray, np.ndarray]:
    """A (M, G) and b (M,) of several recordings."""
    return np.vstack([r.a for r in reduced]), np.concatenate([r.b for r in reduced])


def projector(a: np.ndarray, prior_sd: np.ndarray):
    """x → P x, the nuisances with prior_sd > 0 marginalised."""
    scaled = a[:, prior_sd > 0] * prior_sd[prior_sd > 0]
    inverse = np.linalg.inv(scaled.T @ scaled + np.eye(scaled.shape[1]))
    return lambda x: x - scaled @ (inverse @ (scaled.T @ x))


def score(fit: Fit) -> Scores:
    """Projected scores of all candidates that this session can show."""
    a, b = stacked(fit.reduced)
    names = tuple(n for n in fit.names if n in EFFECTS)
    columns = a[:, [fit.names.index(n) for n in names]]
    project = projector(a, fit.prior_sd)
    right = project(b)
    gram = columns.T @ project(columns)
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    return Scores(names, columns.T @ right / size, gram / np.outer(size, size), 1 / size)


def explained(fit: Fit, free: tuple[str, ...], *, smooth: bool = False) -> tuple[float, int]:
    """By how much χ² falls when the effects `free` (and the flights' smooth curves) cost nothing, and the freedom that takes."""
    a, b = stacked(fit.reduced)
    parts = [a[:, [fit.names.index(n) for n in free]]]
    if smooth:
        parts.append(_block_diagonal([r.smooth for r in fit.reduced]))
    return fall_of_chi2(np.hstack(parts), projector(a, fit.prior_sd), b)


def fall_of_chi2(columns: np.ndarray, project, b: np.ndarray) -> tuple[float, int]:
    """χ² that `columns` (M, k) take from b (M,) beside the nuisances of `project`, and their rank."""
    gram, right = columns.T @ project(columns), columns.T @ project(b)
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    values, vectors = np.linalg.eigh(gram / np.outer(scale, scale))
    kept = values > 1e-8
    seen = vectors[:, kept].T @ (right / scale)
    return float((seen**2 / values[kept]).sum()), int(kept.sum())


def _block_diagonal(blocks: list[np.ndarray]) -> np.ndarray:
    out = np.zeros((sum(len(x) for x in blocks), sum(x.shape[1] for x in blocks)))
    row = column = 0
    for x in blocks:
        out[row : row + len(x), column : column + x.shape[1]] = x
        row, column = row + len(x), column + x.shape[1]
    return out


def ln_evidence(reduced: tuple[Reduced, ...], prior_sd: np.ndarray) -> float:
    """ln of the evidence of b in Laplace's approximation about the point of linearisation, but for a constant common to all.

    −½ (χ² at its minimum, prior terms included, + ln det(1 + T AᵀA T)).
    """
    a, b = stacked(reduced)
    scaled = a[:, prior_sd > 0] * prior_sd[prior_sd > 0]
    return -0.5 * (ridge(a, b, prior_sd)[2] + np.linalg.slogdet(scaled.T @ scaled + np.eye(scaled.shape[1]))[1])


def predictive_gains(fit: Fit, base: Fit, effects: tuple[str, ...]) -> np.ndarray:
    """(R,) ln predictive density of each recording given the others, of `fit` less that of `base` with `effects` held at nil.

    ln p(b_r | others) = ln p(all) − ln p(others), each model linearised about its own fit. At nil, because a baseline that may
    bend a nuisance within its sd learns the effect from the other recordings too. Empty for one recording: nothing is held out.
    """
    if len(fit.reduced) < 2:
        return np.zeros(0)
    without = np.where([n in effects for n in base.names], 0.0, base.prior_sd)
    whole = ln_evidence(fit.reduced, fit.prior_sd) - ln_evidence(base.reduced, without)
    out = []
    for r in range(len(fit.reduced)):
        mine, its = (x.reduced[:r] + x.reduced[r + 1 :] for x in (fit, base))
        out.append(whole - ln_evidence(mine, fit.prior_sd) + ln_evidence(its, without))
    return np.array(out)


def single_estimates(fit: Fit, name: str) -> tuple[np.ndarray, np.ndarray]:
    """The effect as each recording alone has it, and its sd (R,), prior left out."""
    column, values, sds = fit.names.index(name), [], []
    for r in fit.reduced:
        project = projector(r.a, np.where(np.arange(len(fit.names)) == column, 0.0, fit.prior_sd))
        size = r.a[:, column] @ project(r.a[:, column])
        values.append(r.a[:, column] @ project(r.b) / max(size, 1e-300))
        sds.append(1 / np.sqrt(max(size, 1e-300)))
    return np.array(values), np.array(sds)
