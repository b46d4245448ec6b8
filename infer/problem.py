"""A problem, and its fit: what recordings of one rig leave open.

Globals are nuisance parameters and effects, common to all recordings; locals are each
recording's own parameters, which the problem eliminates by itself.

reduce(starts, values (G,), extra=None) → (Reduced of each recording, function from a
change of globals to the change of locals). Columns of `extra` (K accelerations or
curves in the rig's own form) follow those of the globals."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from benchtwin.infer.effect import Effect
from benchtwin.infer.least_squares import (
    FastChi2,
    GlobalPrior,
    Linearisation,
    minimise,
)
from benchtwin.infer.linear import Reduced, ridge, stacked

OUT_OF_RANGE_CHI2 = 10.0  # penalty on χ²: a Bayes factor of e⁵
# χ² per degree of freedom above which a fit may be in a side minimum
RESTART_REDUCED_CHI2 = 2.0
RESTART_PRIOR_Z = 5.0  # the same, in sds of a nuisance


@dataclass(frozen=True, eq=False)
class Problem:
    """Recordings of one rig, their parameters and what linearises their prediction."""

    rig: str
    recordings: tuple[str, ...]
    effects: dict[str, Effect]  # candidates
    # (G,): all globals, effects and nuisances; 0 at the baseline's centre
    names: tuple[str, ...]
    # prior sd in the baseline; a global that is absent is fixed at 0
    known_sd: dict[str, float]
    starts: np.ndarray  # initial locals
    reduce: Callable  # see the module's docstring
    freedom: int  # rows less locals
    level_sd: float  # sd of the logarithm of the noise power at low frequency
    model: Any  # the rig's own
    max_iterations: int = 5
    # (problem, reduced) → UnknownScatter, or None
    unknown_scatter: Callable | None = None
    further_starts: tuple[tuple[np.ndarray, np.ndarray], ...] = ()  # starts and values
    fast_chi2: FastChi2 | None = None
    # (effect) → the same problem with one more candidate
    with_effect: Callable[[Effect], "Problem"] | None = None
    # prior sds (L,) of a recording's locals, inf where flat; of a problem of series
    # their centres (R, L), and (r, starts, values) → rows (n,), slopes (n, L + G)
    own_sd: np.ndarray = field(default_factory=lambda: np.zeros(0))
    own_centre: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    series: tuple = ()
    derivatives: Callable | None = None
    followed: tuple[str, ...] = ()  # globals by which a parameter follows conditions

    def columns_of(self, effect: str) -> tuple[str, ...]:
        """The globals of one effect: its own and the further parameters of its
        group."""
        return tuple(
            n
            for n in self.names
            if n == effect or (n in self.effects and self.effects[n].group == effect)
        )


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted problem."""

    problem: Problem
    prior_sd: np.ndarray  # (G,): 0 where a global was fixed
    values: np.ndarray
    covariance: np.ndarray
    starts: np.ndarray  # the fitted locals
    chi2: float  # prior included
    reduced: tuple[Reduced, ...]  # linearised there
    cache: dict = field(default_factory=dict, repr=False)

    @property
    def names(self) -> tuple[str, ...]:
        return self.problem.names

    @property
    def baseline_sd(self) -> np.ndarray:
        """Prior sd (G,) of the globals where no effect is free."""
        return np.array([self.problem.known_sd.get(n, 0.0) for n in self.names])

    @property
    def by_name(self) -> dict[str, float]:
        return dict(zip(self.names, self.values, strict=True))

    def sd(self, name: str) -> float:
        """Standard deviation of one global."""
        i = self.names.index(name)
        return float(np.sqrt(self.covariance[i, i]))


def fit(
    problem: Problem, *, free: tuple[str, ...] = (), start: Fit | None = None
) -> Fit:
    """Fit a problem with the effects `free`, each with its physical prior.

    Begins at `start`, at those of the problem's further starts that hold an effect, and
    where the fit is poor at its own start; without `start` at its own and at those
    further starts that hold no other effects. A repeated call with the same start is
    looked up.
    """
    if start is None:
        cache: dict = {}
        allowed = {n for effect in free for n in problem.columns_of(effect)}
        effects = np.isin(problem.names, list(problem.effects.keys() - allowed))
        points = [(problem.starts, np.zeros(len(problem.names)))]
        points += [p for p in problem.further_starts if not p[1][effects].any()]
        found = [_fit_from(problem, free, *p, cache) for p in points]
        return replace(
            min(found, key=lambda f: np.nan_to_num(f.chi2, nan=np.inf)), cache=cache
        )
    asked = problem, frozenset(free), start.starts.tobytes(), start.values.tobytes()
    if asked not in start.cache:
        start.cache[asked] = _best_fit(problem, free, start)
    return start.cache[asked]


