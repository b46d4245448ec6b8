"""Laws for unlisted physics, by regression in the linearised problem.

A law has one or two terms, each a size times a fixed column or times a power of one
quantity over a reference. The term of the greatest fall of χ² is taken, or one that
does as well and that the twin knows; it must predict left-out recordings. Its exponent
is that of the greatest fall, with the range in which χ² lies within 3.84 of it. A term
that cannot be what acts (possible_law.py) is none."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.bench.numbers import with_interval
from benchtwin.infer.effect import Counterpart, Effect
from benchtwin.infer.held_out import squared_errors
from benchtwin.infer.linear import Reduced, beside_globals, fall_in, stacked
from benchtwin.infer.possible_law import MOST, Reach, is_possible
from benchtwin.infer.problem import Fit, fit

NAMES = ("law", "second-law")  # of the effects that stand for the terms
ROUNDS = 3  # at most: a law is looked for again about the motion that it makes
WITHIN_CHI2 = 3.84  # 95 % of one degree of freedom
LEAST_FALL = 12.0  # of χ², for a term to be reported
LEAST_OVER = 0.05  # of the reference, below which a power < 0 is constant
WIDE = 3.0  # prior sd of a size over what was found: so that it decides nothing
SDS_95 = 1.96
FINEST = 0.05  # step of the powers that are told apart
SIMPLE = (1.0, 2.0, 0.5, 3.0, 1.5, -1.0, -0.5, -2.0, -1.5)  # the simplest first


@dataclass(frozen=True)
class Family:
    """Terms that differ in the power of one quantity."""

    say: Callable[[bool, str], str]  # (its size is > 0, power in words) → the term
    size: tuple[str, str]  # unit of its size, and of what that is
    sector: str
    powers: tuple[float, ...] = (1.0,)  # ascending
    quantity: str = ""  # of which it is a power
    # (name, power) → how it acts, and what it is in the twin, as fields of an Effect
    acts: Callable[[str, float], dict[str, Any]] | None = None
    not_simulated: str = ""
    least: float = 1.0  # of its quantity in the recordings, over the reference
    # (globals by name) → the least that it can be where it does most
    low: Callable[[Mapping[str, float]], float] = lambda at: -MOST

    def reach(self, k: int) -> Reach:
        """Of its term of power k."""
        most = raised(np.array(min(self.least, 1.0)), min(self.powers[k], 0.0))
        return Reach(float(most), self.low)


@dataclass(frozen=True)
class Term:
    """A term as found."""

    words: str
    effect: Effect
    size: float
    sd: float
    also: tuple[str, ...] = ()  # quantities that would do as well

    @property
    def in_the_twin(self) -> str:
        """What stands for it there, "" for nothing."""
        return tr(self.effect.counterpart.what) if self.effect.counterpart else ""

    def in_words(self) -> str:
        """With its size and 95 % interval."""
        value, half = abs(self.size), SDS_95 * self.sd
        size, _, ends = with_interval(value, value - half, value + half).partition(" (")
        also = (
            tr("; {} would do as well", tr(" or ").join(self.also)) if self.also else ""
        )
        said = f"{self.words}, {size} {tr(self.effect.wording[1])}"
        return f"{said} (95 %: {ends}{also}" if ends else f"{said}{also}"


# None: what stands out cannot be what acts
Law = tuple[Term, ...] | None


def law_of(base: Fit, families: list[Family], extra: Any) -> Law:
    """The terms that stand out, the most telling first, in the place of those that
    `base` may have already; extra: a column for every power of every family, in the
    form that Problem.reduce takes."""
    reduced = base.problem.reduce(base.starts, base.values, extra)[0]
    sd = np.where(np.isin(base.names, NAMES), 0.0, base.prior_sd)
    columns, project, b = beside_globals(reduced, sd)
    gram, right = columns.T @ project(columns), columns.T @ project(b)
    ends = np.cumsum([0, *(len(f.powers) for f in families)])
    chosen: list[int] = []
    reaches: list[Reach] = []
    found: list[tuple[Family, float, str, tuple[str, ...]]] = []
    reached, left = 0.0, dict(enumerate(families))
    while left and len(chosen) < len(NAMES):
        falls = {
            k: _falls(gram, right, chosen, range(ends[k], ends[k + 1])) for k in left
        }
        top = max(float(own.max()) for own in falls.values())

        def better(k: int, falls=falls, top=top) -> tuple[bool, float]:
            own = float(falls[k].max())
            return own > top - WITHIN_CHI2 and families[k].acts is not None, own

        best, least, absurd = None, reached + LEAST_FALL, False
        for k in sorted(left, key=better, reverse=True):
            at = int(ends[k] + np.argmax(falls[k]))
            if falls[k].max() < least:
                continue
            predicts, beside = _predicts(reduced, sd, [*chosen, at])
            if not predicts:
                continue
            reach = families[k].reach(at - ends[k])
            effects = base.problem.effects
            if is_possible(base.names, effects, *beside, [*reaches, reach]):
                best = k, at
                break
            # what tells less is no law in its place
            least, absurd = max(least, float(falls[k].max()) - WITHIN_CHI2), True
        if best is None:
            break
        k, at = best
        chosen.append(at)
        reaches.append(reach)
        own, reached = falls[k], float(falls[k].max())
        also = dict.fromkeys(
            families[j].quantity
            for j in left
            if j != k and falls[j].max() > top - WITHIN_CHI2
        )
        power, *inside = _range(np.array(families[k].powers), own)
        others = tuple(q for q in also if q not in ("", families[k].quantity))
        found.append((left.pop(k), power, in_words(power, *inside), others))
    if not chosen:
        return None if absurd else ()
    covariance = np.linalg.inv(gram[np.ix_(chosen, chosen)])
    size, sds = covariance @ right[chosen], np.sqrt(np.diag(covariance))
    return tuple(
        _term(name, *about, float(a), float(s))
        for name, about, a, s in zip(NAMES, found, size, sds)
    )


def _falls(
    gram: np.ndarray, right: np.ndarray, chosen: list[int], some: Iterable[int]
) -> np.ndarray:
    """By how much each of some columns lowers χ², together with those chosen."""
    sets = ([*chosen, k] for k in some)
    return np.array([fall_in(gram[np.ix_(at, at)], right[at])[0] for at in sets])


def _predicts(
    reduced: tuple[Reduced, ...], prior_sd: np.ndarray, chosen: list[int]
) -> tuple[bool, tuple[tuple[Reduced, ...], np.ndarray]]:
    """Whether the last of these columns predicts left-out recordings beside the others
    (of a single recording that is not known); the problem with them."""
    beside, whole = (
        _with_columns(reduced, prior_sd, some) for some in (chosen[:-1], chosen)
    )
    alone = len(reduced) < 2
    return alone or sum(squared_errors(*whole)) < sum(squared_errors(*beside)), whole


def _with_columns(
    reduced: tuple[Reduced, ...], prior_sd: np.ndarray, some: list[int]
) -> tuple[tuple[Reduced, ...], np.ndarray]:
    """The globals and some of the columns behind them, which may be of any size."""
    count = len(prior_sd)
    kept = [*range(count), *(count + k for k in some)]
    parts = tuple(replace(r, a=r.a[:, kept]) for r in reduced)
    a, b = stacked(parts)
    size = np.maximum(np.linalg.norm(a[:, count:], axis=0), 1e-300)
    return parts, np.concatenate([prior_sd, 10 * np.linalg.norm(b) / size])


def _term(
    name: str,
    family: Family,
    power: float,
    in_power: str,
    also: tuple[str, ...],
    size: float,
    sd: float,
) -> Term:
    unit, of = family.size
    words = family.say(size > 0, in_power)
    effect = Effect(
        name,
        family.sector,
        unit,
        of,
        WIDE * abs(size),
        -np.inf,
        np.inf,
        tr("regression on what the listed effects leave"),
        wording=(words, of),
        not_simulated=family.not_simulated,
        **(family.acts(name, power) if family.acts else {}),
    )
    return Term(words, effect, size, sd, also)


def fitted(base: Fit, free: tuple[str, ...], terms: tuple[Term, ...]) -> Fit:
    """The problem with effects that stand for the terms, fitted with them and `free`
    from a fit without them."""
    problem = base.problem
    for term in terms:
        assert problem.with_effect is not None
        problem = problem.with_effect(term.effect)
    values = np.array([base.by_name.get(n, 0.0) for n in problem.names])
    names = tuple(t.effect.name for t in terms)
    start = replace(base, problem=problem, values=values, cache={})
    return fit(problem, free=(*free, *names), start=start)


def counterpart(
    what: str, law: str, size: str, name: str, speed: float, power: float
) -> Counterpart:
    """The effect `name` as the law of the twin, whose number `size` it is at a
    speed."""

    def change(values: dict[str, float]) -> dict:
        return {"laws": {law: {size: values[name], "speed": speed, "power": power}}}

    return Counterpart(f"{what} {{value}} · (v / {speed:g} m/s)^{power:g}", change)


def resisting(what: str, law: str, top: float) -> Callable[[str, float], dict]:
    """How a resistance as a power of speed over `top` [m/s] acts, here and as the law
    of the twin."""

    def acts(name: str, power: float) -> dict:
        return {
            "resist": lambda speed, value, of, more: value * raised(speed / top, power),
            "counterpart": counterpart(what, law, "size", name, top, power),
        }

    return acts


def raised(over: np.ndarray, power: float) -> np.ndarray:
    """over^power, as the twin's laws have it."""
    return (np.maximum(over, LEAST_OVER) if power < 0 else over) ** power


