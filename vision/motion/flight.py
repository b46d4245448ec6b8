"""Free flights between contacts: one parabola a flight, one gravity for all, impacts where successive parabolas meet.

    h(t) = a + b τ − γ τ²/2 + δ(t),    τ = t − middle of the flight

γ is gravity in the track's own units, δ what air drag does to a parabola (`drag_shift`; nil when the air is left out).
Where scale and frame rate are stated γ is g (1 + η)(1 + ε): ε the scale's stated error, η what else bends a parabola.
Both float within their sd, so that a parabola's own curvature refines the scale and never fights it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from vision.measurement import MeasurementError
from vision.motion.contacts import split
from vision.motion.correlated import Fit, estimate_rho, fit, frame_lag
from vision.motion.free import free_flights
from vision.motion.strays import SPIKE_SD, about_curve, off_curve, robust_sd, single_spikes

G_MM_S2 = 9806.65
GUARDS = (2.0, 1.0, 0.5)  # frames left out on either side of a contact; fewer only where a flight has hardly any
LEAST_FALL = 0.3  # of all that is seen: a flight without a contact that goes less far was none


@dataclass(frozen=True)
class Gravity:
    """What is known of γ beforehand. value: g in the track's units, None when scale or frame rate is unknown.

    scale_sd: relative sd of the scale. other_sd: relative sd of everything else (perspective, air).
    drag: k in a = −k v |v|, per length unit of the track.
    """

    value: float | None
    scale_sd: float = 0.0
    other_sd: float = 1e-3
    drag: float = 0.0


@dataclass(frozen=True)
class Flights:
    """F flights fitted together. params: a₀ b₀ a₁ b₁ … γ ε (2F + 2), with cov. rows: the used rows of each flight."""

    rows: tuple[np.ndarray, ...]
    time: np.ndarray  # (n,) of all rows
    middle: np.ndarray
    params: np.ndarray
    cov: np.ndarray
    noise: float
    rho: float
    free: float  # γ as the parabolas alone give it, no prior
    free_sd: float
    outlier: np.ndarray  # (n,) of all rows
    guard: float
    drag: float

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
        return parabola + drag_shift(time - self.apex_time(flight, p), p[-2], self.drag)[0]

    def speed(self, flight: int, time: Any, params: np.ndarray | None = None) -> Any:
        """dh/dt, upwards, at `time`, a number or an array."""
        p = self.params if params is None else params
        late = time - self.apex_time(flight, p)
        return p[2 * flight + 1] - p[-2] * (time - self.middle[flight]) + drag_shift(late, p[-2], self.drag)[1]

    def contacts(self) -> list[float]:
        """Times of the impacts, and of the landing that ends the last flight (as long after its apex as it began before)."""
        last = len(self.rows) - 1
        meets = [self.meeting(k) for k in range(last)]
        return meets if not meets else [*meets, 2 * self.apex_time(last) - meets[-1]]

    def meets(self) -> list[tuple[float, float]]:
        """Height and speed at each impact."""
        times = [(k, self.meeting(k)) for k in range(len(self.rows) - 1)]
        return [(float(self.height(k, t)), float(self.speed(k, t))) for k, t in times]

    def fall(self, params: np.ndarray | None = None) -> float:
        """From the first flight's apex to the height of its impact."""
        p = self.params if params is None else params
        return float(self.height(0, self.apex_time(0, p), p) - self.height(0, self.meeting(0, p), p))

    def meeting(self, flight: int, params: np.ndarray | None = None) -> float:
        """When flight `flight` ends and the next begins: where the two parabolas meet (linear: γ is common), then drag."""
        p = self.params if params is None else params
        shift = self.middle[flight + 1] - self.middle[flight]
        a0, b0, a1, b1 = p[2 * flight : 2 * flight + 4]
        a1, b1 = a1 - b1 * shift - p[-2] * shift**2 / 2, b1 + p[-2] * shift
        time = self.middle[flight] + (a1 - a0) / (b0 - b1)
        for _ in range(3 if self.drag else 0):
            gap = self.height(flight + 1, time, p) - self.height(flight, time, p)
            time -= gap / (self.speed(flight + 1, time, p) - self.speed(flight, time, p))
        return float(time)


