"""The verdict from the posterior, and estimates of every effect and contact
parameter."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy import stats
from scipy.optimize import brentq

from benchtwin.infer.alarm import ALARM_P, left_over_p, p_global
from benchtwin.infer.explanation import Explanation, Posterior
from benchtwin.infer.posterior import WIDE_PRIOR

NAME_PROBABILITY = 0.8  # that a set is missing, alone or with more, for a name
ALONE_PROBABILITY = 0.5  # that it is this set and nothing else, for a name
NAME_SHARE = 0.95  # of the listed explanations, for a class
EQUAL = 0.01  # share by which probabilities of one law may differ by rounding
SMALL_SHARE = 0.01  # of what may be missing, beside which nothing further is weighed
MATTERS_SDS = 0.5  # shift of a contact parameter that matters
ENDS = (0.025, 0.975)  # of a 95 % interval
EVERYWHERE = (-math.inf, math.inf)


@dataclass(frozen=True)
class Interval:
    """A value with its 95 % interval."""

    value: float
    low95: float
    high95: float


@dataclass(frozen=True)
class EffectEstimate:
    """Probability of an effect, and its size given that it is there, as reported."""

    probability: float
    unit: str
    size: Interval


@dataclass(frozen=True)
class ParameterShift:
    """A contact parameter with nothing missing, and averaged over all explanations."""

    nothing_missing: Interval
    explained: Interval

    @property
    def shift_sds(self) -> float:
        """The shift in sds of the former."""
        both = self.nothing_missing.high95 - self.nothing_missing.low95
        half = (both) / 2 / stats.norm.ppf(ENDS[1])
        if half > 0:
            return (self.explained.value - self.nothing_missing.value) / half
        return 0.0


@dataclass(frozen=True)
class Verdict:
    """verdict: none | name | class | unknown; names; probability of exactly what the
    verdict says."""

    verdict: str
    names: tuple[str, ...]
    probability: float


def against_noise(p: float) -> float:
    """By how much a p value favours that something is missing: its density then.

    Where nothing is missing p is uniform; else its density is ξ p^(ξ−1), the more at 0
    the smaller ξ, which is uniform between 0 and 1. Source: Sellke, Bayarri & Berger
    (2001), Am. Stat. 55, 62; Vovk & Wang (2021), Ann. Stat. 49, 1736."""
    p = min(max(p, 1e-300), 1 - 1e-6)
    return float((1 - p + p * np.log(p)) / (p * np.log(p) ** 2))


def least_of(tests: int, p: float) -> float:
    """How often the least p of so many independent tests is as small."""
    return -math.expm1(tests * math.log1p(-min(p, 1 - 1e-12)))


# Prior odds of something of no shape that was tried, beside what is missing: at the
# alarm's level it is then as probable as that there is no more.
UNSHAPED_ODDS = 1 / against_noise(ALARM_P)


def weighed_with_noise(
    posterior: Posterior, rng: np.random.Generator, tests: int = 1
) -> Posterior:
    """The posterior with what noise alone would do as evidence; tests: of the same
    bench, of which this is one.

    What is missing by an explanation is all, or there is something of no shape that was
    tried beside it, whose odds are UNSHAPED_ODDS times what the p of all that the
    explanation leaves says (alarm.left_over_p): an explanation that does not hold the
    alarm is one with something unlisted. See `bounded` for nothing missing."""
    p = least_of(tests, p_global(posterior, rng))
    missing = sum(e.probability for e in posterior.explanations if e.names)

    def and_more(e: Explanation) -> float:
        if not e.names or e.unlisted or e.probability < SMALL_SHARE * missing:
            return 0.0
        return e.probability * UNSHAPED_ODDS * against_noise(left_over_p(e, rng))

    found = [replace(e, and_more=and_more(e)) for e in posterior.explanations]
    return bounded(replace(posterior, explanations=tuple(found), p_noise=p))


def bounded(posterior: Posterior) -> Posterior:
    """The posterior normalised, with nothing missing as probable as its p allows.

        against_noise(p) ≥ P(something)/P(nothing) ≥ UNSHAPED_ODDS · against_noise(p)

    The left side is what p allows all that may be missing together, whose prior odds
    are 1, however narrow the priors on sizes; the right side what it allows something
    unlisted alone. The right side is 1 at ALARM_P and against_noise falls with p. So
    alarm and posterior cannot contradict each other: with an alarm something is more
    probable than nothing, and without one 1/(1 + against_noise(ALARM_P)) = 5 % and
    more are left to nothing, whatever the explanations."""
    every, bare = posterior.explanations, len(posterior.bases)
    nothing = sum(e.probability for e in every if not e.names)
    some = sum(e.held for e in every if e.names)
    most = against_noise(posterior.p_noise)
    odds = some / nothing if nothing > 0 else math.inf
    odds = min(max(odds, UNSHAPED_ODDS * most), most)

    def scaled(e: Explanation) -> Explanation:
        if e.names:
            share = odds / (1 + odds) / some
            return replace(
                e, probability=share * e.probability, and_more=share * e.and_more
            )
        own = (e.probability / nothing if nothing > 0 else 1 / bare) / (1 + odds)
        return replace(e, probability=own, and_more=0.0 if some > 0 else odds * own)

    found = sorted(map(scaled, every), key=lambda e: -e.held)
    bases = tuple(map(scaled, posterior.bases))
    return replace(posterior, explanations=tuple(found), bases=bases)


def verdict_of(posterior: Posterior) -> Verdict:
    """none: no alarm. name: one listed set, with NAME_PROBABILITY and by itself with
    ALONE_PROBABILITY, each of its sizes other than 0, from more than one recording;
    its probability is that of this set and nothing else. unknown: something unlisted is
    more probable than listed effects alone. class: the likeliest set and others of as
    many effects, until NAME_PROBABILITY of such sets lie within it, and the fewest
    effects of which at least one is in NAME_SHARE of the listed explanations."""
    sets = posterior.by_set()
    nothing = posterior.probability(())
    if posterior.p_noise >= ALARM_P:
        return Verdict("none", (), nothing)
    strange = posterior.unlisted()
    listed = {names: p for names, p in sets if names and not strange & set(names)}
    unlisted = {names: p for names, p in sets if strange & set(names)}
    presence = posterior.presence()
    ranked = sorted(presence, key=lambda n: (-presence[n], n))
    best = max(listed, key=lambda names: listed[names], default=())
    if (
        best
        and listed[best] >= ALONE_PROBABILITY
        and sum(p for n, p in sets if set(best) <= set(n)) >= NAME_PROBABILITY
        and len(posterior.base.fit.problem.recordings) > 1  # else nothing is held out
        and all(size_is_told(posterior, n) for n in best)
    ):
        return Verdict("name", tuple(n for n in ranked if n in best), listed[best])
    if sum(unlisted.values()) >= sum(listed.values()):
        sure = tuple(
            n for n in ranked if presence[n] >= NAME_SHARE and n not in strange
        )
        with_sure = sum(p for names, p in unlisted.items() if set(sure) <= set(names))
        return Verdict("unknown", sure, with_sure)
    names = {*_alike(listed, best), *_cover(listed)}
    among = sum(p for found, p in listed.items() if set(found) <= names)
    return Verdict("class", tuple(n for n in ranked if n in names), among)


def _alike(sets: dict[tuple[str, ...], float], best: tuple[str, ...]) -> set[str]:
    """The effects of the likeliest sets of as many effects as the best, until
    NAME_PROBABILITY of these sets lie within."""
    alike = {found: p for found, p in sets.items() if len(found) == len(best)}
    names, most = set(best), NAME_PROBABILITY * sum(alike.values())
    for found in sorted(alike, key=lambda found: -alike[found]):
        if sum(p for own, p in alike.items() if names.issuperset(own)) >= most:
            break
        names |= set(found)
    return names


def _cover(sets: dict[tuple[str, ...], float]) -> list[str]:
    """The fewest effects of which at least one is in NAME_SHARE of the sets' weight."""
    names: list[str] = []
    left, most = dict(sets), (1 - NAME_SHARE) * sum(sets.values())
    while sum(left.values()) > most:
        shares: dict[str, float] = {}
        for found, p in left.items():
            for n in found:
                shares[n] = shares.get(n, 0.0) + p
        # what has one law by two names is as likely: the alphabet does not choose
        best = (1 - EQUAL) * max(shares.values())
        names += (likeliest := [n for n in sorted(shares) if shares[n] >= best])
        left = {own: p for own, p in left.items() if not {*own} & {*likeliest}}
    return names


