"""The verdict, read off the posterior: nothing, a name, a class, or unknown; and what it makes of every effect and parameter."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from scipy import stats

from diagnose.engine.alarm import ALARM_P
from diagnose.engine.posterior import WEAK, Explanation, Posterior

HOLDS = 0.95  # of the weight of what is missing, for a name or a class
NAMED = 0.8  # of all, for a name with nothing unlisted beside it
HALF = 0.5
MATTERS_SDS = 0.5  # of a contact parameter
QUANTILES = (0.025, 0.5, 0.975)


@dataclass(frozen=True)
class Interval:
    """A value with its 95 % interval."""

    value: float
    low95: float
    high95: float


@dataclass(frozen=True)
class Told:
    """One effect: probability that it is there, its size where it is, averaged over explanations, in its reported unit; levels: of
    a condition in words the parameter at each, beside their mean."""

    probability: float
    unit: str
    size: Interval
    levels: dict[str, Interval] = field(default_factory=dict)


@dataclass(frozen=True)
class Moved:
    """A contact parameter with nothing missing, and averaged over all explanations; shift in sds of the former."""

    nothing_missing: Interval
    explained: Interval

    @property
    def shift_sds(self) -> float:
        half = (self.nothing_missing.high95 - self.nothing_missing.low95) / 2 / stats.norm.ppf(QUANTILES[2])
        return (self.explained.value - self.nothing_missing.value) / half if half > 0 else 0.0


@dataclass(frozen=True)
class Verdict:
    """verdict: none | name | class | unknown, with names; probability: its weight."""

    verdict: str
    names: tuple[str, ...]
    probability: float


def verdict_of(posterior: Posterior, p_global: float) -> Verdict:
    """none: no alarm, or nothing missing holds half of the weight. Of the explanations in which something is missing: unknown where
    more than half of the weight needs something unlisted; the name of the likeliest listed set where it, alone or beside more, holds
    HOLDS of that weight, or NAMED of all with nothing unlisted beside it; else, as a class, that set where a part of it is certain,
    or the fewest names of which one at least holds HOLDS of the weight of what is listed."""
    nothing = posterior.probability(())
    if p_global >= ALARM_P or nothing >= HALF:
        return Verdict("none", (), nothing)
    found = [e for e in posterior.explanations if e.names]
    weight = sum(e.probability for e in found)
    strange = sum(e.probability for e in found if e.unlisted) / weight
    presence = {n: sum(e.probability for e in found if n in e.listed) / weight for n in {n for e in found for n in e.listed}}
    ranked = sorted(presence, key=lambda n: (-presence[n], n))
    if strange > HALF:
        return Verdict("unknown", tuple(n for n in ranked if presence[n] >= HOLDS), strange)
    best = max((e.names for e in found if not e.unlisted), key=posterior.probability)
    holding = [e for e in found if set(best) <= set(e.listed)]
    held = sum(e.probability for e in holding) / weight
    plain = sum(e.probability for e in holding if not e.unlisted)
    alone = len(posterior.base.fit.problem.recordings) < 2  # nothing is held out: no name for certain
    if (held >= HOLDS or plain >= NAMED) and not alone:
        return Verdict("name", tuple(n for n in ranked if n in best), sum(e.probability for e in holding))
    if any(presence[n] >= HOLDS for n in best):
        return Verdict("class", tuple(n for n in ranked if n in best), held)
    names, left = [], [e for e in found if e.listed]
    whole, reached = sum(e.probability for e in left), 0.0
    while left and reached < HOLDS * whole:
        shares = {n: sum(e.probability for e in left if n in e.listed) for e in left for n in e.listed}
        names.append(max(sorted(shares), key=lambda n: shares[n]))
        left = [e for e in left if names[-1] not in e.listed]
        reached = sum(e.probability for e in found if set(names) & set(e.listed))
    return Verdict("class", tuple(names), reached / weight)


def mixture(parts: list[tuple[float, float, float]]) -> Interval:
    """Quantiles of a mixture of normals, (weight, mean, sd) each."""
    weight, mean, sd = (np.array(column) for column in zip(*parts, strict=True))
    weight, sd = weight / weight.sum(), np.maximum(sd, 1e-12 * (1 + np.abs(mean)))
    low, high = (mean - 8 * sd).min(), (mean + 8 * sd).max()
    ends = []
    for q in QUANTILES:
        a, b = low, high
        for _ in range(60):
            middle = (a + b) / 2
            a, b = (middle, b) if float(weight @ stats.norm.cdf((middle - mean) / sd)) < q else (a, middle)
        ends.append((a + b) / 2)
    return Interval(float(weight @ mean), ends[0], ends[2])


def told_of(posterior: Posterior, name: str) -> Told:
    """One listed effect, averaged over the explanations that hold it."""
    holding = [e for e in posterior.explanations if name in e.names]
    present = sum(e.probability for e in holding)
    own = posterior.alternatives[holding[0].alternative]
    if name in own.named:
        unit, value, sd = own.sizes.get(name, ("", np.nan, np.nan))
        return Told(present, unit, mixture([(1.0, value, sd)]) if np.isfinite(value) else Interval(np.nan, np.nan, np.nan))
    effect = holding[0].fit.problem.effects[name]
    weighty = [e for e in holding if e.probability > 1e-4 * holding[0].probability]

    def averaged(of: Callable[[Explanation], tuple[float, float]]) -> Interval:
        size, shown = mixture([(e.probability, *of(e)) for e in weighty]), effect.reported or float
        return Interval(shown(size.value), *sorted((shown(size.low95), shown(size.high95))))

    problem = holding[0].fit.problem
    levels = [problem.effects[n].level for n in problem.columns_of(name)] if effect.level else []
    each = {level: averaged(partial(at_level, name=name, number=k)) for k, level in enumerate(levels)}
    return Told(present, effect.unit, averaged(partial(estimate, name=name)), each)


def estimate(e: Explanation, name: str) -> tuple[float, float]:
    """Mean and sd of an effect's parameter within one explanation; the noise's own doubt widens it, and what a good bench leaves
    open of the same (a plumb line's 0.05°), for that is no effect."""
    effect = e.fit.problem.effects[name]
    if effect.summary:
        return effect.summary(e)
    return _combined(e, name, np.eye(len(e.table.spot[name]))[0])


def at_level(e: Explanation, name: str, number: int) -> tuple[float, float]:
    """Mean and sd of a parameter at one level of a condition in words, beside the mean of all levels."""
    count = len(e.table.spot[name])
    return _combined(e, name, np.eye(count)[number] - 1 / count)


def _combined(e: Explanation, name: str, of: np.ndarray) -> tuple[float, float]:
    """Mean and sd of a linear combination (k,) of an effect's columns."""
    mean, covariance = e.table.estimate(e.names, WEAK)
    first = sum(len(e.table.spot[k]) for k in e.names[: e.names.index(name)])
    own = slice(first, first + len(of))
    return float(of @ mean[own]), float(np.exp(e.table.level_sd**2 / 2) * np.sqrt(of @ covariance[own, own] @ of))


def moved_of(posterior: Posterior, value: Callable[[Explanation], tuple[float, float]]) -> Moved:
    """A contact parameter; value(explanation) → its mean and sd there."""
    def told(e: Explanation, weight: float) -> tuple[float, float, float]:
        mean, sd = value(e)
        return weight, mean, sd * float(np.sqrt(e.power))

    base = posterior.base
    every = [told(e, e.probability) for e in posterior.explanations if e.probability > 1e-3] or [told(base, 1.0)]
    return Moved(mixture([told(base, 1.0)]), mixture(every))


def sector_shares(posterior: Posterior) -> dict[str, float]:
    """Of the weight with something missing, the part of each sector; an explanation's parts count by the ln evidence that each
    adds to the others."""
    out: dict[str, float] = {}
    found = [e for e in posterior.explanations if e.names]
    weight = sum(e.probability for e in found)
    for e in found:
        whole = e.table.ln_evidence(e.names)[0]
        gains = [max(whole - e.table.ln_evidence(tuple(n for n in e.names if n != m))[0], 1e-3) for m in e.names]
        for n, gain in zip(e.names, gains, strict=True):
            sector = e.table.components[n].sector
            out[sector] = out.get(sector, 0.0) + e.probability / weight * gain / sum(gains)
    return out