def drag_shift(late: Any, gamma: float, drag: float) -> tuple[Any, Any]:
    """Height and speed that quadratic drag adds to a parabola, `late` after (before: negative) its apex.

    a = −k v |v| along v = −γ t, integrated twice with the undisturbed v:  ± k γ² t⁴/12 and k γ² |t|³/3.
    First order in k: good to 0.03 % of the speed for a soybean falling 310 mm, where drag takes 0.9 %.
    """
    return drag * gamma**2 * late**3 * np.abs(late) / 12, drag * gamma**2 * np.abs(late) ** 3 / 3


def fit_flights(
    time: np.ndarray, frame: np.ndarray, height: np.ndarray, across: np.ndarray, sd: np.ndarray, gravity: Gravity
) -> Flights:
    """Fit all flights of a track together. sd (n,) of each row, or NaN; across (n,) only tells stray rows.

    Raises MeasurementError when nothing flies.
    """
    step = float(np.median(np.diff(time) / np.diff(frame)))
    weight = _weights(sd)
    outlier = single_spikes(height)
    ranges = split(height)
    contacts = [time[stop - 1] for _, stop in ranges[:-1]]
    for turn in range(4):
        rows, guard = _usable(ranges, contacts, time, outlier, step)
        flights, residual = _fit_once(rows, time, frame, height, weight, gravity, outlier, guard, quick=turn < 3)
        contacts = flights.contacts()
        if turn == 3:
            if len(rows) == 1 and np.ptp(height[rows[0]]) < LEAST_FALL * np.ptp(height[~outlier]):
                raise MeasurementError("no fall can be told from how the seed was held: too much noise, or too few frames")
            return flights
        outlier = outlier | _spikes(rows, residual, time, height)
        for r in rows:
            outlier[r] |= off_curve(time[r], across[r])
        ranges = ranges[: free_flights(rows, time, height, residual, flights.meets(), step)]
    raise AssertionError