def size_is_told(posterior: Posterior, name: str) -> bool:
    """Whether a 95 % interval of an effect, over all explanations that hold it, leaves
    0 out: that of its size, or of a further parameter."""
    holding = [e for e in posterior.explanations if name in e.names]
    if name in posterior.alternatives[holding[0].alternative].effects:
        return True  # it is there or not
    problem = holding[0].fit.problem
    parts: list[Callable] = [partial(estimate, name=name)]
    if (count := len(problem.columns_of(name))) > 1:
        parts += [partial(_linear_combination, name=name, of=k) for k in np.eye(count)]
    sizes = [averaged(holding, part) for part in parts]
    return any(size.low95 > 0 or size.high95 < 0 for size in sizes)


def mixture_interval(
    parts: list[tuple[float, float, float]],
    within: tuple[float, float] = EVERYWHERE,
) -> Interval:
    """Mean and 95 % interval of a mixture of normals, (weight, mean, sd) each,
    `within` a physical range."""
    weight, mean, sd = (np.array(column) for column in zip(*parts, strict=True))
    weight, sd = weight / weight.sum(), np.maximum(sd, 1e-12 * (1 + np.abs(mean)))
    each = stats.truncnorm(*((end - mean) / sd for end in within), mean, sd)
    low, high = np.clip([(mean - 8 * sd).min(), (mean + 8 * sd).max()], *within)
    if not low < high:  # all of it lies beyond one end
        return Interval(float(low), float(low), float(low))

    def end(share: float) -> float:
        def more(x: float) -> float:
            return float(weight @ each.cdf(x)) - share

        own = each.ppf(share)  # the parts', between which the mixture's lies
        least, most = float(own.min()), float(own.max())
        if more(least) >= 0 or more(most) <= 0:  # but for rounding
            return least if more(least) >= 0 else most
        return float(brentq(more, least, most, xtol=1e-15 * (high - low)))

    return Interval(float(weight @ each.mean()), *map(end, ENDS))


