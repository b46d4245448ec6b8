"""Name the missing physics: score test, refits of what is above threshold and of its near twins, evidence, prediction, decision.

The rules are decide.py's.
"""

from collections.abc import Callable

import numpy as np

from calibrate.diagnose.decide import (
    ALPHA,
    LN_BF_BASELINE,
    LN_BF_RIVAL,
    SATURATED_P,
    Candidate,
    Verdict,
    decide,
    flaws_of,
    possible,
)
from calibrate.diagnose.linear import chance
from calibrate.diagnose.locate import Location, noise_doubt, unnamed
from calibrate.diagnose.noise import maximum_draws
from calibrate.diagnose.problem import Fit, fit
from calibrate.diagnose.scores import explained, gains_alone, ln_evidence, predictive_gains, score, single_estimates, unbound

SIGNS_COUNT = 2.0  # a recording that sees the effect at less sds has no say about its sign
MOST_EFFECTS = 3  # named together
REFITS = 5  # candidates at a time that are fitted in full


def alarm(base: Fit, location: Location, rng: np.random.Generator, *, draws: int = 40_000) -> tuple[float, dict[str, float]]:
    """Global p (maximum candidate score, and the smooth excess for what has no name; Bonferroni), and |z| of each effect."""
    found = score(base)
    maxima = maximum_draws(found.covariance, rng, level_sd=base.problem.level_sd, draws=draws)
    p = (1 + (maxima >= np.abs(found.z).max()).sum()) / (1 + draws)
    return float(min(1.0, 2 * min(p, location.p))), _strength(base)


def _needed(base: Fit, chosen: tuple[str, ...], tried: dict, rng: np.random.Generator) -> tuple[str, ...]:
    """Without those that stood for others which were found after them; `tried` grows by what had to be fitted for it."""
    whole = tried[tuple(sorted(chosen))]
    fewer = [tuple(sorted(set(chosen) - {n})) for n in chosen] if len(chosen) > 1 else []
    for key in fewer:
        tried[key] = tried.get(key) or candidate(base, key, rng)
    best = max((tried[key] for key in fewer if possible(tried[key])), key=lambda c: c.ln_bayes, default=None)
    if best is None or best.ln_bayes < whole.ln_bayes - LN_BF_BASELINE:
        return chosen
    return _needed(base, best.names, tried, rng)


def _swapped(base: Fit, chosen: tuple[str, ...], tried: dict, rng: np.random.Generator, others: Callable) -> tuple[str, ...]:
    """With one of others(n) in the place of an n of them where that has more evidence."""
    if len(chosen) < 2:
        return chosen
    able = set(base.names) & set(base.problem.effects)  # a bench may hold as known what is a candidate elsewhere
    for n in chosen:
        for other in others(n):
            key = tuple(sorted({*chosen, other} - {n}))
            if other not in chosen and other in able:
                tried[key] = tried.get(key) or candidate(base, key, rng)
    same = [c for key, c in tried.items() if len(key) == len(chosen) and possible(c)]
    return max((tried[tuple(sorted(chosen))], *same), key=lambda c: c.ln_bayes).names


def _settled(base: Fit, chosen: tuple[str, ...], tried: dict, strength: dict, rng: np.random.Generator) -> tuple[str, ...]:
    """What is left of the effects found one after the other: what was found first may have stood for two, a twin or both, and
    so may what takes its place; what was found beside something that goes again may stand for what that had hidden."""
    whole = chosen
    while (better := _swapped(base, whole, tried, rng, lambda n: base.problem.effects[n].twins)) != whole:
        whole = better
    fewer = _needed(base, whole, tried, rng)
    if len(fewer) == len(whole):
        return whole
    return _swapped(base, fewer, tried, rng, lambda n: _worth_trying(base, tuple(m for m in fewer if m != n), strength))


