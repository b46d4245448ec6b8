"""Free flights between contacts: one parabola a flight, one gravity for all, impacts where successive parabolas meet.

    h(t) = a + b τ − γ τ²/2 + δ(t),    τ = t − middle of the flight

γ is gravity in the track's own units, δ what air drag does to a parabola (`drag_shift`; nil when the air is left out).
Where scale and frame rate are stated γ is g (1 + η)(1 + ε): ε the scale's stated error, η what else bends a parabola.
Both float within their sd, so that a parabola's own curvature refines the scale and never fights it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter
from scipy.signal import find_peaks

from vision.measurement import MeasurementError
from vision.motion.correlated import Fit, estimate_rho, fit, frame_lag

G_MM_S2 = 9806.65
GUARDS = (2.0, 1.0, 0.5)  # frames left out on either side of a contact; fewer only where a flight has hardly any
LOW_SD = 8.0  # sds of the noise by which a lowest point stands out: noise that is slow wanders over ± 3 of its own
PLATE_SHARE = 0.15  # of the track's height: contacts lie no farther from its lowest place, however the seed lies there
LEAST_FALL = 0.3  # of all that is seen: a flight without a contact that goes less far was none
FREE_SHARE, FREE_SD = 0.3, 5.0  # of its fall, and in its sds: by how much a flight may differ from the first; air does less
SPIKE_SD = 6.0  # a row this many robust sds off its flight is an outlier: 2e-9 by chance, so none among 5,000 true rows


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


def split(time: np.ndarray, height: np.ndarray) -> list[tuple[int, int]]:
    """Row ranges [start, stop) of the flights: between lowest points that stand out, without the rests at both ends."""
    smooth = _despiked(height)
    reach = float(np.ptp(smooth))
    if reach <= 0:
        raise MeasurementError("nothing falls: the height never changes")
    # At a phone's frame rate a stretch holds contacts, which are no noise: hence no more than 3 % of the fall.
    lows = _lows(smooth, max(0.002 * reach, min(LOW_SD * _scatter(smooth), 0.03 * reach)))
    # The first flight starts where the seed has left its rest: 1 % of the fall below the highest place.
    first_low = lows[0] if lows else int(np.argmin(smooth))
    before = smooth[: first_low + 1]
    fall = before.max() - before[-1]
    still = np.flatnonzero(before > before.max() - 0.01 * fall)
    start = 0 if fall < 0.02 * reach else min(int(still[-1]) + 1, max(first_low - 3, 0))
    ends = [start, *[low for low in lows if low > start]]
    ranges = list(zip(ends[:-1], [e + 1 for e in ends[1:]]))
    return [*ranges, (ends[-1], _end_of_last(smooth, ends[-1], bool(lows)))]


def _lows(height: np.ndarray, least: float) -> list[int]:
    """Lowest rows where a median over a hundredth of the track, which few stray rows cannot lower, has a low `least` deep."""
    width = min(len(height) // 100, 15) | 1
    near = find_peaks(-median_filter(height, width, mode="nearest"), prominence=least)[0]
    spans = [range(max(low - width // 2, 0), min(low + width // 2 + 1, len(height))) for low in near]
    return [min(span, key=height.__getitem__) for span in spans]


def _scatter(height: np.ndarray) -> float:
    """sd of the rows about parabolas through short stretches, of the quietest sixth: many hold a contact. Slow noise is in it."""
    size = max(9, len(height) // 32)
    if len(height) < size:
        return 0.0
    stretches = height[: len(height) // size * size].reshape(-1, size)
    basis = np.linalg.qr(np.vander(np.linspace(-1, 1, size), 3))[0]
    left = stretches - stretches @ basis @ basis.T
    return float(np.sqrt(np.quantile((left**2).sum(1) / (size - 3), 0.15)))


def _end_of_last(height: np.ndarray, start: int, after_contact: bool) -> int:
    """Where the last flight ends: back at the level it left from, at rest, or with the track."""
    tail = height[start:]
    if not after_contact:
        return start + int(np.argmin(tail > tail.min() + 0.005 * np.ptp(tail))) + 1 if np.ptp(tail) > 0 else len(height)
    apex = int(np.argmax(tail))
    level = tail[0] + 0.05 * (tail[apex] - tail[0])
    low = np.flatnonzero(tail[apex:] < level)
    return start + apex + int(low[0]) + 1 if len(low) else len(height)


def _off_neighbours(height: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Running median, how far each row is off it and may be: two of the seed's greatest steps nearby, or ten noises."""
    middle = median_filter(height, 7, mode="nearest")
    off = np.abs(height - middle)
    steps = np.abs(np.diff(median_filter(height, 3, mode="nearest"), append=height[-1:]))  # single rows off are not in it
    return middle, off, np.maximum(10 * float(np.median(off)), 2.0 * maximum_filter1d(steps, 9, mode="nearest"))


def _despiked(height: np.ndarray) -> np.ndarray:
    """Single rows far off their neighbours replaced, so that a spike is not taken for a contact."""
    if len(height) < 15:
        return height
    middle, off, limit = _off_neighbours(height)
    return np.where(off > limit, middle, height)