def _spikes(rows, residual: np.ndarray, time: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Rows far off their flight. Few rows fit too well to tell (half of the residuals near 0): then none. Where a smooth curve
    fits a flight as well as parabolas fit the lot, what lies on it is its way: air bends some by more than is assumed."""
    mask = np.zeros(len(time), dtype=bool)
    if len(residual) < 4 * (2 * len(rows) + 1):
        return mask
    limit = SPIKE_SD * robust_sd(residual) + 1e-12
    for r, off in zip(rows, np.split(residual, np.cumsum([len(r) for r in rows])[:-1])):
        odd = np.abs(off) > limit
        if not 0 < odd.sum() < 0.3 * len(r):  # more is not an outlier but a flight that is no parabola
            continue
        left = about_curve(time[r], height[r])
        on_curve = (np.abs(left) <= limit) & (robust_sd(left) < limit / 3)
        mask[r[odd & ~on_curve]] = True
    return mask


def _weights(sd: np.ndarray) -> np.ndarray:
    known = np.isfinite(sd) & (sd > 0)
    if known.sum() < len(sd):
        return np.ones(len(sd))
    return np.median(sd) / sd


def _usable(ranges, contacts, time, outlier, step) -> tuple[tuple[np.ndarray, ...], float]:
    """Rows of each flight, those near a contact left out: ±2 frames, fewer where a flight would have fewer than 4 rows."""
    rows, least = [], GUARDS[0]
    for k, (start, stop) in enumerate(ranges):
        low = contacts[k - 1] if k else -np.inf
        high = contacts[k] if k < len(contacts) else np.inf
        here = np.arange(max(start - 2, 0) if k else start, min(stop + 2, len(time)) if k < len(contacts) else stop)
        here = here[~outlier[here]]
        for guard in GUARDS if k < 2 else GUARDS[:2]:  # later bounces are worth having only where they are well seen
            kept = here[(time[here] > low + guard * step) & (time[here] < high - guard * step)]
            if len(kept) >= 4:
                break
        if len(kept) < (3, 2, 4)[min(k, 2)]:
            if k == 0 and len(ranges) > 1:
                raise MeasurementError(f"only {len(kept)} frames before the first contact; a speed needs 3")
            break
        rows.append(kept)
        least = min(least, guard)
    if not rows:
        raise MeasurementError("no flight of at least 3 frames")
    return tuple(rows), least


def _fit_once(rows, time, frame, height, weight, gravity: Gravity, outlier, guard, quick: bool):
    used = np.concatenate(rows)
    middle = np.array([time[r].mean() for r in rows])
    design = np.zeros((len(used), 2 * len(rows) + 2))
    at = 0
    for k, r in enumerate(rows):
        tau = time[r] - middle[k]
        block = slice(at, at + len(r))
        design[block, 2 * k], design[block, 2 * k + 1], design[block, -2] = 1.0, tau, -(tau**2) / 2
        at += len(r)
    lag = frame_lag(frame[used])
    target = height[used]
    solved = _solve(design, target, lag, weight[used], gravity, quick, len(rows))
    for _ in range(2 if gravity.drag else 0):
        params = solved[0].params
        late = np.concatenate([time[r] - middle[k] - params[2 * k + 1] / params[-2] for k, r in enumerate(rows)])
        shifted = target - drag_shift(late, params[-2], gravity.drag)[0]
        solved = _solve(design, shifted, lag, weight[used], gravity, quick, len(rows))
    found, free = solved
    return Flights(
        rows, time, middle, found.params, found.cov, found.noise, found.rho, float(free.params[-1]),
        float(np.sqrt(free.cov[-1, -1])), outlier, guard, gravity.drag,
    ), found.residuals * weight[used]  # fmt: skip


def _solve(design, target, lag, weight, gravity: Gravity, quick: bool, flights: int) -> tuple[Fit, Fit]:
    """The fit with what is known of gravity, and the one without."""
    bare = design[:, :-1]
    rho = 0.0 if quick else estimate_rho(bare * weight[:, None], target * weight, lag)
    free = fit(bare, target, lag, weight=weight, rho=rho)
    scale_row = np.zeros(design.shape[1])
    scale_row[-1] = 1.0
    rows, values, sds = [scale_row], [0.0], [max(gravity.scale_sd, 1e-9)]
    if gravity.value is not None:
        link = -scale_row.copy()
        link[-2] = 1 / gravity.value
        rows, values, sds = [*rows, link], [*values, 1.0], [*sds, max(gravity.other_sd, 1e-9)]
    prior = (np.array(rows), np.array(values), np.array(sds))
    return fit(design, target, lag, weight=weight, rho=rho, prior=prior), free


def lateral(
    flights: Flights, time: np.ndarray, frame: np.ndarray, across: np.ndarray, sd: np.ndarray, plumb_sd: float
) -> tuple[np.ndarray, np.ndarray]:
    """Straight lines c + u τ per flight, with one sideways acceleration that a plumb line off by `plumb_sd` (rad) would show.

    Returns params (c₀ u₀ c₁ u₁ … a) and their covariance.
    """
    used = np.concatenate(flights.rows)
    count = len(flights.rows)
    design = np.zeros((len(used), 2 * count + 1))
    at = 0
    for k, r in enumerate(flights.rows):
        tau = time[r] - flights.middle[k]
        block = slice(at, at + len(r))
        design[block, 2 * k], design[block, 2 * k + 1], design[block, -1] = 1.0, tau, tau**2 / 2
        at += len(r)
    row = np.zeros((1, 2 * count + 1))
    row[0, -1] = 1.0
    prior = (row, np.zeros(1), np.array([max(plumb_sd, 1e-6) * abs(flights.gamma)]))
    found = fit(design, across[used], frame_lag(frame[used]), weight=_weights(sd)[used], prior=prior)
    return found.params, found.cov
