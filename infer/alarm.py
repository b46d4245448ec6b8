"""The alarm: how often would noise alone make as great a mismatch as is seen?

Beside an explanation every other component is tested: by how much would it lower χ²?
Its score h is normal with the covariance J where nothing else is missing, so that this
fall is χ² of the rank of J; a fit in full may add to it. The least of all these p
values is compared with its own distribution, drawn with the J of all components, and
with independent p values for what has no score. So p is uniform where nothing is
missing, however many components there are and however alike. Sources: Rao (1948), Math.
Proc. Cambridge Philos. Soc. 44, 50; Westfall & Young (1993), Resampling-Based Multiple
Testing."""

from collections.abc import Iterable

import numpy as np
from benchtwin.infer.evidence import EvidenceTable
from benchtwin.infer.explanation import Explanation, Posterior
from benchtwin.infer.linear import chance
from benchtwin.infer.posterior import WIDE_PRIOR
from scipy import stats

ALARM_P = 0.005  # below which there is an alarm
UNLIKELY = 0.01  # weight of a size of scatter below which it is skipped
HIDDEN_POWER = 1e-6  # relative power of a direction that the nuisances absorb
LEVELS = 15  # quantiles of the noise power, over which p is averaged
DRAWS = 20_000
DRAWS_BESIDE = 1_000  # beside an explanation that holds something


def p_global(posterior: Posterior, rng: np.random.Generator) -> float:
    """p of nothing missing, averaged over the baselines by their weight."""
    weight = np.array([max(base.probability, 1e-300) for base in posterior.bases])
    named = [
        _p_named(posterior, k)
        for k, a in enumerate(posterior.alternatives)
        if a.effects
    ]
    ps = [
        left_over_p(base, rng, fits=_falls_of_fits(posterior, base), more=named)
        for base in posterior.bases
    ]
    return float(weight / weight.sum() @ ps)


def left_over_p(
    e: Explanation,
    rng: np.random.Generator,
    *,
    sector: str | None = None,
    fits: dict[str, float] | None = None,
    more: Iterable[float] = (),
) -> float:
    """How often noise alone leaves as much beside an explanation, in one sector or all.

    fits: by how much effects lower χ² when they are fitted in full; more: p values of
    tests of their own."""
    table, fits, own = e.table, fits or {}, list(more)
    asked = {
        n: c
        for n, c in table.components.items()
        if n not in e.names and len(c.sd) and sector in (None, c.sector)
    }
    quantiles = (np.arange(LEVELS) + 0.5) / LEVELS
    doubt = np.exp(table.level_sd * stats.norm.ppf(quantiles))
    bent = [n for n in fits if n in asked and e.fit.problem.effects[n].nonlinear]
    own += [chance(fits[n], len(asked[n].sd), doubt) for n in bent]
    draws, total = DRAWS_BESIDE if e.names else DRAWS, 0.0
    for weight, s in _scatter_weights(e):
        falls, ranks, drawn = _falls(table, s, e.names, list(asked), rng, draws)
        seen = np.maximum(
            falls, [0.0 if n in bent else fits.get(n, 0.0) for n in asked]
        )
        least = min([1.0, *(chance(*one, doubt) for one in zip(seen, ranks) if one[1])])
        least = min([least, *own])
        at_least = _least_p(drawn, ranks, doubt)
        scores = float((1 + (at_least <= least).sum()) / (1 + draws))
        scores = min(scores, max(len(asked), 1) * least)  # beyond the draws: a bound
        with np.errstate(divide="ignore"):
            none = np.log1p([-min(scores, 1.0), *len(own) * [-least]]).sum()
        total -= weight * float(np.expm1(none))
    return float(min(total, 1.0))


def _least_p(drawn: np.ndarray, ranks: np.ndarray, doubt: np.ndarray) -> np.ndarray:
    """The least p (D,) of falls (D, C) with these ranks."""
    out = np.ones(len(drawn))
    for rank in set(ranks[ranks > 0]):
        greatest = drawn[:, ranks == rank].max(axis=1)
        grid = np.linspace(0, greatest.max(), 400)
        p = stats.chi2.sf(grid[:, None] / doubt, rank).mean(axis=1)
        out = np.minimum(out, np.interp(greatest, grid, p))
    return out


def _falls(
    table: EvidenceTable,
    s: int,
    names: tuple[str, ...],
    asked: list[str],
    rng: np.random.Generator,
    draws: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The fall of χ² (C,) by each component beside `names`, its rank, and draws of the
    falls (D, C) that noise makes."""
    information, right = table.information[s], table.right[s]
    held = np.concatenate([np.zeros(0, int), *(table.index[n] for n in names)])
    solved = np.linalg.solve(
        information[np.ix_(held, held)] + np.eye(len(held)) / WIDE_PRIOR**2,
        np.column_stack([information[held], right[held]]),
    )
    across = information[:, held]
    beside = information - across @ solved[:, :-1]
    score = right - across @ solved[:, -1]
    falls, ranks, columns = np.zeros(len(asked)), np.zeros(len(asked), int), []
    for k, at in enumerate(table.index[n] for n in asked):
        values, vectors = np.linalg.eigh(beside[np.ix_(at, at)])
        kept = values > HIDDEN_POWER * max(np.diag(information)[at].max(), 1e-300)
        one = np.zeros((len(score), int(kept.sum())))
        one[at] = vectors[:, kept] / np.sqrt(values[kept])
        falls[k], ranks[k] = float(((one.T @ score) ** 2).sum()), one.shape[1]
        columns.append(one)
    mixed = np.hstack([np.zeros((len(score), 0)), *columns])
    values, vectors = np.linalg.eigh(mixed.T @ beside @ mixed)
    root = vectors * np.sqrt(np.maximum(values, 0))
    level = np.exp(table.level_sd * rng.standard_normal(draws))
    squares = (rng.standard_normal((draws, len(values))) @ root.T) ** 2
    drawn = np.zeros((draws, len(asked)))
    for k, end in enumerate(np.cumsum(ranks)):
        drawn[:, k] = squares[:, end - ranks[k] : end].sum(axis=1) * level
    return falls, ranks, drawn


def _falls_of_fits(posterior: Posterior, base: Explanation) -> dict[str, float]:
    """By how much single effects lower χ² when they are fitted in full."""
    return {
        e.names[0]: max(base.fit.chi2 - e.fit.chi2, 0.0) / base.power
        for e in posterior.explanations
        if e.alternative == base.alternative
        and len(e.names) == 1
        and e.names == e.listed
        and e.fit is not base.fit
    }


def _p_named(posterior: Posterior, number: int) -> float:
    """Of an effect that is an alternative baseline: its own p, or from its fall of
    χ²."""
    own = posterior.alternatives[number]
    if own.p is not None:
        return own.p
    for e in posterior.explanations:
        if e.alternative == number and set(e.names) == set(own.effects):
            nothing = max(b.table.ln_evidence(())[1] for b in posterior.bases)
            fall = 2 * (e.table.ln_evidence(own.effects)[1] - nothing)
            return float(stats.chi2.sf(max(fall, 0.0), 1 + len(e.reduced)))
    return 1.0


def _scatter_weights(e: Explanation) -> list[tuple[float, int]]:
    """Weight of each size of scatter with the explanation, without the unlikely
    ones."""
    ln_weight = e.table.by_scatter(e.names)[0]
    weight = np.exp(ln_weight - ln_weight.max())
    weight = np.where(weight > UNLIKELY * weight.sum(), weight, 0.0)
    return [(float(w / weight.sum()), s) for s, w in enumerate(weight) if w]
