"""Evidence of sets of components in the linearised problem: Gaussian integrals.

With the nuisances marginalised, components of prior sd T have the information J =
TᵀCᵀΣ⁻¹CT and the score h, so that

    ln Z(set) − ln Z(nothing) = ½ hᵀ(I + J)⁻¹h − ½ ln det(I + J) + ln P(inside the
    physical range),

averaged over the widths of the priors and over sizes of the scatter between recordings.
Source: Kass & Raftery (1995), J. Am. Stat. Assoc. 90, 773.
"""

from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise

import numpy as np

from benchtwin.infer.linear import Reduced
from benchtwin.infer.physical_range import ln_within

PRIOR_WIDTHS = (3.0, 1.0, 0.3, 0.1, 0.03)  # of the prior on size, times its sd
UNLISTED_SNRS = (2.0, 6.0, 20.0, 60.0)  # signal-to-noise ratios of unlisted physics
SCATTER_SIZES = (0.5, 1.0, 2.0, 4.0, 8.0)  # times the usual scatter between recordings
SCATTER_SIZE_ODDS = (0.2, 0.6, 0.15, 0.04, 0.01)
NOISE_LEVELS = (
    -2.0,
    -1.0,
    0.0,
    1.0,
    2.0,
    3.0,
    4.5,
)  # sds of the logarithm of a noise power


class Kind(Enum):
    """A listed effect, or unlisted physics."""

    EFFECT = "effect"
    UNLISTED = "unlisted"


@dataclass(frozen=True, eq=False)
class Component:
    """A candidate as columns of the linearised problem."""

    name: str
    kind: Kind
    sector: str
    columns: np.ndarray  # (M, k)
    sd: np.ndarray  # (k,): prior of each column's coefficient
    scaled_prior: np.ndarray  # (k,): whether the prior widths act on it
    low: float = -np.inf  # this and high: physical range of the first coefficient
    high: float = np.inf


