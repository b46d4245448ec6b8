"""Fit of all free flights of a drop: a parabola for each, one gravity for all, impacts
where successive parabolas meet.

    h(t) = a + b τ − γ τ²/2 + δ(t),    τ = t − middle of the flight

γ is gravity in the track's units, δ the effect of air drag (`drag_shift`). Where scale
and frame rate are stated, γ is g (1 + η)(1 + ε): ε the error of the scale, η that of
everything else. Both have priors with their sds, so that the curvature of the parabolas
refines the scale."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from benchtwin.bench.robust import robust_sd
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.least_squares import (
    Fit,
    all_stated,
    estimate_rho,
    fit,
    frame_lag,
)
from benchtwin.vision.motion.outliers import (
    SPIKE_SD,
    curve_residuals,
    off_curve,
    single_spikes,
)
from benchtwin.vision.motion.split_flights import free_flights, splits

# frames left out on either side of a contact; fewer only where a flight has hardly any
GUARDS = (2.0, 1.0, 0.5)
NO_FALL = (
    "no fall can be distinguished from how the seed was held: too much noise, or too"
    " few frames"
)


@dataclass(frozen=True)
class Gravity:
    """Prior of γ. value: g in the track's units, None where scale or frame rate is
    unknown; scale_sd: relative, of the scale; other_sd: relative, of everything else
    (perspective, air); drag: k in a = −k v |v|, per length unit of the track."""

    value: float | None
    scale_sd: float = 0.0
    other_sd: float = 1e-3
    drag: float = 0.0


@dataclass(frozen=True)
class Flights:
    """F flights fitted together. rows: those used of each flight; params: a₀ b₀ a₁ b₁ …
    γ ε (2F + 2), with cov; middle (F,): times from which τ counts; free, free_sd: γ by
    the parabolas alone, without a prior; outlier (n,): of all rows; guard: frames left
    out on either side of a contact; unused: whether lowest points before the first
    flight are no contacts (a hand, a slip of the tracker)."""

    rows: tuple[np.ndarray, ...]
    time: np.ndarray  # (n,) of all rows
    middle: np.ndarray
    params: np.ndarray
    cov: np.ndarray
    noise: float
    rho: float
    free: float
    free_sd: float
    outlier: np.ndarray
    guard: float
    drag: float
    unused: bool = False

    @property
    def gamma(self) -> float:
        return float(self.params[-2])

    def apex_time(self, flight: int, params: np.ndarray | None = None) -> float:
        p = self.params if params is None else params
        return self.middle[flight] + p[2 * flight + 1] / p[-2]

    def height(self, flight: int, time: Any, params: np.ndarray | None = None) -> Any:
        """Height at `time`, a number or an array."""
        p = self.params if params is None else params
        tau = time - self.middle[flight]
        parabola = p[2 * flight] + p[2 * flight + 1] * tau - p[-2] * tau**2 / 2
        return (
            parabola + drag_shift(time - self.apex_time(flight, p), p[-2], self.drag)[0]
        )

    def speed(self, flight: int, time: Any, params: np.ndarray | None = None) -> Any:
        """dh/dt, upwards, at `time`, a number or an array."""
        p = self.params if params is None else params
        late = time - self.apex_time(flight, p)
        return (
            p[2 * flight + 1]
            - p[-2] * (time - self.middle[flight])
            + drag_shift(late, p[-2], self.drag)[1]
        )

    def contact_times(self) -> list[float]:
        """Times of the impacts, and of the landing that ends the last flight (by
        symmetry about its apex); empty without impacts."""
        last = len(self.rows) - 1
        times = [self.contact_time(k) for k in range(last)]
        return [*times, 2 * self.apex_time(last) - times[-1]] if times else []

    def contact_states(self) -> list[tuple[float, float]]:
        """Height and speed at each impact."""
        times = [(k, self.contact_time(k)) for k in range(len(self.rows) - 1)]
        return [(float(self.height(k, t)), float(self.speed(k, t))) for k, t in times]

    def fall(self, params: np.ndarray | None = None) -> float:
        """Height from the first flight's apex to its impact."""
        p = self.params if params is None else params
        return float(
            self.height(0, self.apex_time(0, p), p)
            - self.height(0, self.contact_time(0, p), p)
        )

    def contact_time(self, flight: int, params: np.ndarray | None = None) -> float:
        """Time at which a flight and the next one meet: linear for parabolas of one γ,
        then corrected for drag."""
        p = self.params if params is None else params
        shift = self.middle[flight + 1] - self.middle[flight]
        a0, b0, a1, b1 = p[2 * flight : 2 * flight + 4]
        a1, b1 = a1 - b1 * shift - p[-2] * shift**2 / 2, b1 + p[-2] * shift
        time = self.middle[flight] + (a1 - a0) / (b0 - b1)
        for _ in range(3 if self.drag else 0):
            gap = self.height(flight + 1, time, p) - self.height(flight, time, p)
            time -= gap / (
                self.speed(flight + 1, time, p) - self.speed(flight, time, p)
            )
        return float(time)