def _rest(base: Fit, chosen: tuple[str, ...], rng: np.random.Generator, *, draws: int = 20_000) -> float:
    """Global p of the greatest score of any other candidate once `chosen` are free, or of common terms without a name: both see
    what the smooth excess does not."""
    at = unbound(fit(base.problem, free=chosen, start=base), chosen)
    found = score(at)
    maxima = maximum_draws(found.covariance, rng, level_sd=base.problem.level_sd, draws=draws)
    p = float((1 + (maxima >= np.abs(found.z).max()).sum()) / (1 + draws))
    return min(1.0, 2 * min(p, left)) if (left := _nameless_left(at, rng)) is not None else p


def _nameless_left(at: Fit, rng: np.random.Generator) -> float | None:
    """p of what common terms without a name still explain; None where a rig has none."""
    terms = unnamed(at)
    return chance(*terms.fall(()), noise_doubt(at, rng)) if terms else None


def _strength(at: Fit) -> dict[str, float]:
    """Greatest |z| of each candidate's columns."""
    found = score(at)
    strength: dict[str, float] = {}
    for name, z in zip(found.names, np.abs(found.z), strict=True):
        own = at.problem.effects[name].group or name
        strength[own] = max(strength.get(own, 0.0), float(z))
    return strength


def _grown(
    base: Fit, chosen: tuple[str, ...], tried: dict, strength: dict, rng: np.random.Generator, alpha: float
) -> tuple[str, ...]:
    """`chosen` and what is found beside it, one after the other, until nothing is left; `tried` grows by what was fitted."""
    while len(chosen) < MOST_EFFECTS:
        for other in _worth_trying(base, chosen, strength):
            key = tuple(sorted((*chosen, other)))
            tried[key] = tried.get(key) or candidate(base, key, rng)
        level = [c for key, c in tried.items() if len(key) == len(chosen) + 1 and set(chosen) <= set(key)]
        floor = tried[chosen].ln_bayes + LN_BF_BASELINE
        best = _best(level, floor)
        if best.ln_bayes < floor:
            break
        chosen = best.names
        if best.left_p > SATURATED_P and _rest(base, chosen, rng) >= alpha:
            break
    return chosen


def _other_beginnings(base: Fit, chosen: tuple[str, ...], tried: dict) -> list[str]:
    """Twins that stand by themselves, since the first may have stood for one of them and something else: where something is left
    beside all that was found, or where so much is beside the twin that both may have more evidence."""
    twins = dict.fromkeys(t for n in chosen for t in base.problem.effects[n].twins if t not in chosen)
    able = [t for t in twins if (c := tried.get((t,))) and possible(c) and c.ln_bayes >= LN_BF_BASELINE]
    if tried[chosen].left_p <= SATURATED_P:
        return able
    short = {t: _worth(tried[chosen]) - _worth(tried[(t,)]) for t in able}
    return [t for t in able if max(_strength(fit(base.problem, free=(t,), start=base)).values()) ** 2 / 2 > short[t]]


def _worth(found: Candidate) -> float:
    """Its evidence, less what every effect must bring."""
    return found.ln_bayes - LN_BF_BASELINE * len(found.names)


def name(base: Fit, location: Location, rng: np.random.Generator, *, alpha: float = ALPHA) -> Verdict:
    """The verdict on a fitted baseline that has been located; alarm: p < alpha."""
    p, strength = alarm(base, location, rng)
    if p >= alpha:
        return Verdict("none", (), p, (), float("nan"), None)
    tried: dict[tuple[str, ...], Candidate] = {(): candidate(base, (), rng)}
    chosen = _grown(base, (), tried, strength, rng, alpha)
    others = [_grown(base, (twin,), tried, strength, rng, alpha) for twin in _other_beginnings(base, chosen, tried)]
    ends = [tried[end] for end in (chosen, *others) if not set(chosen) < set(end)]  # beside it nothing was found
    chosen = max([end for end in ends if possible(end)] or ends, key=_worth).names
    chosen = _settled(base, chosen, tried, strength, rng)
    left = _nameless_left(unbound(fit(base.problem, free=chosen, start=base), chosen), rng) if chosen else None
    return decide(base.problem.effects, p, chosen, tuple(c for key, c in tried.items() if key), 1.0 if left is None else left)