def effect_estimate(posterior: Posterior, name: str) -> EffectEstimate:
    """One listed effect, averaged over the explanations that hold it."""
    holding = [e for e in posterior.explanations if name in e.names]
    present = sum(e.held for e in holding)
    own = posterior.alternatives[holding[0].alternative]
    if name in own.effects:
        unit, value, sd = own.sizes.get(name, ("", np.nan, np.nan))
        if np.isfinite(value):
            size = mixture_interval([(1.0, value, sd)])
        else:
            size = Interval(np.nan, np.nan, np.nan)
        return EffectEstimate(present, unit, size)
    effect = holding[0].fit.problem.effects[name]

    def shown(of: Callable, within: tuple[float, float]) -> Interval:
        size, show = averaged(holding, of, within), effect.reported or float
        return Interval(
            show(size.value), *sorted((show(size.low95), show(size.high95)))
        )

    # a summary is no fitted parameter, of which the physical range is
    within = EVERYWHERE if effect.summary else (effect.low, effect.high)
    size = shown(partial(estimate, name=name), within)
    return EffectEstimate(present, effect.unit, size)


def averaged(
    holding: list[Explanation],
    of: Callable[[Explanation], tuple[float, float]],
    within: tuple[float, float] = EVERYWHERE,
) -> Interval:
    """A value averaged over the explanations that hold an effect."""
    weighty = [e for e in holding if e.held >= 1e-4 * holding[0].held]
    parts = [(e.held, *of(e)) for e in weighty]
    return mixture_interval(parts, within)


def estimate(e: Explanation, name: str) -> tuple[float, float]:
    """Mean and sd of an effect's parameter within one explanation, doubt about noise
    included."""
    effect = e.fit.problem.effects[name]
    if effect.summary:
        return effect.summary(e)
    return _linear_combination(e, name, np.eye(len(e.table.index[name]))[0])


def _linear_combination(
    e: Explanation, name: str, of: np.ndarray
) -> tuple[float, float]:
    """Mean and sd of a linear combination (k,) of an effect's columns."""
    mean, covariance = e.table.estimate(e.names, WIDE_PRIOR)
    first = sum(len(e.table.index[k]) for k in e.names[: e.names.index(name)])
    own = slice(first, first + len(of))
    return float(of @ mean[own]), float(
        np.exp(e.table.level_sd**2 / 2) * np.sqrt(of @ covariance[own, own] @ of)
    )


def parameter_shift(
    posterior: Posterior,
    bare: Explanation,
    value: Callable[[Explanation], tuple[float, float]],
) -> ParameterShift:
    """A contact parameter; bare: nothing missing, no condition followed;
    value(explanation) → its mean and sd there."""

    def weighted(e: Explanation, weight: float) -> tuple[float, float, float]:
        mean, sd = value(e)
        return weight, mean, sd * float(np.sqrt(e.power))

    nothing = [weighted(bare, 1.0)]
    likely = [e for e in posterior.explanations if e.held > 1e-3]
    every = [weighted(e, e.held) for e in likely] or nothing
    return ParameterShift(mixture_interval(nothing), mixture_interval(every))


def sector_shares(posterior: Posterior) -> dict[str, float]:
    """Share of each sector in what is missing, by the ln evidence that each part
    adds."""
    out: dict[str, float] = {}
    found = [e for e in posterior.explanations if e.names]
    weight = sum(e.held for e in found)
    for e in found:
        whole = e.table.ln_evidence(e.names)[0]
        gains = [
            max(
                whole - e.table.ln_evidence(tuple(n for n in e.names if n != m))[0],
                1e-3,
            )
            for m in e.names
        ]
        for n, gain in zip(e.names, gains, strict=True):
            sector = e.table.components[n].sector
            out[sector] = out.get(sector, 0.0) + e.held / weight * gain / sum(gains)
    return out