def risen(over: np.ndarray, power: float) -> np.ndarray:
    """(over^power − 1)/power, ln(over) for power 0: Box & Cox (1964), J. R. Stat. Soc.
    B 26, 211."""
    over = np.maximum(over, LEAST_OVER)
    return np.log(over) if power == 0 else (over**power - 1) / power


def reference(largest: float) -> float:
    """A quantity's reference: about its greatest value, in two digits."""
    return float(f"{largest:.2g}")


def in_words(power: float, low: float, high: float) -> str:
    """An exponent: the simplest number in its 95 % interval, and that.

    >>> in_words(1.9, 1.7, 2.1)
    'to the power 2 (1.7 to 2.1)'
    >>> in_words(0.5, -np.inf, 3.0)
    'to the power 1 (at most 3)'
    """
    simple = next((s for s in SIMPLE if low <= s <= high), power)
    if not np.isfinite(low) and not np.isfinite(high):
        return tr("to a power that was not resolved")
    if np.isfinite(low) and np.isfinite(high):
        inside = f"{low:.2g} to {high:.2g}"
    elif np.isfinite(high):
        inside = tr("at most {:.2g}", high)
    else:
        inside = tr("at least {:.2g}", low)
    return tr("to the power {:g} ({})", simple, inside)


def _range(powers: np.ndarray, falls: np.ndarray) -> tuple[float, float, float]:
    """The best power, and the ends of those with χ² within WITHIN_CHI2 of it; ∓inf
    where χ² does not rise enough. A parabola through the best three, else linear."""
    # includes the best power itself
    steps = np.arange(powers[0], powers[-1], FINEST).round(9)  # 0 is among them
    fine = np.union1d(steps, powers)
    smooth, at = np.interp(fine, powers, falls), int(np.argmax(falls))
    if 0 < at < len(powers) - 1:
        three = slice(at - 1, at + 2)
        near = (fine >= powers[at - 1]) & (fine <= powers[at + 1])
        parabola = np.polyfit(powers[three], falls[three], 2)
        smooth[near] = np.polyval(parabola, fine[near])
    inside = fine[smooth > smooth.max() - WITHIN_CHI2]
    low, high = float(inside.min()), float(inside.max())
    return (
        float(fine[np.argmax(smooth)]),
        -np.inf if low <= powers[0] else low,
        np.inf if high >= powers[-1] else high,
    )