def drag_shift(late: Any, gamma: float, drag: float) -> tuple[Any, Any]:
    """Height and speed that quadratic drag adds to a parabola at the time `late` from
    its apex. a = −k v |v| along v = −γ t, integrated twice with the undisturbed v: ± k
    γ² t⁴/12 and k γ² |t|³/3. First order in k: correct to 0.03 % of the speed for a
    soybean falling 310 mm, where drag takes 0.9 %."""
    return (
        drag * gamma**2 * late**3 * np.abs(late) / 12,
        drag * gamma**2 * np.abs(late) ** 3 / 3,
    )


def fit_flights(
    time: np.ndarray,
    frame: np.ndarray,
    height: np.ndarray,
    across: np.ndarray,
    sd: np.ndarray,
    gravity: Gravity,
) -> Flights:
    """Fit all flights of a track together; sd (n,): of each row, or NaN; across (n,):
    used to find outliers only.

    Of the moments at which the seed may have been let go, that is taken whose flights
    tell most of the whole track."""
    step = float(np.median(np.diff(time) / np.diff(frame)))
    weight = _weights(sd)
    tried: list[_Tried] = []
    errors: list[MeasurementError] = []
    for begin, ranges in enumerate(splits(height)):
        most = max((len(t.residual) for t in tried), default=0)
        if ranges[-1][1] - ranges[0][0] < most:
            continue  # fewer rows than are explained already
        try:
            free = _free(ranges, time, frame, height, across, weight, gravity, step)
        except MeasurementError as error:
            errors.append(error)
            continue
        if free.flights.free > 0:
            tried.append(replace(free, begin=begin))
    if not tried:
        raise errors[0] if errors else MeasurementError(NO_FALL)
    best = max(tried, key=lambda t: t.explained(height))
    if len(best.flights.rows) == 1 and best.explained(height) <= 0:
        raise MeasurementError(NO_FALL)
    times = best.flights.contact_times()
    rows, guard = _usable(best.ranges, times, time, best.outlier, step)
    flights, _ = fit_rows(
        rows, time, frame, height, weight, gravity, best.outlier, guard, quick=False
    )
    return replace(flights, unused=bool(best.begin))


@dataclass(frozen=True, eq=False)
class _Tried:
    """The free flights if the seed was let go behind a lowest point, number `begin`."""

    flights: Flights
    residual: np.ndarray
    ranges: list[tuple[int, int]]
    outlier: np.ndarray
    begin: int = 0

    def explained(self, height: np.ndarray) -> float:
        """ln of how much better the flights (a place and a speed each, and gravity)
        tell their rows than a seed that is held, or lies, does."""
        rows, reach = self.flights.rows, float(np.ptp(height))
        still = (_explained(height[r] - np.median(height[r]), 1, reach) for r in rows)
        flown = _explained(self.residual, 2 * len(rows) + 1, reach)
        return flown - sum(max(one, 0.0) for one in still)