def _single_spikes(height: np.ndarray) -> np.ndarray:
    """Rows that stand out from both neighbours further than a bouncing seed can: outliers before anything is fitted."""
    spikes = np.zeros(len(height), dtype=bool)
    if len(height) < 15:
        return spikes
    _, off, limit = _off_neighbours(height)
    before, after = height[1:-1] - height[:-2], height[1:-1] - height[2:]
    spikes[1:-1] = (off[1:-1] > limit[1:-1]) & (before * after > 0) & (np.minimum(np.abs(before), np.abs(after)) > limit[1:-1])
    return spikes


def fit_flights(time: np.ndarray, frame: np.ndarray, height: np.ndarray, sd: np.ndarray, gravity: Gravity) -> Flights:
    """Fit all flights of a track together. sd (n,) of each row, or NaN. Raises MeasurementError when nothing flies."""
    step = float(np.median(np.diff(time) / np.diff(frame)))
    weight = _weights(sd)
    outlier = _single_spikes(height)
    ranges = split(time, height)
    contacts = [time[stop - 1] for _, stop in ranges[:-1]]
    for turn in range(4):
        rows, guard = _usable(ranges, contacts, time, outlier, step)
        flights, residual = _fit_once(rows, time, frame, height, weight, gravity, outlier, guard, quick=turn < 3)
        contacts = flights.contacts()
        if turn == 3:
            if len(rows) == 1 and np.ptp(height[rows[0]]) < LEAST_FALL * np.ptp(height[~outlier]):
                raise MeasurementError("no fall can be told from how the seed was held: too much noise, or too few frames")
            return flights
        outlier = outlier | _spikes(rows, residual, len(time))
        ranges = ranges[: min(_sound(rows, residual), _falling(rows, time, height), _on_plate(flights, height, step))]
    raise AssertionError


def _spikes(rows, residual: np.ndarray, count: int) -> np.ndarray:
    """Rows far off their flight. Few rows fit too well to tell (half of the residuals near 0): then none."""
    mask = np.zeros(count, dtype=bool)
    if len(residual) < 4 * (2 * len(rows) + 1):
        return mask
    limit = SPIKE_SD * 1.4826 * np.median(np.abs(residual)) + 1e-12
    for r, off in zip(rows, np.split(residual, np.cumsum([len(r) for r in rows])[:-1])):
        odd = np.abs(off) > limit
        if odd.sum() < 0.3 * len(r):  # more is not an outlier but a flight that is no parabola
            mask[r[odd]] = True
    return mask


def _sound(rows, residual: np.ndarray) -> int:
    """How many flights to keep: up to the first (after two) that scatters 6 × more than the first two do, so no parabola."""
    parts = np.split(residual, np.cumsum([len(r) for r in rows])[:-1])
    scatter = [float(np.sqrt(np.median(p**2))) for p in parts]
    usual = max(scatter[:2])
    return next((k for k in range(2, len(rows)) if scatter[k] > 6 * usual), len(rows))


def _falling(rows, time: np.ndarray, height: np.ndarray) -> int:
    """How many flights to keep: up to the first (after two) that does not fall as the first two do. A seed that rocks or rolls to
    rest has lowest points too."""
    gammas, sds = np.array([_fall(time[r], height[r]) for r in rows]).T
    weight = 1 / np.maximum(sds[:2], 1e-12) ** 2
    if not weight.any():
        return len(rows)
    usual = float((weight * gammas[:2]).sum() / weight.sum())
    off = np.abs(gammas - usual) > FREE_SHARE * abs(usual) + FREE_SD * sds
    return next((k for k in range(2, len(rows)) if off[k]), len(rows))


def _on_plate(flights: Flights, height: np.ndarray, step: float) -> int:
    """How many flights to keep: up to the first contact that is not at the plate. Where a seed left the picture and came back
    there were more contacts than one."""
    plate, reach = np.quantile(height, 0.01), np.ptp(height)
    for k in range(len(flights.rows) - 1):
        t = flights.meeting(k)
        if abs(flights.height(k, t) - plate) > PLATE_SHARE * reach + step * abs(flights.speed(k, t)):
            return k + 1
    return len(flights.rows)


def _fall(time: np.ndarray, height: np.ndarray) -> tuple[float, float]:
    """γ of one flight by itself and its sd, successive rows erring together; of fewer than 6 rows nothing is known."""
    if len(time) < 6:
        return 0.0, np.inf
    tau = (time - time.mean()) / np.ptp(time)
    design = np.column_stack([np.ones_like(tau), tau, -(tau**2) / 2])
    params = np.linalg.lstsq(design, height, rcond=None)[0]
    left = height - design @ params
    power = float((left**2).sum()) / (len(tau) - 3)
    rho = float(np.clip((left[1:] * left[:-1]).sum() / max((left**2).sum(), 1e-300), 0.0, 0.99))
    sd = np.sqrt(power * (1 + rho) / (1 - rho) * np.linalg.inv(design.T @ design)[2, 2])
    return float(params[2] / np.ptp(time) ** 2), float(sd / np.ptp(time) ** 2)


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