def refined(near: Fit, free: tuple[str, ...]) -> Fit:
    """A fit with the effects `free`, at the minimum that is nearest to it."""
    return _fit_from(near.problem, free, near.starts, near.values, near.cache)


def _best_fit(problem: Problem, free: tuple[str, ...], start: Fit) -> Fit:
    """The best of the fits from all starting points."""
    found = refined(replace(start, problem=problem), free)
    if not free:
        return found
    wide = np.isin(
        problem.names, [n for effect in free for n in problem.columns_of(effect)]
    )
    points = [point for point in problem.further_starts if point[1][wide].any()]
    sds = np.where(~wide & (found.prior_sd > 0), found.prior_sd, np.inf)
    z = np.max(np.abs(found.values) / sds, initial=0.0)
    if not found.chi2 < RESTART_REDUCED_CHI2 * problem.freedom or z > RESTART_PRIOR_Z:
        points.append((problem.starts, np.zeros(len(problem.names))))

    def cost(f: Fit) -> float:
        """χ², plus a penalty where an effect lies outside its physical range."""
        ranges = (
            (problem.effects[n].low, f.by_name[n], problem.effects[n].high)
            for n in free
        )
        possible = all(low <= value <= high for low, value, high in ranges)
        if np.isfinite(f.chi2):
            return f.chi2 + OUT_OF_RANGE_CHI2 * (not possible)
        return np.inf

    return min(
        [found, *(_fit_from(problem, free, *p, start.cache) for p in points)], key=cost
    )


def _fit_from(
    problem: Problem,
    free: tuple[str, ...],
    starts: np.ndarray,
    values: np.ndarray,
    cache: dict,
) -> Fit:
    """Fit from one point; `cache` keeps the linearisation there, which other fits
    share."""
    wide = {n for effect in free for n in problem.columns_of(effect)}
    usual = np.array([problem.known_sd.get(n, 0.0) for n in problem.names])
    physical = np.array(
        [problem.effects[n].prior_sd if n in wide else 0.0 for n in problem.names]
    )
    # beyond its physical range a scale makes one law of another
    sizes = [n in wide and problem.effects[n].scaled_prior for n in problem.names]
    held = GlobalPrior(np.hypot(usual, physical), np.array(sizes, dtype=bool))
    values = values * (held.sd > 0)
    begun = problem.reduce, starts.tobytes(), values.tobytes()
    if begun not in cache:
        cache[begun] = problem.reduce(starts, values)
    end = minimise(
        problem.reduce,
        problem.fast_chi2,
        Linearisation.of(starts, values, cache[begun], held),
        held,
        problem.max_iterations,
    )
    return Fit(
        problem,
        end.prior,
        end.values,
        end.covariance,
        end.starts,
        end.chi2,
        end.reduced,
    )


def joint_covariance(of: Fit, looser: float = 1.0) -> np.ndarray:
    """Covariance (L + G, L + G) of the locals and the globals, of a problem of one
    recording; looser: factor on the sds of all rows."""
    reduced, change = of.problem.reduce(of.starts, of.values, looser=looser)
    still = change(np.zeros(len(of.values)))
    by = np.column_stack(
        [(change(row) - still).ravel() for row in np.eye(len(of.values))]
    )
    both = np.vstack([by, np.eye(len(of.values))])
    covariance = both @ ridge(*stacked(reduced), of.prior_sd)[1] @ both.T
    own = np.linalg.pinv(reduced[0].own)[: len(by)]
    covariance[: len(by), : len(by)] += own @ own.T
    return covariance


def ln_evidence(of: Fit) -> float:
    """Laplace's approximation of ln Z, up to a constant of the rows."""
    kept = of.prior_sd > 0
    scaled = of.covariance[np.ix_(kept, kept)] / np.outer(
        of.prior_sd[kept], of.prior_sd[kept]
    )
    return (
        -0.5 * of.chi2
        + 0.5 * float(np.linalg.slogdet(scaled)[1])
        - sum(r.half_ln_det for r in of.reduced)
    )
