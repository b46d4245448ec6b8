"""Legs of a roll with constant acceleration, fitted by least squares: each a parabola
that ends, or begins, at rest.

With two legs (incline and level) they share place, time and speed at the corner, but
for the speed lost there. Air drag bends each parabola a little. Light gates know the
place and measure the time: a row's error is σ_t times the speed, and the gate's own.
Stated sds are used unless the rows contradict them; otherwise the residuals give the
noise, with Student's t for few rows."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.least_squares import (
    all_stated,
    estimate_rho,
    propagate,
    variance_factor,
    whiten,
)
from scipy.optimize import least_squares

FEW_ROWS = 30  # with fewer, correlation between rows is not estimated


@dataclass(frozen=True)
class Leg:
    """A parabola about the time `at` [s]: place [mm], speed [mm/s], acceleration
    [mm/s²], drag over mass and inertia [1/mm]. It is constant before, or after, the
    time at which it is at rest."""

    at: float
    place: float
    speed: float
    acceleration: float
    drag: float

    def rest(self) -> float:
        """Time of rest [s]: before `at` where it speeds up, after `at` where it slows
        down."""
        return (
            self.at - self.speed / self.acceleration if self.acceleration else -math.inf
        )

    def _tau(self, time: np.ndarray) -> np.ndarray:
        late = self.rest() - self.at
        return np.asarray(
            np.maximum(time - self.at, late)
            if self.acceleration >= 0
            else np.minimum(time - self.at, late)
        )

    def x(self, time: np.ndarray) -> np.ndarray:
        """Place [mm] at `time` (n,) [s]."""
        tau, v, a = self._tau(time), self.speed, self.acceleration
        return (
            self.place
            + v * tau
            + a * tau**2 / 2
            - self.drag * tau**2 * (v**2 / 2 + v * a * tau / 3 + a**2 * tau**2 / 12)
        )

    def v(self, time: np.ndarray) -> np.ndarray:
        """Speed [mm/s] at `time` (n,) [s]."""
        tau, v, a = self._tau(time), self.speed, self.acceleration
        return v + a * tau - self.drag * tau * (v**2 + v * a * tau + a**2 * tau**2 / 3)


@dataclass(frozen=True)
class Rows:
    """Arrays (n,): time [s], x [mm] along the motion, its sd (NaN: not stated), frames
    since the row before; gates: of light gates."""

    time: np.ndarray
    x: np.ndarray
    sd: np.ndarray
    lag: np.ndarray
    gates: bool


@dataclass(frozen=True)
class Nuisance:
    """Nuisance parameters, which the rows do not determine. drag over mass and inertia
    [1/mm]; corner: its place [mm]; keep: share of the speed kept there; inertia: 1 +
    I/(m r²); incline [rad]; scale: 1 as stated."""

    drag: float
    corner: float
    keep: float
    inertia: float
    incline: float
    scale: float = 1.0


Legs = Callable[[np.ndarray, Nuisance], tuple[Leg, ...]]


@dataclass(frozen=True)
class LegFit:
    """Fitted params and their covariance (± 1.96 √var is a 95 % interval);
    misfit_doubt: why stated sds cannot hold, or ""."""

    params: np.ndarray
    cov: np.ndarray
    misfit_doubt: str


def fit_legs(rows: Rows, legs: Legs, start: np.ndarray, nuisance: Nuisance) -> LegFit:
    """Nonlinear least squares over the parameters of `legs`; MeasurementError where
    there are not more rows than unknowns."""
    n, freedom = len(rows.x), len(rows.x) - len(start)
    if freedom < 1:
        raise MeasurementError(
            f"{n} usable rows for {len(start)} unknowns: one more is needed"
        )
    stated = all_stated(rows.sd)
    unit, rho = np.maximum(np.abs(start), 1e-3 * np.ptp(rows.x)), 0.0

    def curve(p: np.ndarray) -> np.ndarray:
        return travel(legs(p, nuisance), rows.time)[0]

    for turn in range(3):  # again with the speeds and the correlation found before
        weight = np.ones(n)
        if rows.gates and not stated:
            speed = np.abs(travel(legs(start, nuisance), rows.time)[1])
            weight = 1 / np.maximum(speed, 0.05 * speed.max())
        weight = weight / rows.sd if stated else weight / np.median(weight)

        def misfit(
            u: np.ndarray, weight: np.ndarray = weight, rho: float = rho
        ) -> np.ndarray:
            return whiten((rows.x - curve(u * unit)) * weight, rows.lag, rho)

        found = least_squares(misfit, start / unit, method="lm", xtol=1e-13, ftol=1e-13)
        start = found.x * unit
        if turn == 0 and n >= FEW_ROWS:
            plain = least_squares(
                lambda u, w=weight: (rows.x - curve(u * unit)) * w,
                found.x,
                method="lm",
                max_nfev=1,
            )
            rho = estimate_rho(plain.jac, plain.fun, rows.lag)
    chi2 = max(
        float(found.fun @ found.fun),
        freedom * (1e-9 * np.abs(rows.x).max() * float(np.median(weight))) ** 2,
    )
    factor, doubt = variance_factor(chi2, freedom, stated)
    return LegFit(
        start,
        factor * np.linalg.pinv(found.jac.T @ found.jac) * np.outer(unit, unit),
        doubt,
    )


def travel(legs: tuple[Leg, ...], time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Place [mm] and speed [mm/s] (n,); the second of two legs begins at its `at`."""
    if len(legs) == 1:
        return legs[0].x(time), legs[0].v(time)
    late = time > legs[1].at
    return np.where(late, legs[1].x(time), legs[0].x(time)), np.where(
        late, legs[1].v(time), legs[0].v(time)
    )


def with_nuisance_errors(
    rows: Rows,
    legs: Legs,
    found: LegFit,
    nuisance: Nuisance,
    nuisance_sds: dict[str, float],
    derived: Callable,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values of `derived(params, nuisance)`, their sds, and the part of these that all
    rolls of a session share. Each nuisance parameter is moved by its sd and, where the
    fit depends on it, the legs are refitted. All these errors are shared, except that
    of the corner (where the seed was laid)."""
    value, fit_cov = propagate(lambda p: derived(p, nuisance), found.params, found.cov)
    variance, shared = np.diag(fit_cov).copy(), np.zeros(len(value))
    for name, sd in nuisance_sds.items():
        if sd and math.isfinite(getattr(nuisance, name)):
            other = replace(nuisance, **{name: getattr(nuisance, name) + sd})
            refitted = name in ("drag", "corner", "keep")
            params = (
                fit_legs(rows, legs, found.params, other).params
                if refitted
                else found.params
            )
            moved = np.nan_to_num(derived(params, other) - value) ** 2
            variance += moved
            shared += moved * (name != "corner")
    return value, np.sqrt(variance), np.sqrt(shared)