def _free(ranges, time, frame, height, across, weight, gravity, step) -> _Tried:
    """The free flights among these ranges, outliers told apart."""
    outlier = single_spikes(height)
    contact_times = [time[stop - 1] for _, stop in ranges[:-1]]
    for _ in range(3):
        rows, guard = _usable(ranges, contact_times, time, outlier, step)
        flights, residual = fit_rows(
            rows, time, frame, height, weight, gravity, outlier, guard, quick=True
        )
        contact_times = flights.contact_times()
        outlier = outlier | _spikes(rows, residual, time, height)
        for r in rows:
            outlier[r] |= off_curve(time[r], across[r])
        ranges = ranges[
            : free_flights(rows, time, height, residual, flights.contact_states(), step)
        ]
    return _Tried(flights, residual, ranges, outlier)


def _explained(residual: np.ndarray, unknowns: int, reach: float) -> float:
    """ln of how much better the places are told than by "anywhere within reach"; a row
    far off counts as that (heavy tails), and each unknown costs as much as a row
    tells."""
    freedom = len(residual) - unknowns
    if freedom < 1:
        return 0.0
    sd = robust_sd(residual) * math.sqrt(len(residual) / freedom)
    sd = max(sd, 1e-6 * reach)
    density = np.exp(-0.5 * (residual / sd) ** 2) / (math.sqrt(2 * math.pi) * sd)
    told = float(np.log1p(reach * density).sum())
    return told - unknowns * math.log1p(reach / sd)


def _spikes(
    rows, residual: np.ndarray, time: np.ndarray, height: np.ndarray
) -> np.ndarray:
    """Mask of the rows far off their flight, but not of those on a smooth curve, by
    which air may bend it."""
    mask = np.zeros(len(time), dtype=bool)
    if len(residual) < 4 * (2 * len(rows) + 1):
        return mask
    limit = SPIKE_SD * robust_sd(residual) + 1e-12
    for r, off in zip(rows, np.split(residual, np.cumsum([len(r) for r in rows])[:-1])):
        odd = np.abs(off) > limit
        if (
            not 0 < odd.sum() < 0.3 * len(r)
        ):  # more is not an outlier but a flight that is no parabola
            continue
        left = curve_residuals(time[r], height[r])
        on_curve = (np.abs(left) <= limit) & (robust_sd(left) < limit / 3)
        mask[r[odd & ~on_curve]] = True
    return mask


def _weights(sd: np.ndarray) -> np.ndarray:
    return np.median(sd) / sd if all_stated(sd) else np.ones(len(sd))


def _places_and_speeds(
    rows: Sequence[np.ndarray], time: np.ndarray, middle: np.ndarray, more: int
) -> np.ndarray:
    """Design of a place and a speed for each flight, (rows, 2F + more), its last
    columns 0."""
    design = np.zeros((sum(map(len, rows)), 2 * len(rows) + more))
    at = 0
    for k, r in enumerate(rows):
        design[at : at + len(r), 2 * k : 2 * k + 2] = np.column_stack(
            [np.ones(len(r)), time[r] - middle[k]]
        )
        at += len(r)
    return design


def _usable(
    ranges, contact_times, time, outlier, step
) -> tuple[tuple[np.ndarray, ...], float]:
    """Rows of each flight without those within 2 frames of a contact, or fewer where a
    flight would have less than 4 rows."""
    rows, least = [], GUARDS[0]
    for k, (start, stop) in enumerate(ranges):
        low = contact_times[k - 1] if k else -np.inf
        high = contact_times[k] if k < len(contact_times) else np.inf
        here = np.arange(
            max(start - 2, 0) if k else start,
            min(stop + 2, len(time)) if k < len(contact_times) else stop,
        )
        here = here[~outlier[here]]
        for guard in (
            GUARDS if k < 2 else GUARDS[:2]
        ):  # later bounces need well separated rows
            kept = here[
                (time[here] > low + guard * step) & (time[here] < high - guard * step)
            ]
            if len(kept) >= 4:
                break
        if len(kept) < (3, 2, 4)[min(k, 2)]:
            if k == 0 and len(ranges) > 1:
                raise MeasurementError(
                    f"only {len(kept)} frames before the first contact; a speed needs 3"
                )
            break
        rows.append(kept)
        least = min(least, guard)
    if not rows:
        raise MeasurementError("no flight of at least 3 frames")
    return tuple(rows), least


