"""A problem: what a session of recordings of one rig leaves open; and its fit, in the reduced space of every later question.

The globals within their priors (descent.py); what is each recording's own (the locals) is eliminated by the problem itself.
The rigs differ in how they predict; from here on they are all alike.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from diagnose.effects.effect import Effect
from diagnose.engine.descent import Cheap, Held, Place, descend
from diagnose.engine.linear import Reduced

OUTSIDE = 10.0  # of χ²: ln of Bayes factor 5
POOR = 2.0  # χ² per degree of freedom above which a fit may have ended beside its minimum
STRAINED = 5.0  # sds of something known: likewise


@dataclass(frozen=True, eq=False)
class Problem:
    """effects: candidates by name; names (G,): of all globals, candidates and nuisances, each 0 at the baseline's centre.

    known_sd: of each global in the baseline (what a good bench leaves open), absent: fixed at nil. starts: locals to begin with.
    reduce(starts, values (G,), extra=None) → (Reduced of each recording, function (change of globals) → change of starts); the
    columns of `extra`, K further accelerations or curves in the rig's own form, follow those of the globals.
    freedom: rows less locals; level_sd: sd of ln of the noise power where missing physics lives; model: the rig's own.
    elsewhere: further points (starts, values (G,)) at which a fit begins too, where they hold a candidate that is free: χ² has
    more than one minimum in it.
    spread(problem, reduced) → evidence.Spread: scatter or noise whose size is not known beforehand; None where all is.
    turns: how often a fit may make it linear; cheap: what spares it `reduce` (None: nothing does).
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
    spread: Callable | None = None
    elsewhere: tuple[tuple[np.ndarray, np.ndarray], ...] = ()
    cheap: Cheap | None = None

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
    def baseline_sd(self) -> np.ndarray:
        """(G,) of the globals where no candidate is free."""
        return np.array([self.problem.known_sd.get(n, 0.0) for n in self.names])

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
    held = Held(np.hypot(usual, physical), np.isin(problem.names, list(wide)))
    values = values * (held.usual > 0)
    begun = problem.reduce, starts.tobytes(), values.tobytes()
    if begun not in known:
        known[begun] = problem.reduce(starts, values)
    cheap = None if any(problem.effects[n].follows for n in free) else problem.cheap
    end = descend(problem.reduce, cheap, Place.of(starts, values, known[begun], held), held, problem.turns)
    return Fit(problem, end.prior, end.values, end.covariance, end.starts, end.chi2, end.reduced)


def ln_evidence(of: Fit) -> float:
    """Laplace's, but for what is the same in all fits to the same rows."""
    kept = of.prior_sd > 0
    scaled = of.covariance[np.ix_(kept, kept)] / np.outer(of.prior_sd[kept], of.prior_sd[kept])
    return -0.5 * of.chi2 + 0.5 * float(np.linalg.slogdet(scaled)[1]) - sum(r.bulk for r in of.reduced)