def _best(level: list[Candidate], floor: float) -> Candidate:
    """The greatest evidence; what is physically impossible is no step on the way to a name where something possible is above the
    floor. It speaks again at the end (`decide`)."""
    able = [c for c in level if possible(c) and c.ln_bayes > floor]
    return max(able or level, key=lambda c: c.ln_bayes)


def _worth_trying(base: Fit, chosen: tuple[str, ...], strength: dict[str, float]) -> list[str]:
    """The effects with the greatest scores beside those chosen, and the twins of the greatest."""
    if chosen:
        strength = _strength(fit(base.problem, free=chosen, start=base))
    effects = base.problem.effects
    order = [n for n in sorted(strength, key=lambda n: strength[n], reverse=True) if n not in chosen]
    twins = [t for t in (*effects[order[0]].twins, *(u for c in chosen for u in effects[c].twins)) if t in order]
    return list(dict.fromkeys([*order[:REFITS], *twins]))


def candidate(base: Fit, names: tuple[str, ...], rng: np.random.Generator) -> Candidate:
    """Full refit with the effects `names` at their physical prior, and all that the decision rules ask."""
    names = tuple(sorted(names))
    found = fit(base.problem, free=names, start=base) if names else base
    bayes = ln_evidence(found.reduced, found.prior_sd) - ln_evidence(base.reduced, base.prior_sd)
    bayes = min(bayes, _most(found, base)) if names else 0.0
    values = tuple(found.by_name[n] for n in names)
    sds = tuple(found.sd(n) for n in names)
    fall, freedom = explained(unbound(found, names), (), smooth=True)
    left = chance(fall, freedom, noise_doubt(base, rng))
    gains = _gains(found, base, names) if names else np.zeros(0)
    gain = float(gains.mean()) if len(gains) else float("nan")
    error = float(gains.std(ddof=1) / np.sqrt(len(gains))) if len(gains) > 1 else float("nan")
    same = min((_same_sign(found, n) for n in names), default=1.0)
    flaws = flaws_of(base.problem.effects, names, values, bayes, _shared(gains), same, left)
    return Candidate(names, values, sds, bayes, gain, error, same, left, flaws)


def _gains(found: Fit, base: Fit, names: tuple[str, ...]) -> np.ndarray:
    """(R,) what each recording gains by the effects as the others have them, beside a baseline that has learnt from those others
    as well; or, where that has bent something known until it does, beside one that has not."""
    learnt = predictive_gains(found, base, names)
    return learnt if _shared(learnt) or not len(learnt) else gains_alone(found, base, names)


def _shared(gains: np.ndarray) -> bool:
    """Whether recordings gain by 2 standard errors. Drops from several heights gain unequally: then it must do without the
    recording that gains most."""
    error = float(gains.std(ddof=1) / np.sqrt(len(gains))) if len(gains) > 1 else float("nan")
    return bool(len(gains) and gains.mean() > 2 * error) or bool(len(gains) > 2 and gains.sum() - gains.max() > LN_BF_RIVAL)


def _most(found: Fit, base: Fit) -> float:
    """ln of the ratio of likelihoods, which no evidence exceeds; Laplace's does about a kink. Infinite where χ² is not told."""
    told = all(r.cost is not None for r in (*found.reduced, *base.reduced))
    return (base.chi2 - found.chi2) / 2 if told else float("inf")


def _same_sign(found: Fit, effect: str) -> float:
    values, sds = single_estimates(found, effect)
    says = np.abs(values) > SIGNS_COUNT * sds
    return float((values[says] * found.by_name[effect] > 0).mean()) if says.any() else 1.0
