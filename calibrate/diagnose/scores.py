"""Questions to the reduced space of a fitted baseline: projected scores, what freeing something explains, evidence, prediction.

With nuisances n of prior sd T marginalised,  P = I − A_n (A_nᵀA_n + T⁻²)⁻¹ A_nᵀ,  a candidate's column a has the score
z = aᵀPb / √(aᵀPa), normal with variance 1 where the baseline is true. Rao (1948); Kass & Raftery (1995) for the evidence.
"""

from dataclasses import dataclass, replace

import numpy as np

from calibrate.diagnose.linear import Reduced, block_diagonal, fall_of_chi2, projector, ridge, stacked
from calibrate.diagnose.problem import Fit, Problem

FLAT = 1e3  # times its sd, a prior says nothing
BY_CHANCE = 2.0  # sd by which noise alone misses what is left out


@dataclass(frozen=True, eq=False)
class Scores:
    """names (m,) of columns, their normal scores z (m,) with covariance (m, m); unit (m,): a score of 1 in the effect's unit."""

    names: tuple[str, ...]
    z: np.ndarray
    covariance: np.ndarray
    unit: np.ndarray


def score(fit: Fit) -> Scores:
    """Projected scores of all candidates that this session can show."""
    a, b = stacked(fit.reduced)
    names = tuple(n for n in fit.names if n in fit.problem.effects)
    columns = a[:, [fit.names.index(n) for n in names]]
    project = projector(a, fit.prior_sd)
    right = project(b)
    gram = columns.T @ project(columns)
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    z = np.where(size > 1e-9 * np.sqrt((columns**2).sum(0) + 1e-300), columns.T @ right / size, 0.0)  # 0: the nuisances hide it
    return Scores(names, z, gram / np.outer(size, size), 1 / size)


def explained(fit: Fit, free: tuple[str, ...], *, smooth: bool = False) -> tuple[float, int]:
    """By how much χ² falls when the effects `free` (and the flights' smooth curves) cost nothing, and the freedom that takes."""
    a, b = stacked(fit.reduced)
    parts = [a[:, [fit.names.index(n) for n in free]]]
    if smooth:
        curves = [r.smooth for r in fit.reduced]
        parts.append(np.vstack(curves) if fit.problem.common_smooth else block_diagonal(curves))
    return fall_of_chi2(np.hstack(parts), projector(a, fit.prior_sd), b)


def unbound(fit: Fit, effects: tuple[str, ...], wider: float = FLAT) -> Fit:
    """The fit with the priors of `effects` taken off, or so many times wider: a strained prior is no sign that something else is
    left."""
    wide = np.isin(fit.names, [n for effect in effects for n in fit.problem.columns_of(effect)])
    return replace(fit, prior_sd=np.where(wide, wider * fit.prior_sd, fit.prior_sd))


def ln_evidence(reduced: tuple[Reduced, ...], prior_sd: np.ndarray) -> float:
    """ln of the evidence of b in Laplace's approximation about the point of linearisation, but for a constant common to all.

    −½ (χ² at its minimum, prior terms included, + ln det(1 + T AᵀA T)).
    """
    a, b = stacked(reduced)
    scaled = a[:, prior_sd > 0] * prior_sd[prior_sd > 0]
    bulk = sum(r.bulk for r in reduced)
    return -0.5 * (ridge(a, b, prior_sd)[2] + np.linalg.slogdet(scaled.T @ scaled + np.eye(scaled.shape[1]))[1]) - bulk


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


def gains_alone(fit: Fit, base: Fit, effects: tuple[str, ...]) -> np.ndarray:
    """(R,) ln density of each recording with the effects as the others have them, less that with none; all else as it was known
    before any recording, in both.

    What strains something known (a scale, a level) strains it in each recording; yet once the others have bent it, the baseline
    predicts that recording as well. Empty for one recording: nothing is held out.
    """
    if len(fit.reduced) < 2:
        return np.zeros(0)
    own = [i for i, n in enumerate(fit.names) if n in {c for e in effects for c in fit.problem.columns_of(e)}]
    known = np.where(np.isin(np.arange(len(fit.names)), own), 0.0, base.prior_sd)
    out = []
    for r, (mine, its) in enumerate(zip(fit.reduced, base.reduced, strict=True)):
        value, covariance, _ = ridge(*stacked(fit.reduced[:r] + fit.reduced[r + 1 :]), fit.prior_sd)
        spread = mine.a[:, own] @ np.linalg.cholesky(covariance[np.ix_(own, own)])  # a column a sd
        there = replace(mine, a=np.hstack([mine.a, spread]), b=mine.b - mine.a[:, own] @ value[own])
        out.append(ln_evidence((there,), np.r_[known, np.ones(len(own))]) - ln_evidence((its,), known))
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


