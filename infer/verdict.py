"""The verdict from the posterior, and estimates of every effect and contact
parameter."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from benchtwin.infer.alarm import ALARM_P
from benchtwin.infer.explanation import Explanation, Posterior
from benchtwin.infer.posterior import WIDE_PRIOR
from scipy import stats
from scipy.optimize import brentq

NAME_SHARE = 0.95  # of the explanations with something missing, for a name or class
NAME_PROBABILITY = 0.8  # of all explanations, for a name without unlisted physics
HALF = 0.5
MATTERS_SDS = 0.5  # shift of a contact parameter that matters
ENDS = (0.025, 0.975)  # of a 95 % interval


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
    levels: dict[str, Interval] = field(
        default_factory=dict
    )  # of a condition, beside their mean


@dataclass(frozen=True)
class ParameterShift:
    """A contact parameter with nothing missing, and averaged over all explanations."""

    nothing_missing: Interval
    explained: Interval

    @property
    def shift_sds(self) -> float:
        """The shift in sds of the former."""
        half = (
            (self.nothing_missing.high95 - self.nothing_missing.low95)
            / 2
            / stats.norm.ppf(ENDS[1])
        )
        return (
            (self.explained.value - self.nothing_missing.value) / half
            if half > 0
            else 0.0
        )


@dataclass(frozen=True)
class Verdict:
    """verdict: none | name | class | unknown; names; probability of the verdict."""

    verdict: str
    names: tuple[str, ...]
    probability: float


def verdict_of(posterior: Posterior, p_global: float) -> Verdict:
    """none: no alarm, or "nothing missing" has at least HALF of the probability.

    Else, of the explanations in which something is missing, unknown: more than HALF
    needs unlisted physics. name: the likeliest listed set, alone or with more, has
    NAME_SHARE, or NAME_PROBABILITY of all without unlisted physics. Never from a single
    recording. class: that set where one of its effects is certain, else the fewest
    effects of which at least one is in NAME_SHARE of the listed explanations."""
    nothing = posterior.probability(())
    if p_global >= ALARM_P or nothing >= HALF:
        return Verdict("none", (), nothing)
    found = [e for e in posterior.explanations if e.names]
    weight = sum(e.probability for e in found)
    unlisted_share = sum(e.probability for e in found if e.unlisted) / weight
    presence = {
        n: sum(e.probability for e in found if n in e.listed) / weight
        for n in {n for e in found for n in e.listed}
    }
    ranked = sorted(presence, key=lambda n: (-presence[n], n))
    if unlisted_share > HALF:
        return Verdict(
            "unknown",
            tuple(n for n in ranked if presence[n] >= NAME_SHARE),
            unlisted_share,
        )
    best = max((e.names for e in found if not e.unlisted), key=posterior.probability)
    holding = [e for e in found if set(best) <= set(e.listed)]
    held = sum(e.probability for e in holding) / weight
    without_unlisted = sum(e.probability for e in holding if not e.unlisted)
    single_recording = (
        len(posterior.base.fit.problem.recordings) < 2
    )  # nothing is held out: no name for certain
    if (
        held >= NAME_SHARE or without_unlisted >= NAME_PROBABILITY
    ) and not single_recording:
        return Verdict(
            "name",
            tuple(n for n in ranked if n in best),
            sum(e.probability for e in holding),
        )
    if any(presence[n] >= NAME_SHARE for n in best):
        return Verdict("class", tuple(n for n in ranked if n in best), held)
    names, left = [], [e for e in found if e.listed]
    whole, reached = sum(e.probability for e in left), 0.0
    while left and reached < NAME_SHARE * whole:
        shares = {
            n: sum(e.probability for e in left if n in e.listed)
            for e in left
            for n in e.listed
        }
        names.append(max(sorted(shares), key=lambda n: shares[n]))
        left = [e for e in left if names[-1] not in e.listed]
        reached = sum(e.probability for e in found if set(names) & set(e.listed))
    return Verdict("class", tuple(names), reached / weight)


def mixture_interval(parts: list[tuple[float, float, float]]) -> Interval:
    """Mean and 95 % interval of a mixture of normals, (weight, mean, sd) each."""
    weight, mean, sd = (np.array(column) for column in zip(*parts, strict=True))
    weight, sd = weight / weight.sum(), np.maximum(sd, 1e-12 * (1 + np.abs(mean)))
    low, high = (mean - 8 * sd).min(), (mean + 8 * sd).max()

    def below(x: float, share: float) -> float:
        return float(weight @ stats.norm.cdf((x - mean) / sd)) - share

    ends = [
        brentq(below, low, high, args=(share,), xtol=1e-15 * (high - low))
        for share in ENDS
    ]
    return Interval(float(weight @ mean), *ends)


def effect_estimate(posterior: Posterior, name: str) -> EffectEstimate:
    """One listed effect, averaged over the explanations that hold it."""
    holding = [e for e in posterior.explanations if name in e.names]
    present = sum(e.probability for e in holding)
    own = posterior.alternatives[holding[0].alternative]
    if name in own.effects:
        unit, value, sd = own.sizes.get(name, ("", np.nan, np.nan))
        size = (
            mixture_interval([(1.0, value, sd)])
            if np.isfinite(value)
            else Interval(np.nan, np.nan, np.nan)
        )
        return EffectEstimate(present, unit, size)
    effect = holding[0].fit.problem.effects[name]
    weighty = [e for e in holding if e.probability > 1e-4 * holding[0].probability]

    def averaged(of: Callable[[Explanation], tuple[float, float]]) -> Interval:
        size, shown = (
            mixture_interval([(e.probability, *of(e)) for e in weighty]),
            effect.reported or float,
        )
        return Interval(
            shown(size.value), *sorted((shown(size.low95), shown(size.high95)))
        )

    problem = holding[0].fit.problem
    levels = (
        [problem.effects[n].level for n in problem.columns_of(name)]
        if effect.level
        else []
    )
    beside_mean = np.eye(len(levels)) - 1 / max(len(levels), 1)
    parts = [partial(_linear_combination, name=name, of=of) for of in beside_mean]
    each = {level: averaged(part) for level, part in zip(levels, parts)}
    return EffectEstimate(
        present, effect.unit, averaged(partial(estimate, name=name)), each
    )


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
    posterior: Posterior, value: Callable[[Explanation], tuple[float, float]]
) -> ParameterShift:
    """A contact parameter; value(explanation) → its mean and sd there."""

    def weighted(e: Explanation, weight: float) -> tuple[float, float, float]:
        mean, sd = value(e)
        return weight, mean, sd * float(np.sqrt(e.power))

    nothing = [weighted(posterior.base, 1.0)]
    likely = [e for e in posterior.explanations if e.probability > 1e-3]
    every = [weighted(e, e.probability) for e in likely] or nothing
    return ParameterShift(mixture_interval(nothing), mixture_interval(every))


def sector_shares(posterior: Posterior) -> dict[str, float]:
    """Share of each sector in what is missing, by the ln evidence that each part
    adds."""
    out: dict[str, float] = {}
    found = [e for e in posterior.explanations if e.names]
    weight = sum(e.probability for e in found)
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
            out[sector] = out.get(sector, 0.0) + e.probability / weight * gain / sum(
                gains
            )
    return out
