"""Nonlinear least squares over the globals of a problem, local parameters eliminated.

Gauss–Newton with step halving; where χ² itself is cheap to compute, Levenberg–Marquardt
(Marquardt, J. SIAM 11 (1963) 431), which makes headway along curved valleys."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from benchtwin.infer.linear import Reduced, ridge, stacked

TAIL_SDS = 2.0  # sds of an effect's prior beyond which its tail is exponential
TAIL_ITERATIONS = 6  # until the tail's width agrees with the value
CONVERGED_CHI2 = 0.01  # predicted fall of χ² at which a fit has converged
MAX_HALVINGS = 20
# relative to the curvature along each global
DAMPINGS = np.r_[0.0, np.geomspace(1e-4, 1e6, 11)]
SUFFICIENT_FALL = 0.25  # share of the predicted fall that makes a step good enough
SETTLING_STEPS = 2  # of Gauss–Newton, of the locals alone
# steps without a better point (kinks), after which the best one is taken
MAX_IDLE_STEPS = 8
MAX_IDLE_DESCENTS = 3  # the same where every step lowers χ²


@dataclass(frozen=True)
class FastChi2:
    """Cheaper alternatives to `Problem.reduce`, for a minimiser that tries many
    steps."""

    chi2: Callable  # (starts, values) → χ² of rows and local parameters at that point
    reduce_free: Callable  # (starts, values, wanted (G,)); columns not wanted are zero


@dataclass(frozen=True, eq=False)
class GlobalPrior:
    """Prior of the globals: sd (G,) about 0, and which of them (G,) have an exponential
    tail."""

    sd: np.ndarray
    heavy_tailed: np.ndarray

    def sd_at(self, values: np.ndarray) -> np.ndarray:
        """Standard deviations (G,) at these values.

        √(sd |value|/TAIL_SDS) in the tail, so that the prior falls as exp(−|value|/sd):
        a normal one would shrink a strong effect and leave the rest of it to another.
        """
        wider = np.sqrt(self.sd * np.abs(values) / TAIL_SDS)
        return np.where(self.heavy_tailed, np.maximum(self.sd, wider), self.sd)

    def chi2(self, values: np.ndarray) -> float:
        """χ² of the prior."""
        prior = self.sd_at(values)
        return float(((values[prior > 0] / prior[prior > 0]) ** 2).sum())


@dataclass(frozen=True, eq=False)
class Linearisation:
    """A problem linearised at a point, and the minimum of the linear problem."""

    starts: np.ndarray  # the point
    values: np.ndarray
    reduced: tuple[Reduced, ...]
    change_of_locals: Callable  # this and reduced: from Problem.reduce
    chi2: float  # at the point, prior included
    prior: np.ndarray  # (G,): sd of each global
    predicted: np.ndarray
    covariance: np.ndarray
    predicted_chi2: float

    @classmethod
    def of(
        cls, starts: np.ndarray, values: np.ndarray, made: tuple, held: GlobalPrior
    ) -> "Linearisation":
        """From what Problem.reduce made at a point."""
        reduced, change_of_locals = made
        a, b = stacked(reduced)
        after = values
        for _ in range(TAIL_ITERATIONS):
            prior = held.sd_at(after)
            after, covariance, chi2 = ridge(a, b, prior)
        here = _misfit(reduced, values) + held.chi2(values)
        return cls(
            starts,
            values,
            reduced,
            change_of_locals,
            here,
            prior,
            after,
            covariance,
            chi2,
        )

    @property
    def marginal_chi2(self) -> float:
        """χ² and the log-determinant of the eliminated locals, by which points
        compare."""
        return self.chi2 + 2 * sum(r.half_ln_det for r in self.reduced)

    @property
    def predicted_fall(self) -> float:
        """By how much χ² falls if the problem is linear."""
        return self.chi2 - self.predicted_chi2

    def step_to(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The step to these globals, the locals at their linear best there."""
        return self.starts + self.change_of_locals(values - self.values), values

    def marquardt_step(self, damping: float) -> tuple[np.ndarray, np.ndarray]:
        """Marquardt's step for this damping, each global scaled by its sd."""
        a, b = stacked(self.reduced)
        kept, sd = self.prior > 0, self.prior[self.prior > 0]
        scaled = a[:, kept] * sd
        curvature = scaled.T @ scaled + np.eye(len(sd))
        down = scaled.T @ (b - a @ self.values) - self.values[kept] / sd
        moved = np.zeros(len(self.values))
        moved[kept] = sd * np.linalg.solve(
            curvature + damping * np.diag(np.diag(curvature)), down
        )
        return self.step_to(self.values + moved)

    def halved_steps(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """The full Gauss–Newton step, half of it, a quarter, and so on."""
        starts, values = self.step_to(self.predicted)
        for _ in range(MAX_HALVINGS):
            yield starts, values
            starts, values = (starts + self.starts) / 2, (values + self.values) / 2


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where the minimiser ended; prior (G,), all else as in Problem and Fit."""

    prior: np.ndarray
    values: np.ndarray
    covariance: np.ndarray
    starts: np.ndarray
    chi2: float
    reduced: tuple[Reduced, ...]


def minimise(
    reduce: Callable,
    fast: FastChi2 | None,
    here: Linearisation,
    held: GlobalPrior,
    max_iterations: int,
) -> Minimum:
    """From `here` until no step is predicted to gain, or after `max_iterations`
    linearisations."""
    best, idle, evaluations, damped, whole = here, 0, 1, 0, reduce if fast else None
    while not (np.isfinite(here.chi2) and here.predicted_fall < CONVERGED_CHI2):
        if fast:
            found, damped = (
                _marquardt_descent(fast, here, held, damped)
                if evaluations <= max_iterations
                else (None, 0)
            )
            evaluations += 1
        else:
            found, taken = _halved_step(
                reduce, here, held, max_iterations + 1 - evaluations
            )
            evaluations += taken
        idle += 1
        if found is None:
            return _ended(best, whole, held, stepped=False)
        here = found
        if not best.marginal_chi2 - CONVERGED_CHI2 <= here.marginal_chi2:
            best, idle = here, 0
        if idle >= (MAX_IDLE_DESCENTS if fast else MAX_IDLE_STEPS):
            return _ended(best, whole, held, stepped=False)
    return _ended(here, whole if evaluations > 1 else None, held, stepped=True)


def _ended(
    at: Linearisation, reduce: Callable | None, held: GlobalPrior, *, stepped: bool
) -> Minimum:
    """The result at a point, or after a last linear step; `reduce` completes a partial
    one."""
    if reduce is not None:
        at = Linearisation.of(at.starts, at.values, reduce(at.starts, at.values), held)
    if stepped:
        starts = at.step_to(at.predicted)[0]
        return Minimum(
            at.prior, at.predicted, at.covariance, starts, at.predicted_chi2, at.reduced
        )
    return Minimum(at.prior, at.values, at.covariance, at.starts, at.chi2, at.reduced)


def _halved_step(
    reduce: Callable, here: Linearisation, held: GlobalPrior, most: int
) -> tuple[Linearisation | None, int]:
    """The first of `most` halved steps at which χ² does not grow, or None; and its
    number."""
    # predictions have kinks, so a step may end a little higher
    before = here.marginal_chi2
    limit = before + max(1.0, 1e-3 * before) if np.isfinite(before) else np.inf
    for evaluations, (starts, values) in zip(
        range(1, most + 1), here.halved_steps(), strict=False
    ):
        there = Linearisation.of(starts, values, reduce(starts, values), held)
        if there.marginal_chi2 < limit or not np.isfinite(limit):
            return there, evaluations
    return None, most


def _marquardt_descent(
    fast: FastChi2, here: Linearisation, held: GlobalPrior, damped: int
) -> tuple[Linearisation | None, int]:
    """The step that lowers χ² most, or None; number of its damping, sought near
    `damped`."""

    def chi2_of(step: tuple[np.ndarray, np.ndarray]) -> float:
        with np.errstate(all="ignore"):
            chi2 = fast.chi2(*step) + held.chi2(step[1])
        return chi2 if np.isfinite(chi2) else np.inf

    now = here.chi2 if np.isfinite(here.chi2) else np.inf
    enough = now - SUFFICIENT_FALL * here.predicted_fall
    best, number = here.step_to(here.predicted), 0
    least = chi2_of(best)
    if enough <= least < np.inf:
        settled = _settled(fast, best)
        least, best = min((least, 0, best), (chi2_of(settled), 1, settled))[::2]
    if not least < enough:
        for k in range(max(damped - 1, 1), len(DAMPINGS)):
            step = here.marquardt_step(DAMPINGS[k])
            seen = chi2_of(step)
            if seen >= least and least < now:
                break
            best, least, number = (
                (step, seen, k) if seen < least else (best, least, number)
            )
    halved_steps = (step for step in here.halved_steps() if chi2_of(step) < now)
    chosen = best if least < now else next(halved_steps, None)
    if chosen is None:
        return None, 0
    return Linearisation.of(
        *chosen, fast.reduce_free(*chosen, held.sd > 0), held
    ), number


def _settled(
    fast: FastChi2, step: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """A step with its locals moved on to where they fit best beside the globals: where
    a local acts through a global, their product is not in either's derivative."""
    starts, values = step
    for _ in range(SETTLING_STEPS):
        change = fast.reduce_free(starts, values, np.zeros(len(values), dtype=bool))[1]
        starts = starts + change(np.zeros(len(values)))
    return starts, values


def _misfit(reduced: tuple[Reduced, ...], values: np.ndarray) -> float:
    """χ² at `values`; where the problem does not give it, with the locals at their
    linear best."""
    costs = [r.chi2 for r in reduced if r.chi2 is not None]
    if len(costs) == len(reduced):
        return sum(costs)
    a, b = stacked(reduced)
    return float(((b - a @ values) ** 2).sum())
