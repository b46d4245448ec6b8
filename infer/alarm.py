"""The alarm: could noise alone produce the greatest score of all listed and unlisted
components?

A column c has the score z = cᵀPb/√(cᵀPc), P marginalising the nuisances: normal where
nothing is missing. The maximum over all columns is compared with a parametric
bootstrap, unlisted physics by its fall of χ². Source: Rao (1948), Math. Proc. Cambridge
Philos. Soc. 44, 50."""

import numpy as np
from benchtwin.infer.evidence import EvidenceTable, Kind
from benchtwin.infer.explanation import Explanation, Posterior
from benchtwin.infer.linear import chance
from benchtwin.infer.noise import maximum_draws
from scipy import stats

ALARM_P = 0.005  # below which there is an alarm
UNLIKELY = 0.01  # weight of a size of scatter below which it is skipped
HIDDEN_POWER = 1e-10  # relative power of a column that the nuisances absorb


def p_global(posterior: Posterior, rng: np.random.Generator) -> float:
    """p value, averaged over the alternatives by their weight with nothing missing."""
    weight = np.array([max(base.probability, 1e-300) for base in posterior.bases])
    ps = [
        (baseline_p(base, rng), _p_fitted(posterior, base, rng))
        for base in posterior.bases
    ]
    plain = float(weight / weight.sum() @ [min(1.0, 2 * min(p)) for p in ps])
    named = [
        _p_named(posterior, k)
        for k, a in enumerate(posterior.alternatives)
        if a.effects
    ]
    return float(min([1.0, (1 + len(named)) * min([plain, *named])]))


def _p_fitted(
    posterior: Posterior, base: Explanation, rng: np.random.Generator
) -> float:
    """Of single effects fitted in full, by their fall of χ²; Bonferroni over the listed
    ones."""
    table = base.table
    found, doubt = [1.0], np.exp(table.level_sd * rng.standard_normal(2000))
    for e in posterior.explanations:
        if (
            e.alternative == base.alternative
            and len(e.names) == 1
            and e.names == e.listed
            and e.fit is not base.fit
        ):
            fall = max(base.fit.chi2 - e.fit.chi2, 0.0) / base.power
            found.append(chance(fall, len(table.index[e.names[0]]), doubt))
    return min(
        1.0,
        sum(c.kind is not Kind.UNLISTED for c in table.components.values())
        * min(found),
    )


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


def baseline_p(
    base: Explanation, rng: np.random.Generator, sector: str | None = None
) -> float:
    """Of one baseline, in one sector or all; Bonferroni over listed and unlisted."""
    table = base.table
    asked = {n: c for n, c in table.components.items() if sector in (None, c.sector)}
    listed = [n for n, c in asked.items() if c.kind is not Kind.UNLISTED]
    groups = [n for n, c in asked.items() if c.kind is Kind.UNLISTED]
    both = _p_listed(table, listed, rng), _p_unlisted(table, groups, rng)
    ps = [p for p in both if p is not None]
    return float(min(1.0, len(ps) * min(ps))) if ps else 1.0


def _scatter_weights(table: EvidenceTable) -> list[tuple[float, int]]:
    """Weight of each size of scatter with nothing missing, without the unlikely
    ones."""
    weight = np.exp(
        table.ln_z_nothing + table.odds - (table.ln_z_nothing + table.odds).max()
    )
    weight = np.where(weight > UNLIKELY * weight.sum(), weight, 0.0)
    return [(float(w / weight.sum()), s) for s, w in enumerate(weight) if w]


def _p_listed(
    table: EvidenceTable, names: list[str], rng: np.random.Generator
) -> float | None:
    every = np.concatenate([table.index[n] for n in names] or [np.zeros(0, dtype=int)])
    total = 0.0
    for weight, s in _scatter_weights(table):
        information, right = table.information[s], table.right[s]
        at = every[np.diag(information)[every] > HIDDEN_POWER]
        if not len(at):
            return None
        size = np.sqrt(np.diag(information)[at])
        draws = maximum_draws(
            information[np.ix_(at, at)] / np.outer(size, size),
            rng,
            level_sd=table.level_sd,
        )
        total += weight * float(
            (1 + (draws >= np.abs(right[at] / size).max()).sum()) / (1 + len(draws))
        )
    return total


def _p_unlisted(
    table: EvidenceTable, names: list[str], rng: np.random.Generator
) -> float | None:
    """The least p over groups of unlisted columns, times their number."""
    doubt = np.exp(table.level_sd * rng.standard_normal(2000))
    found = [0.0] * len(names)
    for weight, s in _scatter_weights(table):
        for k, at in enumerate(table.index[n] for n in names):
            values, vectors = np.linalg.eigh(table.information[s][np.ix_(at, at)])
            kept = values > 1e-6 * max(values.max(initial=0.0), HIDDEN_POWER)
            fall = float(
                ((vectors[:, kept].T @ table.right[s][at]) ** 2 / values[kept]).sum()
            )
            found[k] += weight * chance(fall, max(int(kept.sum()), 1), doubt)
    return min(1.0, len(found) * min(found)) if found else None
