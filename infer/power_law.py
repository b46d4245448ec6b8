"""A power law for unlisted physics, by regression in the linearised problem.

Each family gives columns for powers of one quantity. The exponent is that of the
greatest fall of χ², with the range in which χ² lies within 3.84 of it; the term must
predict left-out recordings."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from benchtwin.infer.held_out import squared_errors
from benchtwin.infer.linear import Reduced, falls_of, ridge, stacked
from benchtwin.infer.problem import Fit

WITHIN_CHI2 = 3.84  # 95 % of one degree of freedom
LEAST_FALL = 12.0  # of χ², for a term to be reported
SIMPLE = (
    2.0,
    1.0,
    0.0,
    -1.0,
    3.0,
    -2.0,
    0.5,
    -0.5,
    1.5,
    -1.5,
    0.25,
    -0.25,
    0.2,
)  # the simplest first


@dataclass(frozen=True)
class Family:
    """Terms that differ in the power of one quantity."""

    say: Callable[[bool, str], str]  # (rises, power in words) → the law
    # (powers (K,)) → K columns as Problem.reduce takes them
    columns: Callable[[np.ndarray], Any]
    powers: tuple[float, ...]


def law_of(base: Fit, families: tuple[Family, ...]) -> str | None:
    """The best single term in words; None where none stands out or predicts left-out
    recordings."""
    found = []
    for family in families:
        columns = family.columns(np.array(family.powers))
        reduced = base.problem.reduce(base.starts, base.values, columns)[0]
        reduced = tuple(
            _common(r, len(base.names), len(family.powers)) for r in reduced
        )
        found.append((falls_of(reduced, base.prior_sd), family, reduced))
    for falls, family, reduced in sorted(found, key=lambda f: -f[0].max()):
        at = int(np.argmax(falls))
        if falls[at] < LEAST_FALL:
            return None
        a, b = stacked(reduced)
        column = len(base.names) + at
        without = np.zeros(a.shape[1])
        without[: len(base.names)] = base.prior_sd  # effects found stay free
        size = max(float(np.linalg.norm(a[:, column])), 1e-300)
        wide = 10 * float(np.linalg.norm(b)) / size
        term = np.where(np.arange(len(without)) == column, wide, without)
        if len(reduced) > 1:
            errors = [sum(squared_errors(reduced, sd)) for sd in (term, without)]
            if errors[0] >= errors[1]:
                continue  # it does not predict left-out recordings
        low, high = _range(np.array(family.powers), falls, at)
        rises = ridge(a, b, term)[0][column] > 0
        return family.say(bool(rises), in_words(float(family.powers[at]), low, high))
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
    return f"^({power:.2g} ± {(high - low) / 2:.1g})" + (
        "" if simple is None else f", {simple:g} being the simplest"
    )


def _common(mine: Reduced, globals_: int, count: int) -> Reduced:
    """With `count` columns behind the globals, summed over sessions: a law is common to
    all."""
    a, columns = np.split(mine.a, [globals_], axis=1)
    summed = columns.reshape(len(a), columns.shape[1] // count, count).sum(axis=1)
    return replace(mine, a=np.hstack([a, summed]))


def _range(powers: np.ndarray, falls: np.ndarray, at: int) -> tuple[float, float]:
    """Powers with χ² within WITHIN_CHI2 of the best; ∓inf where χ² does not rise
    enough."""
    # includes the best power itself
    fine = np.union1d(np.linspace(powers[0], powers[-1], 400), powers)
    inside = fine[np.interp(fine, powers, falls) > falls[at] - WITHIN_CHI2]
    low, high = float(inside.min()), float(inside.max())
    return (-np.inf if low <= powers[0] else low), (
        np.inf if high >= powers[-1] else high
    )
