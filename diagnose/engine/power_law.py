"""A power law for unlisted physics, by regression in the linearised problem.

Each family gives columns for powers of one quantity. The exponent is that of the greatest fall of
χ², with the range in which χ² lies within 3.84 of it; the term must predict left-out recordings.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from diagnose.engine.held_out import squared_errors
from diagnose.engine.linear import Reduced, beside_globals, fall_of_chi2, ridge, stacked
from diagnose.engine.problem import Fit

WITHIN_CHI2 = 3.84  # 95 % of one degree of freedom
LEAST_FALL = 12.0  # of χ², for a term to be reported
SIMPLE = (2.0, 1.0, 0.0, -1.0, 3.0, -2.0, 0.5, -0.5, 1.5, -1.5, 0.25, -0.25, 0.2)  # the simplest first


@dataclass(frozen=True)
class Family:
    """say(rises, power in words) → the law; rises: the coefficient is positive.

    columns(powers (K,)) → K columns as Problem.reduce takes them, of unit size where usual.
    """

    say: Callable[[bool, str], str]
    columns: Callable[[np.ndarray], Any]
    powers: tuple[float, ...]


def law_of(base: Fit, families: tuple[Family, ...]) -> str | None:
    """The best single term in words; None where none stands out or predicts left-out recordings."""
    found = [_best(base, family) for family in families]
    for fall, family, at, falls, reduced in sorted(found, key=lambda f: -f[0]):
        if fall < LEAST_FALL:
            return None
        if _ratio(base, reduced, len(base.names) + at) >= 1:
            continue  # it does not predict left-out recordings
        low, high = _range(np.array(family.powers), falls, at)
        rises = _coefficient(base, reduced, len(base.names) + at) > 0
        return family.say(rises, in_words(float(family.powers[at]), low, high))
    return None


def in_words(power: float, low: float, high: float) -> str:
    """An exponent's estimate and 95 % interval, with the simplest number in it.

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
    """(fall, family, number of the power, falls of all powers, linearisation with the columns)."""
    reduced, _ = base.problem.reduce(base.starts, base.values, family.columns(np.array(family.powers)))
    reduced = tuple(_common(r, len(base.names), len(family.powers)) for r in reduced)
    columns, project, b = beside_globals(reduced, base.prior_sd)
    falls = np.array([fall_of_chi2(columns[:, [k]], project, b)[0] for k in range(columns.shape[1])])
    at = int(np.argmax(falls))
    return float(falls[at]), family, at, falls, reduced


def _common(mine: Reduced, globals_: int, count: int) -> Reduced:
    """With `count` columns behind the globals, summed over sessions: a law is common to all."""
    a, columns = np.split(mine.a, [globals_], axis=1)
    return replace(mine, a=np.hstack([a, columns.reshape(len(a), columns.shape[1] // count, count).sum(axis=1)]))


def _range(powers: np.ndarray, falls: np.ndarray, at: int) -> tuple[float, float]:
    """Powers with χ² within WITHIN_CHI2 of the best; ∓inf where χ² does not rise enough."""
    fine = np.union1d(np.linspace(powers[0], powers[-1], 400), powers)  # includes the best power itself
    inside = fine[np.interp(fine, powers, falls) > falls[at] - WITHIN_CHI2]
    low, high = float(inside.min()), float(inside.max())
    return (-np.inf if low <= powers[0] else low), (np.inf if high >= powers[-1] else high)


def _ratio(base: Fit, reduced: tuple[Reduced, ...], column: int) -> float:
    """rms error of left-out recordings with the term over that without; 0 for one recording."""
    if len(reduced) < 2:
        return 0.0
    with_term = _prior(base, reduced, column)
    without = np.where(np.arange(len(with_term)) == column, 0.0, with_term)
    return float(np.sqrt(sum(squared_errors(reduced, with_term)) / sum(squared_errors(reduced, without))))


def _prior(base: Fit, reduced: tuple[Reduced, ...], column: int) -> np.ndarray:
    """Prior of the baseline, and a wide one of the term."""
    a, b = stacked(reduced)
    out = np.zeros(a.shape[1])
    out[: len(base.names)] = base.prior_sd  # effects found stay free
    out[column] = 10 * float(np.linalg.norm(b)) / max(float(np.linalg.norm(a[:, column])), 1e-300)
    return out


def _coefficient(base: Fit, reduced: tuple[Reduced, ...], column: int) -> float:
    return float(ridge(*stacked(reduced), _prior(base, reduced, column))[0][column])