@dataclass(frozen=True, eq=False)
class EvidenceTable:
    """What a fit says of all components, for S sizes of scatter or noise power."""

    components: dict[str, Component]
    index: dict[str, np.ndarray]  # columns of each component
    ln_z_nothing: np.ndarray  # (S,): ln Z of nothing
    misfit: np.ndarray  # (S,): −½ χ² of nothing
    information: np.ndarray  # (S, C, C): J in prior sds
    right: np.ndarray  # (S, C): h in prior sds
    odds: np.ndarray  # (S,): ln prior of the size
    level_sd: float  # of the logarithm of the noise power
    estimated: bool = False  # whether `odds` are what these rows' residuals tell

    def ln_weight(self, names: tuple[str, ...]) -> np.ndarray:
        """ln weight (S,) of each size with these components free, as a test takes it:
        every size alike beforehand, so that what is averaged is Student's t."""
        return self.odds if self.estimated else self.by_scatter(names)[0] - self.odds

    def ln_evidence(self, names: tuple[str, ...]) -> tuple[float, float]:
        """ln Z of exactly this set, and −½ χ² where it fits best."""
        parts, misfit = self.by_scatter(names)
        return float(np.logaddexp.reduce(parts)), float(misfit[np.argmax(parts)])

    def by_scatter(self, names: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
        """(S,) each: the terms of ln Z, one a size of scatter, and −½ χ² with it."""
        if not names:
            return self.ln_z_nothing + self.odds, self.misfit
        at = np.concatenate([self.index[n] for n in names])
        parts = [self.components[n] for n in names]
        widths = _widths(parts)
        chosen = self.information[:, at][:, :, at][:, None]
        j = chosen * widths[:, :, None] * widths[:, None, :]
        h = self.right[:, at][:, None] * widths
        posterior = np.linalg.inv(j + np.eye(len(at)))
        mean = np.einsum("swij,swj->swi", posterior, h)
        fall = 0.5 * (h * mean).sum(-1)
        every = fall + 0.5 * np.linalg.slogdet(posterior)[1]
        every += _ln_in_range(parts, widths, mean, posterior)
        best = np.take_along_axis(fall, every.argmax(1)[:, None], 1)[:, 0]
        return np.logaddexp.reduce(every, axis=1) - np.log(
            len(widths)
        ) + self.ln_z_nothing + self.odds, self.misfit + best

    def estimate(
        self, names: tuple[str, ...], wide: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Mean (k,) and covariance of the set's coefficients, priors `wide` times
        wider."""
        at = np.concatenate([self.index[n] for n in names])
        parts = [self.components[n] for n in names]
        unit = np.concatenate([np.where(c.scaled_prior, wide, 1.0) for c in parts])
        sd = unit * np.concatenate([c.sd for c in parts])
        s = int(np.argmax(self.by_scatter(names)[0]))
        covariance = np.linalg.inv(
            self.information[s][np.ix_(at, at)] * np.outer(unit, unit) + np.eye(len(at))
        )
        return sd * (covariance @ (unit * self.right[s][at])), covariance * np.outer(
            sd, sd
        )


def table_of(
    reduced: tuple[Reduced, ...],
    prior_sd: np.ndarray,
    components: list[Component],
    spread: "UnknownScatter | None",
    level_sd: float,
) -> EvidenceTable:
    """prior_sd (G,): of the baseline's globals, 0 where fixed; spread: unknown size of
    scatter."""
    kept = prior_sd > 0
    a = np.vstack([r.a for r in reduced])[:, kept] * prior_sd[kept]
    b = np.concatenate([r.b for r in reduced])
    blocks = [c.columns * c.sd for c in components]
    every = np.hstack([a, *blocks, b[:, None]])
    sizes = spread or UnknownScatter()
    grams, ln_volume = sizes.grams(every, np.cumsum([0, *(len(r.b) for r in reduced)]))
    half_ln_det = sum(r.half_ln_det for r in reduced)
    n, ln_z_nothing, misfit, information, right = a.shape[1], [], [], [], []
    for gram, volume in zip(grams, ln_volume, strict=True):
        root = np.linalg.cholesky(gram[:n, :n] + np.eye(n))
        half = np.linalg.solve(root, gram[:n, n:])
        rest = gram[n:, n:] - half.T @ half
        misfit.append(-0.5 * rest[-1, -1])
        ln_z_nothing.append(
            misfit[-1] - np.log(np.diag(root)).sum() - volume - half_ln_det
        )
        information.append(rest[:-1, :-1])
        right.append(rest[:-1, -1])
    ends = np.cumsum([0, *(len(c.sd) for c in components)])
    index = {c.name: np.arange(ends[k], ends[k + 1]) for k, c in enumerate(components)}
    unit = np.ones(ends[-1])
    for c in components:
        if c.kind is Kind.UNLISTED:  # of a size that has an expected SNR of 1
            seen = float(np.diag(information[0])[index[c.name]].sum())
            unit[index[c.name]] = 1 / np.sqrt(seen) if seen > 0 else 0.0
    scaled = {c.name: replace(c, sd=c.sd * unit[index[c.name]]) for c in components}
    return EvidenceTable(
        scaled,
        index,
        np.array(ln_z_nothing),
        np.array(misfit),
        np.array(information) * np.outer(unit, unit),
        np.array(right) * unit,
        sizes.odds(len(ln_z_nothing)),
        level_sd,
        sizes.uncertain is not None,
    )


def refined_noise_power(
    reduced: tuple[Reduced, ...],
    prior_sd: np.ndarray,
    components: list[Component],
    level_sd: float,
) -> tuple[float, float]:
    """Noise power at low frequency over the recordings' estimate, and sd of its
    logarithm.

    From smooth curves of each recording beside all that is common, each a square of one
    degree of freedom; the prior `level_sd` is worth 2/level_sd² of them."""
    if level_sd <= 0 or any(not r.smooth.shape[1] for r in reduced):
        return 1.0, level_sd
    kept = prior_sd > 0
    a = np.vstack([r.a for r in reduced])[:, kept] * prior_sd[kept]
    b = np.concatenate([r.b for r in reduced])
    common = np.hstack([a, *(c.columns for c in components)])
    common = common / np.maximum(np.linalg.norm(common, axis=0), 1e-300)
    left = b - common @ np.linalg.lstsq(common, b, rcond=1e-6)[0]
    seen, square, count, first = [], 0.0, 0, 0
    for r in reduced:
        rows = slice(first, first + len(r.b))
        own, size, _ = np.linalg.svd(r.smooth, full_matrices=False)
        own = own[:, size > 1e-6 * size.max(initial=1e-300)]
        square = square + float(((own.T @ left[rows]) ** 2).sum())
        count = count + own.shape[1]
        first = rows.stop
        seen.append(own.T @ common[rows])
    count -= np.linalg.matrix_rank(np.vstack(seen), tol=1e-2)
    beforehand = 2 / level_sd**2
    if count < 1:
        return 1.0, level_sd
    return (beforehand + square) / (beforehand + count), float(
        np.sqrt(2 / (beforehand + count))
    )


@dataclass(frozen=True, eq=False)
class UnknownScatter:
    """What has an unknown size, over which evidence is summed."""

    # (M,): rows' change by one usual sd of a parameter
    direction: np.ndarray | None = None
    # (M,): rows whose noise power is known to level_sd only
    uncertain: np.ndarray | None = None
    level_sd: float = 0.0

    def odds(self, count: int) -> np.ndarray:
        """ln prior of each of `count` sizes."""
        if count == 1:
            return np.zeros(1)
        if self.uncertain is None:
            return np.log(SCATTER_SIZE_ODDS)
        weight = np.exp(-0.5 * np.array(NOISE_LEVELS) ** 2) * np.gradient(
            np.array(NOISE_LEVELS)
        )
        return np.log(weight / weight.sum())

    def grams(
        self, every: np.ndarray, cuts: np.ndarray
    ) -> tuple[list[np.ndarray], list[float]]:
        """Gram matrices of the rows (M, k) for each size, and ln of the noise volume
        added."""
        if self.uncertain is not None and self.uncertain.any():
            fixed, free = every[~self.uncertain], every[self.uncertain]
            powers = [np.exp(self.level_sd * x) for x in NOISE_LEVELS]
            volumes = [0.5 * len(free) * self.level_sd * x for x in NOISE_LEVELS]
            return [fixed.T @ fixed + free.T @ free / p for p in powers], volumes
        parts = [every[low:high] for low, high in pairwise(cuts)]
        plain = sum(p.T @ p for p in parts)
        if self.direction is None or len(parts) < 3:
            return [plain], [0.0]
        own = [self.direction[low:high] for low, high in pairwise(cuts)]
        # rows that hold the usual scatter change by 1 at most; their noise power is
        # refined apart
        own = [v / max(float(np.linalg.norm(v)), 1.0) for v in own]
        along = np.array([p.T @ v for p, v in zip(parts, own, strict=True)])
        power = np.array([v @ v for v in own])
        grams, volumes = [], []
        for size in SCATTER_SIZES:
            more = size**2 - 1
            weight = more / (1 + more * power)
            grams.append(plain - (along.T * weight) @ along)
            volumes.append(0.5 * float(np.log1p(more * power).sum()))
        return grams, volumes


def _ln_in_range(
    parts: list[Component], widths: np.ndarray, mean: np.ndarray, spread: np.ndarray
) -> np.ndarray:
    """ln P(inside the physical ranges) (S, W) after over that before the rows were
    seen; mean (S, W, k) and covariance `spread` (S, W, k, k) in prior sds."""
    first = np.cumsum([0, *(len(p.sd) for p in parts)])
    limits = [
        (at, p.low, p.high, p.sd[0])
        for at, p in zip(first, parts, strict=False)
        if np.isfinite(p.low) or np.isfinite(p.high)
    ]
    if not limits:
        return np.zeros(mean.shape[:2])
    at, low, high, unit = map(np.array, zip(*limits, strict=True))
    sd = unit * widths[:, at]
    to_units = sd[:, :, None] * sd[:, None, :]
    after = spread[:, :, at[:, None], at] * to_units
    before = np.eye(len(at)) * to_units
    return ln_within(sd * mean[..., at], after, low, high) - ln_within(
        np.zeros_like(sd), before, low, high
    )


def _widths(parts: list[Component]) -> np.ndarray:
    """Factors (W, k) on prior sds: all combinations for two components, joint steps for
    more."""
    rows = np.zeros((1, 0))
    for part in parts:
        choices = UNLISTED_SNRS if part.kind is Kind.UNLISTED else PRIOR_WIDTHS
        if len(parts) > 2:
            step = (
                np.linspace(0, len(choices) - 1, len(PRIOR_WIDTHS)).round().astype(int)
            )
            own = np.where(
                part.scaled_prior[None, :], np.array(choices)[step, None], 1.0
            )
            rows = np.hstack([np.broadcast_to(rows, (len(own), rows.shape[1])), own])
        else:
            own = np.where(part.scaled_prior[None, :], np.array(choices)[:, None], 1.0)
            rows = np.hstack(
                [np.repeat(rows, len(own), axis=0), np.tile(own, (len(rows), 1))]
            )
    return rows


def student_ln_likelihood(misfit: float, level_sd: float) -> float:
    """−½ (ν + 1) ln(1 + χ²/ν), ν = 2/level_sd², for the misfit −½ χ² (Student's t)."""
    if level_sd <= 0:
        return misfit
    freedom = 2 / level_sd**2
    return -0.5 * (freedom + 1) * float(np.log1p(max(-2 * misfit, 0.0) / freedom))
