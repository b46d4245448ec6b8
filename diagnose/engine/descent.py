"""Downhill to the least χ² of a problem that bends, its recordings' own numbers (the locals) eliminated at every place.

By Gauss and Newton's steps, halved where they lead too far. Where χ² itself is cheap to tell, by Levenberg and Marquardt's
(Marquardt, J. SIAM 11 (1963) 431): halves of a step along a bent valley gain next to nothing.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from diagnose.engine.linear import Reduced, ridge, stacked

TAIL = 2.0  # sds of a candidate's prior beyond which its tail begins
TAIL_TURNS = 6  # until the width is that of the value it gives
CLOSE = 0.01  # of χ² that a further step promises to take: a tenth of a sd in any direction
HALVINGS = 20  # of a step that is too long
DAMPINGS = np.r_[0.0, np.geomspace(1e-4, 1e6, 11)]  # of the curvature along each global
WORTH = 0.25  # of what a step promises: then no other is looked for
IDLE = 8  # steps about kinks that gain nothing, after which the best place seen is the end
IDLE_DOWN = 3  # the same where every step goes down


@dataclass(frozen=True)
class Cheap:
    """What a way down needs less of than `Problem.reduce` makes. cost(starts, values) → χ² of rows and locals at that very point;
    lean(starts, values, wanted (G,)) → as `reduce`, columns that are not wanted nil."""

    cost: Callable
    lean: Callable


@dataclass(frozen=True, eq=False)
class Held:
    """How globals are held: usual (G,) their sds about nil; tailed (G,): candidates that are free."""

    usual: np.ndarray
    tailed: np.ndarray

    def at(self, values: np.ndarray) -> np.ndarray:
        """sd (G,), of a candidate beyond TAIL sds √(sd |value|/TAIL): its prior falls as exp(−|value|/sd) there.

        What is rare is not impossible: a normal's tail would draw a strong effect towards nil and leave the rest to another.
        """
        return np.where(self.tailed, np.maximum(self.usual, np.sqrt(self.usual * np.abs(values) / TAIL)), self.usual)

    def strain(self, values: np.ndarray) -> float:
        """χ² of the prior."""
        prior = self.at(values)
        return float(((values[prior > 0] / prior[prior > 0]) ** 2).sum())


@dataclass(frozen=True, eq=False)
class Place:
    """A point of linearisation: χ² there (prior terms included), and what the linear problem promises: prior (G,) that holds the
    globals, their values and covariance, and χ² there."""

    starts: np.ndarray
    values: np.ndarray
    reduced: tuple[Reduced, ...]
    solve_locals: Callable
    chi2: float
    prior: np.ndarray
    promised: np.ndarray
    covariance: np.ndarray
    promised_chi2: float

    @classmethod
    def of(cls, starts: np.ndarray, values: np.ndarray, made: tuple, held: Held) -> "Place":
        """`made`: of Problem.reduce there."""
        reduced, solve_locals = made
        a, b = stacked(reduced)
        after = values
        for _ in range(TAIL_TURNS):
            prior = held.at(after)
            after, covariance, chi2 = ridge(a, b, prior)
        here = _misfit(reduced, values) + held.strain(values)
        return cls(starts, values, reduced, solve_locals, here, prior, after, covariance, chi2)

    @property
    def level(self) -> float:
        """χ² and what marginalising locals leaves: by that places compare."""
        return self.chi2 + 2 * sum(r.bulk for r in self.reduced)

    @property
    def gain(self) -> float:
        """By how much χ² falls if all is linear."""
        return self.chi2 - self.promised_chi2

    def to(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The step to these globals, the locals at their linear best there."""
        return self.starts + self.solve_locals(values - self.values), values

    def damped(self, damping: float) -> tuple[np.ndarray, np.ndarray]:
        """Marquardt's step, from sd to sd of each global."""
        a, b = stacked(self.reduced)
        kept, sd = self.prior > 0, self.prior[self.prior > 0]
        scaled = a[:, kept] * sd
        curvature = scaled.T @ scaled + np.eye(len(sd))
        down = scaled.T @ (b - a @ self.values) - self.values[kept] / sd
        moved = np.zeros(len(self.values))
        moved[kept] = sd * np.linalg.solve(curvature + damping * np.diag(np.diag(curvature)), down)
        return self.to(self.values + moved)

    def shorter(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """What is promised, half the way there, a quarter and so on."""
        starts, values = self.to(self.promised)
        for _ in range(HALVINGS):
            yield starts, values
            starts, values = (starts + self.starts) / 2, (values + self.values) / 2


@dataclass(frozen=True, eq=False)
class End:
    """Where a way down ends: prior (G,) and all else as of Problem and Fit."""

    prior: np.ndarray
    values: np.ndarray
    covariance: np.ndarray
    starts: np.ndarray
    chi2: float
    reduced: tuple[Reduced, ...]


def descend(reduce: Callable, cheap: Cheap | None, here: Place, held: Held, turns: int) -> End:
    """From `here` until nothing is left to gain, or `turns` times the problem was made linear."""
    best, idle, looks, damped, whole = here, 0, 1, 0, reduce if cheap else None
    while not (np.isfinite(here.chi2) and here.gain < CLOSE):
        if cheap:
            found, damped = _down(cheap, here, held, damped) if looks <= turns else (None, 0)
            looks += 1
        else:
            found, taken = _shorter(reduce, here, held, turns + 1 - looks)
            looks += taken
        idle += 1
        if found is None:
            return _ended(best, whole, held, stepped=False)
        here = found
        if not best.level - CLOSE <= here.level:
            best, idle = here, 0
        if idle >= (IDLE_DOWN if cheap else IDLE):
            return _ended(best, whole, held, stepped=False)
    return _ended(here, whole if looks > 1 else None, held, stepped=True)


def _ended(at: Place, reduce: Callable | None, held: Held, *, stepped: bool) -> End:
    """At a place, or a last step further; made whole by `reduce` where it is lean."""
    if reduce is not None:
        at = Place.of(at.starts, at.values, reduce(at.starts, at.values), held)
    if stepped:
        return End(at.prior, at.promised, at.covariance, at.to(at.promised)[0], at.promised_chi2, at.reduced)
    return End(at.prior, at.values, at.covariance, at.starts, at.chi2, at.reduced)


def _shorter(reduce: Callable, here: Place, held: Held, most: int) -> tuple[Place | None, int]:
    """The first place on the way to what is promised where χ² does not grow (NaN does); None where there is none, or none is
    found by looking at `most`; and at how many it was looked."""
    limit = _tolerated(here.level) if np.isfinite(here.level) else np.inf
    for looks, (starts, values) in zip(range(1, most + 1), here.shorter(), strict=False):
        there = Place.of(starts, values, reduce(starts, values), held)
        if there.level < limit or not np.isfinite(limit):
            return there, looks
    return None, most


def _down(cheap: Cheap, here: Place, held: Held, damped: int) -> tuple[Place | None, int]:
    """The step that takes most of χ², lean, and the number of its damping; None where none takes anything. damped: that of the
    step before, to begin near it."""

    def told(step: tuple[np.ndarray, np.ndarray]) -> float:
        with np.errstate(all="ignore"):
            chi2 = cheap.cost(*step) + held.strain(step[1])
        return chi2 if np.isfinite(chi2) else np.inf

    now = here.chi2 if np.isfinite(here.chi2) else np.inf
    best, number = here.to(here.promised), 0
    least = told(best)
    if not least < now - WORTH * here.gain:
        for k in range(max(damped - 1, 1), len(DAMPINGS)):
            step = here.damped(DAMPINGS[k])
            seen = told(step)
            if seen >= least and least < now:
                break
            best, least, number = (step, seen, k) if seen < least else (best, least, number)
    shorter = (step for step in here.shorter() if told(step) < now)
    chosen = best if least < now else next(shorter, None)
    if chosen is None:
        return None, 0
    return Place.of(*chosen, cheap.lean(*chosen, held.usual > 0), held), number


def _tolerated(lowest: float) -> float:
    """χ² that a step may end at: a little more than the lowest so far, for kinks."""
    return lowest + max(1.0, 1e-3 * lowest)


def _misfit(reduced: tuple[Reduced, ...], values: np.ndarray) -> float:
    """χ² at `values`; where a problem does not tell it, with the locals at their linear best."""
    costs = [r.cost for r in reduced if r.cost is not None]
    if len(costs) == len(reduced):
        return sum(costs)
    a, b = stacked(reduced)
    return float(((b - a @ values) ** 2).sum())
