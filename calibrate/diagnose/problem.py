"""A problem: what a session of recordings of one rig leaves open; and its fit, in the reduced space of every later question.

Gauss–Newton on the globals within their priors; what is each recording's own (the locals) is eliminated by the problem itself.
The rigs differ in how they predict; from here on they are all alike.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from calibrate.diagnose.effects.effect import Effect
from calibrate.diagnose.linear import Reduced, ridge, stacked

OUTSIDE = 10.0  # of χ²: ln of Bayes factor 5
POOR = 2.0  # χ² per degree of freedom above which a fit may have ended beside its minimum
STRAINED = 5.0  # sds of something known: likewise
TAIL = 2.0  # sds of a candidate's prior beyond which its tail begins
TAIL_TURNS = 6  # until the width is that of the value it gives
CLOSE = 0.01  # of χ² that a further step promises to take: a tenth of a sd in any direction


@dataclass(frozen=True, eq=False)
class Problem:
    """effects: candidates by name; names (G,): of all globals, candidates and nuisances, each 0 at the baseline's centre.

    known_sd: of each global in the baseline (what a good bench leaves open), absent: fixed at nil. starts: locals to begin with.
    reduce(starts, values (G,), extra=None) → (Reduced of each recording, function (change of globals) → change of starts); the
    columns of `extra`, K further accelerations or curves in the rig's own form, follow those of the globals.
    freedom: rows less locals; level_sd: sd of ln of the noise power where missing physics lives; model: the rig's own.
    elsewhere: further points (starts, values (G,)) at which a fit begins too, where they hold a candidate that is free: χ² has
    more than one minimum in it.
    nameless(fit) → (a (M, G), b (M,) of its reduced space, columns (M, k) there by sector): terms of no candidate's, few and
    common to all recordings; None where there are none.
    common_smooth: the smooth curves are one law common to all recordings, not each recording's own.
    """

    rig: str
    recordings: tuple[str, ...]
    effects: dict[str, Effect]
    names: tuple[str, ...]
    known_sd: dict[str, float]
    starts: np.ndarray
    reduce: Callable
    freedom: int
    level_sd: float
    model: Any
    turns: int = 5
    common_smooth: bool = False
    nameless: Callable | None = None
    elsewhere: tuple[tuple[np.ndarray, np.ndarray], ...] = ()

    @property
    def sectors(self) -> tuple[str, ...]:
        """Sectors of the candidates at hand, in their order."""
        return tuple(dict.fromkeys(self.effects[n].sector for n in self.names if n in self.effects))

    def columns_of(self, effect: str) -> tuple[str, ...]:
        """The globals of one candidate: its own, and the further parameters in its group."""
        return tuple(n for n in self.names if n == effect or (n in self.effects and self.effects[n].group == effect))


@dataclass(frozen=True, eq=False)
class Fit:
    """prior_sd (G,) with which each global was held (0: fixed at nil); values (G,), covariance (G, G); starts: the locals; χ²
    with its degrees of freedom, prior terms included; reduced: one a recording. known: what was worked out from here, by what was
    asked: the same few models answer many questions."""

    problem: Problem
    prior_sd: np.ndarray
    values: np.ndarray
    covariance: np.ndarray
    starts: np.ndarray
    chi2: float
    reduced: tuple[Reduced, ...]
    known: dict = field(default_factory=dict, repr=False)

    @property
    def names(self) -> tuple[str, ...]:
        return self.problem.names

    @property
    def freedom(self) -> int:
        return self.problem.freedom

    @property
    def by_name(self) -> dict[str, float]:
        return dict(zip(self.names, self.values, strict=True))

    def sd(self, name: str) -> float:
        """Standard deviation of one global."""
        i = self.names.index(name)
        return float(np.sqrt(self.covariance[i, i]))


def fit(problem: Problem, *, free: tuple[str, ...] = (), start: Fit | None = None) -> Fit:
    """From `start`, from elsewhere, or from the problem's own start where there is none or it leads nowhere; `free`: candidates
    with their physical prior. The same again from the same start is no work."""
    if start is None:
        known: dict = {}
        return replace(_descended(problem, free, problem.starts, np.zeros(len(problem.names)), known), known=known)
    asked = problem, frozenset(free), start.starts.tobytes(), start.values.tobytes()
    if asked not in start.known:
        start.known[asked] = _best_of(problem, free, start)
    return start.known[asked]


def _best_of(problem: Problem, free: tuple[str, ...], start: Fit) -> Fit:
    found = _descended(problem, free, start.starts, start.values, start.known)
    if not free:
        return found
    wide = np.isin(problem.names, [n for effect in free for n in problem.columns_of(effect)])
    points = [point for point in problem.elsewhere if point[1][wide].any()]
    if not found.chi2 < POOR * problem.freedom or _strain(found, ~wide) > STRAINED:
        points.append((problem.starts, np.zeros(len(problem.names))))
    others = [_descended(problem, free, *point, start.known) for point in points]
    return min([found, *others], key=lambda f: _beside_range(f, free))


def _strain(found: Fit, held: np.ndarray) -> float:
    """Sds by which the most strained of the globals `held` (G,) is off; those held at nil are not."""
    sds = np.where(held & (found.prior_sd > 0), found.prior_sd, np.inf)
    return float(np.max(np.abs(found.values) / sds, initial=0.0))


def _beside_range(found: Fit, free: tuple[str, ...]) -> float:
    """χ², and OUTSIDE more where a candidate is outside its physical range: of two minima as good the possible one holds."""
    effects = found.problem.effects
    possible = all(effects[n].low <= found.by_name[n] <= effects[n].high for n in free)
    return found.chi2 + (0.0 if possible else OUTSIDE) if np.isfinite(found.chi2) else np.inf


def _descended(problem: Problem, free: tuple[str, ...], starts: np.ndarray, values: np.ndarray, known: dict) -> Fit:
    """`known` has, or gets, the reduced space where it begins, which is that of every other fit from there."""
    wide = {n for effect in free for n in problem.columns_of(effect)}
    usual = np.array([problem.known_sd.get(n, 0.0) for n in problem.names])
    physical = np.array([problem.effects[n].prior_sd if n in wide else 0.0 for n in problem.names])
    usual, tailed = np.hypot(usual, physical), np.isin(problem.names, list(wide))
    values, prior = values * (usual > 0), usual
    lowest, good = np.inf, (starts, values)
    begun = problem.reduce, starts.tobytes(), values.tobytes()
    if begun not in known:
        known[begun] = problem.reduce(starts, values)
    for turn in range(problem.turns):
        there, solve_there = problem.reduce(starts, values) if turn else known[begun]
        here = _misfit(there, values, _with_tails(usual, tailed, values))
        refused = np.isfinite(lowest) and not here < _tolerated(lowest)
        if refused:  # too long a step, NaN included: half of it
            starts, values = (starts + good[0]) / 2, (values + good[1]) / 2
            continue
        good, lowest, reduced, solve_locals, after = (starts, values), here, there, solve_there, values
        a, b = stacked(reduced)
        for _ in range(TAIL_TURNS):
            prior = _with_tails(usual, tailed, after)
            after, covariance, chi2 = ridge(a, b, prior)
        starts, values = starts + solve_locals(after - values), after
        if here - _bulk(reduced) - chi2 < CLOSE:
            break
    else:  # a last step that nobody has looked at may lead anywhere
        there = problem.reduce(starts, values)[0]
        refused = refused or not _misfit(there, values, _with_tails(usual, tailed, values)) < _tolerated(lowest)
    if refused:
        (starts, values), chi2 = good, lowest - _bulk(reduced)
    return Fit(problem, prior, values, covariance, starts, chi2, reduced)


def _tolerated(lowest: float) -> float:
    """χ² that a step may end at: a little more than the lowest so far, for kinks."""
    return lowest + max(1.0, 1e-3 * lowest)


def _with_tails(prior_sd: np.ndarray, tailed: np.ndarray, values: np.ndarray) -> np.ndarray:
    """prior_sd (G,), of a candidate beyond TAIL sds √(sd |value|/TAIL): its prior falls as exp(−|value|/sd) there.

    What is rare is not impossible: a normal's tail would draw a strong effect towards nil and leave the rest to another.
    """
    return np.where(tailed, np.maximum(prior_sd, np.sqrt(prior_sd * np.abs(values) / TAIL)), prior_sd)


def _misfit(reduced: tuple[Reduced, ...], values: np.ndarray, prior: np.ndarray) -> float:
    """χ² at `values`, their prior terms included; where a problem does not tell it, with the locals at their linear best."""
    costs = [r.cost for r in reduced if r.cost is not None]
    held = prior > 0
    bent = float(((values[held] / prior[held]) ** 2).sum()) + _bulk(reduced)
    if len(costs) == len(reduced):
        return sum(costs) + bent
    a, b = stacked(reduced)
    return float(((b - a @ values) ** 2).sum()) + bent


def _bulk(reduced: tuple[Reduced, ...]) -> float:
    return 2 * sum(r.bulk for r in reduced)
