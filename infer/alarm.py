"""The alarm: how often would noise alone make as great a mismatch as is seen?

Beside an explanation every other component is tested: by how much would it lower χ²?
Its score h is normal with the covariance J where nothing else is missing, so that this
fall is χ² of the rank of J; a fit in full may add to it. The least of all these p
values is compared with its own distribution, drawn with the J of all components, and
with independent p values for what has no score. So p is uniform where nothing is
missing and noise and scatter are as modelled, however many components there are and
however alike. Sources: Rao (1948), Math. Proc. Cambridge Philos. Soc. 44, 50; Westfall
& Young (1993), Resampling-Based Multiple Testing."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from benchtwin.bench import distributions as stats
from benchtwin.infer.evidence import Component, EvidenceTable
from benchtwin.infer.explanation import Explanation, Posterior
from benchtwin.infer.linear import chance
from benchtwin.infer.posterior import WIDE_PRIOR

# below which there is an alarm: of 364 benches in which nothing is missing (real ones,
# and drawn by others) 5 % have a p below 0.005 and 2 % one below this
ALARM_P = 0.001
UNLIKELY = 0.01  # weight of a size of scatter below which it is skipped
HIDDEN_POWER = 1e-6  # relative power of a direction that the nuisances absorb
LEVELS = 15  # quantiles of the noise power, over which p is averaged
DRAWS = 20_000
DRAWS_BESIDE = 1_000  # beside an explanation that holds something, or of a sector


@dataclass(frozen=True, eq=False)
class Fitted:
    """An effect fitted in full: falls (S,) of χ² and ln weight (S,) for each size of
    scatter."""

    falls: np.ndarray
    ln_weight: np.ndarray


def p_global(posterior: Posterior, rng: np.random.Generator) -> float:
    """p of nothing missing, averaged over the baselines by their weight."""
    weight = np.array([max(base.probability, 1e-300) for base in posterior.bases])
    named = [
        _p_named(posterior, k)
        for k, a in enumerate(posterior.alternatives)
        if a.effects
    ]
    ps = [
        left_over_p(base, rng, fits=_fitted(posterior, base), more=named)
        for base in posterior.bases
    ]
    return float(weight / weight.sum() @ ps)


def left_over_p(
    e: Explanation,
    rng: np.random.Generator,
    *,
    sector: str | None = None,
    fits: Mapping[str, Fitted] | None = None,
    more: Iterable[float] = (),
) -> float:
    """How often noise alone leaves as much beside an explanation, in one sector or all.

    A component's p, one-sided where it has one sign only, is averaged over the sizes of
    scatter by their weight with that component free, as Student's t takes its variance
    from what a slope leaves. fits: effects fitted in full; more: p values of tests of
    their own."""
    table, fits, own = e.table, fits or {}, list(more)
    beside = {
        n: c
        for n, c in table.components.items()
        if n not in e.names and len(c.sd) and sector in (None, c.sector)
    }
    # of these the score at 0 does not tell what a fit in full finds
    bent = [n for n in fits if n in beside and e.fit.problem.effects[n].nonlinear]
    asked = {n: c for n, c in beside.items() if n not in bent}
    quantiles = (np.arange(LEVELS) + 0.5) / LEVELS
    doubt = np.exp(table.level_sd * stats.norm.ppf(quantiles))
    scores = [_scores(table, s, e.names, asked) for s in range(len(table.odds))]
    least = 1.0
    for k, n in enumerate(asked):
        weights = _weights(table.ln_weight((*e.names, n)))
        least = min(least, sum(w * scores[s].p(k, doubt) for w, s in weights))
    for n in fits.keys() & beside.keys():
        fit, freedom = fits[n], len(beside[n].sd)
        weights = _weights(fit.ln_weight)
        p = sum(w * chance(fit.falls[s], freedom, doubt) for w, s in weights)
        if n in bent:
            own.append(p)
        else:
            least = min(least, p)
    least, total = min([least, *own]), 0.0
    draws = DRAWS_BESIDE if e.names or sector else DRAWS
    for weight, s in _weights(table.ln_weight(e.names)):
        at_least = _least_p(scores[s], table.level_sd, doubt, rng, draws)
        chosen = float((1 + (at_least <= least).sum()) / (1 + draws))
        chosen = min(chosen, max(len(asked), 1) * least)  # beyond the draws: a bound
        with np.errstate(divide="ignore"):
            none = np.log1p([-min(chosen, 1.0), *len(own) * [-least]]).sum()
        total -= weight * float(np.expm1(none))
    return float(min(total, 1.0))


@dataclass(frozen=True, eq=False)
class Scores:
    """Of C components. falls (C,): of χ² by each, 0 where an effect that has one sign
    only would need the other; ranks (C,), 0 of what is not seen; signs (C,): ±1 of
    effects with one sign, else 0; root (R, R): of the covariance of all their scores.
    """

    falls: np.ndarray
    ranks: np.ndarray
    signs: np.ndarray
    root: np.ndarray

    def p(self, k: int, doubt: np.ndarray) -> float:
        """How often noise alone lowers χ² as much by component k."""
        if not self.ranks[k] or (self.signs[k] and not self.falls[k]):
            return 1.0
        p = chance(self.falls[k], self.ranks[k], doubt)
        return p / 2 if self.signs[k] else p


def _scores(
    table: EvidenceTable, s: int, names: tuple[str, ...], asked: dict[str, Component]
) -> Scores:
    """Of components beside `names`, for one size of scatter."""
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
    signs = np.zeros(len(asked))
    for k, (name, component) in enumerate(asked.items()):
        at = table.index[name]
        values, vectors = np.linalg.eigh(beside[np.ix_(at, at)])
        kept = values > HIDDEN_POWER * max(np.diag(information)[at].max(), 1e-300)
        one = np.zeros((len(score), int(kept.sum())))
        one[at] = vectors[:, kept] / np.sqrt(values[kept])
        if len(at) == 1:
            one = np.abs(one)
            signs[k] = float(component.low >= 0) - float(component.high <= 0)
        seen = one.T @ score
        falls[k] = float((seen[signs[k] * seen >= 0] ** 2).sum())
        ranks[k] = one.shape[1]
        columns.append(one)
    mixed = np.hstack([np.zeros((len(score), 0)), *columns])
    values, vectors = np.linalg.eigh(mixed.T @ beside @ mixed)
    return Scores(falls, ranks, signs, vectors * np.sqrt(np.maximum(values, 0)))


def _least_p(
    of: Scores,
    level_sd: float,
    doubt: np.ndarray,
    rng: np.random.Generator,
    draws: int,
) -> np.ndarray:
    """The least p (D,) of draws in which there is only noise."""
    level = np.exp(level_sd * rng.standard_normal(draws))
    drawn = rng.standard_normal((draws, len(of.root))) @ of.root.T
    greatest: dict[tuple[int, bool], np.ndarray] = {}
    for rank, sign, end in zip(of.ranks, of.signs, np.cumsum(of.ranks), strict=True):
        own = drawn[:, end - rank : end]
        fall = (np.where(sign * own >= 0, own, 0.0) ** 2).sum(axis=1) * level
        alike = int(rank), bool(sign)
        greatest[alike] = np.maximum(greatest.get(alike, 0.0), fall)
    out = np.ones(draws)
    for (rank, one_sided), fall in greatest.items():
        if not rank:
            continue
        grid = np.linspace(0, fall.max(), 400)
        p = stats.chi2.sf(grid[:, None] / doubt, rank).mean(axis=1)
        p = np.where(grid > 0, p / 2, 1.0) if one_sided else p
        out = np.minimum(out, np.interp(fall, grid, p))
    return out


def _fitted(posterior: Posterior, base: Explanation) -> dict[str, Fitted]:
    """The single effects that were fitted in full."""
    nothing = base.table.by_scatter(())[1]

    def of(e: Explanation) -> Fitted:
        fall = 2 * (e.table.by_scatter(e.names)[1] - nothing)
        return Fitted(np.maximum(fall, 0.0), e.table.ln_weight(e.names))

    return {
        e.names[0]: of(e)
        for e in posterior.explanations
        if e.alternative == base.alternative
        and len(e.names) == 1
        and e.names == e.listed
        and e.fit is not base.fit
    }


def _p_named(posterior: Posterior, number: int) -> float:
    """Of an effect that is an alternative baseline: its own p, or 1/B, the bound on how
    often noise alone gives a Bayes factor of B and more (Markov's inequality)."""
    own = posterior.alternatives[number]
    if own.p is not None:
        return own.p
    for e in posterior.explanations:
        if e.alternative == number and set(e.names) == set(own.effects):
            nothing = max(b.table.ln_evidence(())[0] for b in posterior.bases)
            return float(np.exp(min(nothing - e.table.ln_evidence(own.effects)[0], 0)))
    return 1.0


def _weights(ln_weight: np.ndarray) -> list[tuple[float, int]]:
    """Weight of each size of scatter, without the unlikely ones."""
    weight = np.exp(ln_weight - ln_weight.max())
    weight = np.where(weight > UNLIKELY * weight.sum(), weight, 0.0)
    return [(float(w / weight.sum()), s) for s, w in enumerate(weight) if w]