def fit_rows(
    rows: tuple[np.ndarray, ...],
    time: np.ndarray,
    frame: np.ndarray,
    height: np.ndarray,
    weight: np.ndarray,
    gravity: Gravity,
    outlier: np.ndarray,
    guard: float,
    quick: bool,
    noise: float | None = None,
) -> tuple[Flights, np.ndarray]:
    """Flights fitted to their rows, and the weighted residuals; quick: as if the noise
    were white; noise: of a row of weight 1, where it is not to be estimated."""
    used = np.concatenate(rows)
    middle = np.array([time[r].mean() for r in rows])
    design = _places_and_speeds(rows, time, middle, 2)
    design[:, -2] = -(design[:, 1:-2:2].sum(axis=1) ** 2) / 2
    lag = frame_lag(frame[used])
    target = height[used]
    solved = _solve(design, target, lag, weight[used], gravity, quick, noise)
    for _ in range(2 if gravity.drag else 0):
        params = solved[0].params
        late = np.concatenate(
            [
                time[r] - middle[k] - params[2 * k + 1] / params[-2]
                for k, r in enumerate(rows)
            ]
        )
        shifted = target - drag_shift(late, params[-2], gravity.drag)[0]
        solved = _solve(design, shifted, lag, weight[used], gravity, quick, noise)
    found, free = solved
    return (
        Flights(
            rows,
            time,
            middle,
            found.params,
            found.cov,
            found.noise,
            found.rho,
            float(free.params[-1]),
            float(np.sqrt(free.cov[-1, -1])),
            outlier,
            guard,
            gravity.drag,
        ),
        found.residuals * weight[used],
    )


def _solve(
    design, target, lag, weight, gravity: Gravity, quick: bool, noise: float | None
) -> tuple[Fit, Fit]:
    """The fit with the prior of gravity, and the one without."""
    bare = design[:, :-1]
    rho = 0.0 if quick else estimate_rho(bare * weight[:, None], target * weight, lag)
    free = fit(bare, target, lag, weight=weight, rho=rho, noise=noise)
    scale_row = np.zeros(design.shape[1])
    scale_row[-1] = 1.0
    rows, values, sds = [scale_row], [0.0], [max(gravity.scale_sd, 1e-9)]
    if gravity.value is not None:
        link = -scale_row.copy()
        link[-2] = 1 / gravity.value
        rows, values, sds = (
            [*rows, link],
            [*values, 1.0],
            [*sds, max(gravity.other_sd, 1e-9)],
        )
    prior = (np.array(rows), np.array(values), np.array(sds))
    found = fit(design, target, lag, weight=weight, rho=rho, prior=prior, noise=noise)
    return found, free


def fit_lateral(
    flights: Flights,
    time: np.ndarray,
    frame: np.ndarray,
    across: np.ndarray,
    sd: np.ndarray,
    plumb_sd: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Fit c + u τ + a τ²/2 sideways for each flight (c₀ u₀ c₁ u₁ … a, and their
    covariance); sd of a: γ times `plumb_sd` [rad]."""
    used = np.concatenate(flights.rows)
    design = _places_and_speeds(flights.rows, time, flights.middle, 1)
    design[:, -1] = design[:, 1:-1:2].sum(axis=1) ** 2 / 2
    row = np.zeros((1, design.shape[1]))
    row[0, -1] = 1.0
    prior = (row, np.zeros(1), np.array([max(plumb_sd, 1e-6) * abs(flights.gamma)]))
    found = fit(
        design,
        across[used],
        frame_lag(frame[used]),
        weight=_weights(sd)[used],
        prior=prior,
    )
    return found.params, found.cov
