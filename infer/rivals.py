"""What else could be true of a measured number: other explanations with their odds.

One that has less than 5 % of the probability cannot make a 95 % interval fail."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.infer.evidence import student_ln_likelihood
from benchtwin.infer.linear import ridge, stacked
from benchtwin.infer.posterior import LISTED_ODDS
from benchtwin.infer.problem import Fit, fit, ln_evidence

INSIDE_SDS = 1.96
CAN_BE_TRUE = 0.05  # probability from which a rival counts


class Measured(Protocol):
    """A number with its standard deviation."""

    @property
    def name(self) -> str: ...
    @property
    def value(self) -> float: ...
    @property
    def sd(self) -> float: ...


@dataclass(frozen=True)
class Rival:
    """Another explanation: odds over the fit, and the value of a quantity if it holds,
    NaN where that is not shown then."""

    odds: float
    words: str
    value: Callable[[Measured], float]


@dataclass(frozen=True, eq=False)
class Other:
    """An effect fitted beside what was fitted without it: its odds, and words."""

    odds: float
    words: str
    fit: Fit


def other_explanations(base: Fit, free: tuple[str, ...] = ()) -> list[Other]:
    """Each effect that recordings may show, fitted in full where the linear problem
    leaves it possible, or it is not linear; free: those that are free already."""
    problem, out = base.problem, []
    known = problem.known_sd.keys() | set(free)
    alone = {
        name: effect
        for name, effect in problem.effects.items()
        if not (effect.group or effect.unlisted)
        and known.isdisjoint(problem.columns_of(name))
    }
    odds_of = {name: _odds_if_linear(base, name) for name in alone}
    least = CAN_BE_TRUE / 2 * (1 + sum(odds_of.values()))
    for name, effect in alone.items():
        if odds_of[name] < least and not effect.nonlinear:
            continue
        other = fit(problem, free=(*free, name), start=base)
        size = other.by_name[name]
        if not effect.low <= size <= effect.high:
            continue
        ln_bayes = ln_evidence(other) + other.chi2 / 2
        ln_bayes -= ln_evidence(base) + base.chi2 / 2
        fall = min(other.chi2 - base.chi2, 0.0)
        ln_bayes -= student_ln_likelihood(fall / 2, problem.level_sd)
        told = (effect.reported or float)(size)
        size_said = f"{told:.3g} {tr(effect.wording[1])}".rstrip()
        words = f"{tr(effect.wording[0])} ({size_said})"
        out.append(Other(LISTED_ODDS * math.exp(min(ln_bayes, 500.0)), words, other))
    return out


def _odds_if_linear(base: Fit, name: str) -> float:
    """Odds of an effect, as if the problem were linear and its noise known."""
    a, b = stacked(base.reduced)
    wide = base.prior_sd.copy()
    for n in base.problem.columns_of(name):
        wide[base.names.index(n)] = base.problem.effects[n].prior_sd
    ln = []
    for sd in (base.prior_sd, wide):
        _, covariance, chi2 = ridge(a, b, sd)
        kept = sd > 0
        scaled = covariance[np.ix_(kept, kept)] / np.outer(sd[kept], sd[kept])
        ln.append(np.linalg.slogdet(scaled)[1] / 2 - chi2 / 2)
    return LISTED_ODDS * math.exp(min(ln[1] - ln[0], 500.0))


def by_name(values: Mapping[str, float]) -> Callable[[Measured], float]:
    """Values of quantities if a rival holds, as a Rival has them."""
    return lambda q: values[q.name]


def unless(rivals: list[Rival], q: Measured) -> list[str]:
    """Why the interval of a quantity would not hold if a rival were true."""
    whole, out = 1 + sum(r.odds for r in rivals), []
    for rival in rivals:
        share = rival.odds / whole
        value = rival.value(q)
        if share >= CAN_BE_TRUE and not abs(value - q.value) <= INSIDE_SDS * q.sd:
            other = f"is {value:.3g}" if math.isfinite(value) else tr("is not shown")
            out.append(
                tr("it {} if {} (probability {:.2g})", other, rival.words, share)
            )
    return out
