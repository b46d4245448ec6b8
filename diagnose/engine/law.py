"""A law for what has no name: the power of one quantity that takes most of the excess, by regression in the reduced space.

Each family says where a term acts and of what it is a power; the exponent is that of the greatest fall in χ², with the range in
which χ² lies within 3.84 of it, snapped to a simple number inside that range; the term must predict left-out recordings.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from diagnose.engine.held_out import missed
from diagnose.engine.linear import Reduced, fall_of_chi2, projector, ridge, stacked
from diagnose.engine.problem import Fit

WITHIN = 3.84  # χ² of one degree of freedom at 95 %
LEAST_FALL = 12.0  # of χ², for a term worth saying
SIMPLE = (2.0, 1.0, 0.0, -1.0, 3.0, -2.0, 0.5, -0.5, 1.5, -1.5, 0.25, -0.25, 0.2)  # the simplest first


@dataclass(frozen=True)
class Family:
    """say(rises, power in words) → the law; columns(powers (K,)) → K columns in the form that the problem's `reduce` takes,
    each of unit size where the term is usual; rises: the coefficient is positive."""

    name: str
    say: Callable[[bool, str], str]
    columns: Callable[[np.ndarray], Any]
    powers: tuple[float, ...]


@dataclass(frozen=True)
class Law:
    """words; family; power with low, high of its 95 % range (∓inf at the end of what was tried); fall of χ²."""

    words: str
    family: str
    power: float
    low: float
    high: float
    fall: float


def law_of(base: Fit, families: tuple[Family, ...]) -> Law | None:
    """The best single term, or None where no term stands out, or none that serves left-out recordings."""
    found = [_best(base, family) for family in families]
    for fall, family, at, falls, reduced in sorted(found, key=lambda f: -f[0]):
        if fall < LEAST_FALL:
            return None
        if _ratio(base, reduced, len(base.names) + at) >= 1:
            continue  # it serves the recordings that it was read from, and no others
        low, high = _range(np.array(family.powers), falls, at)
        power = float(family.powers[at])
        rises = _coefficient(base, reduced, len(base.names) + at) > 0
        return Law(family.say(rises, in_words(power, low, high)), family.name, power, low, high, fall)
    return None


def in_words(power: float, low: float, high: float) -> str:
    """An exponent's estimate and 95 % interval as it stands in a law, with the whole or half number that it holds.

    >>> in_words(1.9, 1.7, 2.1)
    '^(1.9 ± 0.2), 2 being the simplest'
    >>> in_words(0.5, -np.inf, 3.0)
    '^(0.5, at most 3)'
    """
    if not np.isfinite(low) and not np.isfinite(high):
        return "^(a power that was not resolved)"
    if not np.isfinite(low) or not np.isfinite(high):
        side = f"at most {high:.2g}" if np.isfinite(high) else f"at least {low:.2g}"
        return f"^({power:.2g}, {side})"
    simple = next((s for s in SIMPLE if low <= s <= high), None)
    return f"^({power:.2g} ± {(high - low) / 2:.1g})" + ("" if simple is None else f", {simple:g} being the simplest")


def _best(base: Fit, family: Family):
    """(fall, family, which power, falls of all, reduced space with the family's columns)."""
    reduced, _ = base.problem.reduce(base.starts, base.values, family.columns(np.array(family.powers)))
    reduced = tuple(_common(r, len(base.names), len(family.powers)) for r in reduced)
    a, b = stacked(reduced)
    a, columns = np.split(a, [len(base.names)], axis=1)
    project = projector(a, base.prior_sd)
    falls = np.array([fall_of_chi2(columns[:, [k]], project, b)[0] for k in range(columns.shape[1])])
    at = int(np.argmax(falls))
    return float(falls[at]), family, at, falls, reduced


def _common(mine: Reduced, globals_: int, count: int) -> Reduced:
    """With `count` columns behind those of the globals: a law is the same in every session, whose columns stand one after the
    other."""
    a, columns = np.split(mine.a, [globals_], axis=1)
    return replace(mine, a=np.hstack([a, columns.reshape(len(a), columns.shape[1] // count, count).sum(axis=1)]))


def _range(powers: np.ndarray, falls: np.ndarray, at: int) -> tuple[float, float]:
    """Where χ² comes within WITHIN of the best, on a parabola between the powers tried; ∓inf where it does not rise enough."""
    fine = np.union1d(np.linspace(powers[0], powers[-1], 400), powers)  # the best itself is among them, however steep
    inside = fine[np.interp(fine, powers, falls) > falls[at] - WITHIN]
    low, high = float(inside.min()), float(inside.max())
    return (-np.inf if low <= powers[0] else low), (np.inf if high >= powers[-1] else high)


def _ratio(base: Fit, reduced: tuple[Reduced, ...], column: int) -> float:
    """rms of left-out recordings with the term over that without; 0 for a single recording: nothing is held out."""
    if len(reduced) < 2:
        return 0.0
    with_term = _prior(base, reduced, column)
    without = np.where(np.arange(len(with_term)) == column, 0.0, with_term)
    return float(np.sqrt(sum(missed(reduced, with_term)) / sum(missed(reduced, without))))


def _prior(base: Fit, reduced: tuple[Reduced, ...], column: int) -> np.ndarray:
    """The baseline's, and the term's own: wide beside what it may be."""
    a, b = stacked(reduced)
    out = np.zeros(a.shape[1])
    out[: len(base.names)] = base.prior_sd  # what was found beside it stays free
    out[column] = 10 * float(np.linalg.norm(b)) / max(float(np.linalg.norm(a[:, column])), 1e-300)
    return out


def _coefficient(base: Fit, reduced: tuple[Reduced, ...], column: int) -> float:
    return float(ridge(*stacked(reduced), _prior(base, reduced, column))[0][column])