@dataclass(frozen=True)
class HeldOut:
    """What the effects do for recordings that were left out when they were fitted.

    rmse_ratio: √(SSE_fit/SSE_base) of the whitened residuals; removed_fraction: (SSE_base − SSE_fit)/(SSE_base − SSE_noise), NaN
    where the baseline misses no more than noise does by chance: there is nothing of which a share could be removed.
    """

    rmse_ratio: float
    removed_fraction: float

    @classmethod
    def of(cls, sse_base: float, sse_fit: float, sse_noise: float, noise_sd: float = 0.0) -> "HeldOut":
        """From the three sums of squares of whitened residuals, and the scatter of that of the noise."""
        missed = sse_base - sse_noise
        share = (sse_base - sse_fit) / missed if missed > BY_CHANCE * noise_sd else float("nan")
        return cls(float(np.sqrt(sse_fit / sse_base)), float(share))


def held_out(fit: Fit, base: Fit, effects: tuple[str, ...]) -> HeldOut | None:
    """Each recording predicted with the globals of the others; None for one recording: nothing is held out.

    The baseline predicts with `effects` at nil.
    """
    if len(fit.reduced) < 2:
        return None
    nil = np.where([n in effects for n in base.names], 0.0, base.prior_sd)
    sse_base = sse_fit = 0.0
    for r, (mine, its) in enumerate(zip(fit.reduced, base.reduced, strict=True)):
        theta = ridge(*stacked(fit.reduced[:r] + fit.reduced[r + 1 :]), fit.prior_sd)[0]
        theta_base = ridge(*stacked(base.reduced[:r] + base.reduced[r + 1 :]), nil)[0]
        sse_fit += float(((mine.b - mine.a @ theta) ** 2).sum())
        sse_base += float(((its.b - its.a @ theta_base) ** 2).sum())
    return HeldOut.of(sse_base, sse_fit, *noise_of_left_out(fit.problem, fit.reduced, fit.prior_sd))


def noise_of_left_out(problem: Problem, reduced: tuple[Reduced, ...], prior_sd: np.ndarray) -> tuple[float, float]:
    """SSE that recordings left out are expected to have under the true model, its parameters fitted to the others, and its
    scatter beside what no model changes."""
    return (_noise_in_common if problem.common_smooth else _noise_of_each)(reduced, prior_sd)


def _noise_of_each(reduced: tuple[Reduced, ...], prior_sd: np.ndarray) -> tuple[float, float]:
    """What a saturated model leaves, plus one a column; less than one where the verdict's own model leaves less, because
    recordings differ by less than the priors of what is their own allow for."""
    columns, bare = 0, 0.0
    for mine in reduced:
        fall, count = fall_of_chi2(np.hstack([mine.a, mine.smooth]), lambda x: x, mine.b)
        bare, columns = bare + float((mine.b**2).sum()) - fall, columns + count
    a, b = stacked(reduced)
    theta, covariance, _ = ridge(a, b, prior_sd)
    spare = columns - float(np.einsum("ij,jk,ik->", a, covariance, a))
    power = min((float(((b - a @ theta) ** 2).sum()) - bare) / spare if spare > 0 else 1.0, 1.0)
    return bare + columns * power, power * float(np.sqrt(2 * columns))


def _noise_in_common(reduced: tuple[Reduced, ...], prior_sd: np.ndarray) -> tuple[float, float]:
    """The same where a saturated recording would leave nothing: what all have in common is what can be known.

    Beside what the saturated model, common to all recordings, leaves of these very recordings: s² for each of its columns, and
    s² tr(a C aᵀ) for what the others do not fix (C: covariance of the globals from them). s² is the noise's power among the
    directions that any model can reach, from what differs there between recordings: scatter between recordings is not as well
    known as a recording's own noise, by which s² would be 1.
    """
    columns = [np.hstack([r.a, r.smooth]) for r in reduced]
    every, b = np.vstack(columns), np.concatenate([r.b for r in reduced])
    fall, count = fall_of_chi2(every, lambda x: x, b)
    own = [fall_of_chi2(c, lambda x: x, r.b) for c, r in zip(columns, reduced, strict=True)]
    freedom = sum(rank for _, rank in own) - count
    power = (sum(f for f, _ in own) - fall) / freedom if freedom > 0 else 1.0
    unsure = 0.0
    for r, mine in enumerate(reduced):
        covariance = ridge(*stacked(reduced[:r] + reduced[r + 1 :]), prior_sd)[1]
        unsure += float(np.einsum("ij,jk,ik->", mine.a, covariance, mine.a))
    return float(b @ b) - fall + power * (count + unsure), power * float(np.sqrt(2 * (count + unsure)))
