"""Which rows of a track belong to which free flight of a drop, and where successive
flights meet.

    h(t) = a + b τ − γ τ²/2,    τ = t − middle of the flight

A parabola for each flight and one γ for all, by least squares, tell the flights apart;
what is measured on them is fitted by the rig's model."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.bench.robust import robust_sd
from benchtwin.vision.measurement import MeasurementError, require
from benchtwin.vision.motion.least_squares import all_stated
from benchtwin.vision.motion.outliers import (
    SPIKE_SD,
    STILL,
    curve_residuals,
    off_curve,
    rows_at_rest,
    single_spikes,
)
from benchtwin.vision.motion.split_flights import (
    free_flights,
    splits,
)

# with fewer rows none are left out about a contact, and outliers are not detected
FEW_ROWS = 16
# of its extent, by which rows scatter about a parabola that a contact broke
NO_PARABOLA = 0.05
# frames left out on either side of a contact; fewer only where a flight has hardly any
GUARDS = (2.0, 1.0, 0.5)
# of the time between two rows, by which noise may move the impact out of that interval
SLACK = 0.05
# relative, and in sds: by how much the acceleration of a flight alone may differ from
# gravity
FREE_SHARE, FREE_SD = 0.3, 5.0
# rows of a fall that are kept, wherever it begins; how many beginnings are tried
LEAST_FALL, MOST_TRIED = 6, 50
ODDS = 3.0  # ln, by which a later beginning must tell more
NO_FALL = (
    "no fall can be distinguished from how the seed was held: too much noise, or too"
    " few frames"
)


@dataclass(frozen=True)
class Flights:
    """F flights. rows: those used of each; middle (F,): times from which τ counts;
    params: a₀ b₀ a₁ b₁ … γ (2F + 1); free_sd: of γ, NaN where it was given; weight
    (n,): of all rows, 1 over their relative sd; outlier (n,); unused: whether lowest
    points before the first flight are no contacts (a hand, a slip of the tracker)."""

    rows: tuple[np.ndarray, ...]
    time: np.ndarray  # (n,) of all rows
    middle: np.ndarray
    params: np.ndarray
    free_sd: float
    noise: float
    weight: np.ndarray
    outlier: np.ndarray
    unused: bool = False

    @property
    def free(self) -> float:
        """γ, the acceleration of the falls."""
        return float(self.params[-1])

    @property
    def few(self) -> bool:
        """Whether the track has few rows: none is left out about the contacts."""
        return len(self.time) < FEW_ROWS

    def apex_time(self, flight: int) -> float:
        return float(self.middle[flight] + self.params[2 * flight + 1] / self.free)

    def height(self, flight: int, time: Any) -> Any:
        """Height at `time`, a number or an array."""
        tau, (a, b) = time - self.middle[flight], self.params[2 * flight :][:2]
        return a + b * tau - self.free * tau**2 / 2

    def speed(self, flight: int, time: Any) -> Any:
        """dh/dt, upwards, at `time`, a number or an array."""
        return self.params[2 * flight + 1] - self.free * (time - self.middle[flight])

    def contacts(self) -> list[float]:
        """Times of the impacts."""
        return [self.contact_time(k) for k in range(len(self.rows) - 1)]

    def ends(self) -> list[float]:
        """Those, and that of the landing that ends the last flight (by symmetry about
        its apex); empty without impacts."""
        times, last = self.contacts(), len(self.rows) - 1
        return [*times, 2 * self.apex_time(last) - times[-1]] if times else []

    def contact_states(self) -> list[tuple[float, float]]:
        """Height and speed at each impact."""
        return [
            (float(self.height(k, t)), float(self.speed(k, t)))
            for k, t in enumerate(self.contacts())
        ]

    def contact_time(self, flight: int) -> float:
        """Time at which a flight and the next one meet, linear as both have one γ."""
        shift = self.middle[flight + 1] - self.middle[flight]
        a0, b0, a1, b1 = self.params[2 * flight : 2 * flight + 4]
        a1, b1 = a1 - b1 * shift - self.free * shift**2 / 2, b1 + self.free * shift
        return float(self.middle[flight] + (a1 - a0) / (b0 - b1))

    def release_seen(self) -> bool:
        """Whether the release, the first flight's apex, is in the track."""
        apex, begin = self.apex_time(0), self.time[0]
        fall = self.time[self.rows[0][-1]] - apex
        step = float(np.median(np.diff(self.time)))
        return apex >= begin - max(0.03 * fall, 1.5 * step)


def find_flights(
    time: np.ndarray,
    frame: np.ndarray,
    height: np.ndarray,
    across: np.ndarray,
    sd: np.ndarray,
    gamma: float | None = None,
) -> Flights:
    """The flights of a track; sd (n,): of each row, or NaN; across (n,): used to find
    outliers only; gamma: gravity in its units, used where rows are few.

    Of the moments at which the seed may have been let go, that is taken whose flights
    tell most of the whole track."""
    step = float(np.median(np.diff(time) / np.diff(frame)))
    weight = np.median(sd) / sd if all_stated(sd) else np.ones(len(sd))
    tried: list[_Tried] = []
    errors: list[MeasurementError] = []
    for begin, ranges in enumerate(splits(height)):
        most = max((len(t.residual) for t in tried), default=0)
        if ranges[-1][1] - ranges[0][0] < most:
            continue  # fewer rows than are explained already
        try:
            free = _free(ranges, time, height, across, weight, step, gamma)
        except MeasurementError as error:
            errors.append(error)
            continue
        if free.flights.free > 0:
            tried.append(replace(free, begin=begin))
    if not tried:
        raise errors[0] if errors else MeasurementError(tr(NO_FALL))
    best = max(tried, key=lambda t: t.explained(height))
    require(len(best.flights.rows) != 1 or best.explained(height) > 0, tr(NO_FALL))
    rows = _usable(best.ranges, best.flights.ends(), time, best.outlier, step)
    flights, _ = parabolas(rows, time, height, weight, _if_few(rows, gamma))
    off = np.abs(height - flights.height(0, time))[best.led : best.ranges[0][0]]
    led = off.size > 0 and float(np.median(off)) > SPIKE_SD * flights.noise
    return replace(flights, outlier=best.outlier, unused=bool(best.begin) or led)


@dataclass(frozen=True, eq=False)
class _Tried:
    """The free flights if the seed was let go behind a lowest point, number `begin`;
    it leaves its highest place at row `led`, led by a hand until the flights begin."""

    flights: Flights
    residual: np.ndarray
    ranges: list[tuple[int, int]]
    outlier: np.ndarray
    led: int
    begin: int = 0

    def explained(self, height: np.ndarray) -> float:
        """ln of how much better the flights (a place and a speed each, and gravity)
        tell their rows than a seed that is held, or lies, does."""
        rows, reach = self.flights.rows, float(np.ptp(height))
        still = (_explained(height[r] - np.median(height[r]), 1, reach) for r in rows)
        flown = _explained(self.residual, 2 * len(rows) + 1, reach)
        return flown - sum(max(one, 0.0) for one in still)


def _free(ranges, time, height, across, weight, step, gamma) -> _Tried:
    """The free flights among these ranges, outliers told apart."""
    outlier = single_spikes(height)
    contact_times = [time[stop - 1] for _, stop in ranges[:-1]]
    rows = _usable(ranges, contact_times, time, outlier, step)
    (led, end), *later = ranges
    ranges = [(_let_go(rows[:2], time, height, weight, gamma), end), *later]
    for _ in range(3):
        rows = _usable(ranges, contact_times, time, outlier, step)
        known = _if_few(rows[:2], gamma)
        if len(rows) > 2:  # of which the later ones need not be flights
            known = parabolas(rows[:2], time, height, weight, known)[0].free
        flights, residual = parabolas(rows, time, height, weight, known)
        contact_times = flights.ends()
        outlier = outlier | _spikes(rows, residual, time, height)
        for r in rows:
            outlier[r] |= off_curve(time[r], across[r])
        ranges = ranges[
            : free_flights(rows, height, residual, flights.contact_states(), step)
        ]
    return _Tried(flights, residual, ranges, outlier, led)


def _let_go(rows, time, height, weight, gamma) -> int:
    """Row from which the fall is free: the first from which fall and rebound tell the
    places about as well as they can, so that those of a hand's way are left out."""
    first, *later = rows
    most = len(first) - LEAST_FALL
    tried = np.unique(np.linspace(0, max(most, 0), MOST_TRIED).astype(int))
    reach, told = float(np.ptp(height)), []
    for k in tried:
        cut = (first[k:], *later)
        flights, residual = parabolas(cut, time, height, weight, _if_few(cut, gamma))
        residual = _without_drag(flights, residual)
        told.append(_explained(residual, 2 * len(cut) + 2, reach))
    return int(first[tried[np.argmax(np.array(told) > max(told) - ODDS)]])


def _without_drag(flights: Flights, residual: np.ndarray) -> np.ndarray:
    """The residuals less what drag as v² takes, of whatever size it fits best: of u
    since the apex, u³|u| times a number above 0, common to the flights."""
    bend = np.zeros(len(flights.time))
    for k, rows in enumerate(flights.rows):
        since = flights.time[rows] - flights.apex_time(k)
        bend[rows] = since**3 * np.abs(since)
    _, own = parabolas(flights.rows, flights.time, bend, flights.weight)
    share = float(residual @ own) / max(float(own @ own), 1e-300)
    return residual - max(share, 0.0) * own


def _if_few(rows: Sequence[np.ndarray], gamma: float | None) -> float | None:
    """Gravity where there are less than two rows an unknown."""
    return gamma if sum(map(len, rows)) < 2 * (2 * len(rows) + 1) else None


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


def _usable(ranges, contact_times, time, outlier, step) -> tuple[np.ndarray, ...]:
    """Rows of each flight without those within 2 frames of a contact, or fewer where a
    flight would have less than 4 rows."""
    rows = []
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
        if len(kept) < (2, 2, 4)[min(k, 2)]:
            require(
                k != 0 or len(ranges) <= 1,
                tr(
                    "only {} frames before the first contact; a speed needs 2",
                    len(kept),
                ),
            )
            break
        rows.append(kept)
    require(rows, tr("no flight of at least 3 frames"))
    return tuple(rows)


def parabolas(
    rows: Sequence[np.ndarray],
    time: np.ndarray,
    height: np.ndarray,
    weight: np.ndarray,
    gamma: float | None = None,
) -> tuple[Flights, np.ndarray]:
    """Flights fitted to their rows, and the weighted residuals; gamma: γ where it is
    known."""
    used, count = np.concatenate(rows), len(rows)
    middle = np.array([time[r].mean() for r in rows])
    which = np.repeat(np.arange(count), [len(r) for r in rows])
    tau, w = time[used] - middle[which], weight[used]
    design = np.zeros((len(used), 2 * count + 1))
    each = np.arange(len(used))
    design[each, 2 * which], design[each, 2 * which + 1] = 1.0, tau
    design[:, -1] = -(tau**2) / 2
    target, fitted = height[used], design
    if gamma is not None:
        target, fitted = target - gamma * design[:, -1], design[:, :-1]
    params = np.linalg.lstsq(fitted * w[:, None], target * w, rcond=None)[0]
    left = (target - fitted @ params) * w
    freedom = max(len(used) - len(params), 1)
    noise, free_sd = math.sqrt(float(left @ left) / freedom), math.nan
    if gamma is None:
        inverse = np.linalg.pinv(fitted.T * w**2 @ fitted, hermitian=True)
        free_sd = noise * math.sqrt(max(float(inverse[-1, -1]), 0.0))
    else:
        params = np.append(params, gamma)
    none = np.zeros(len(time), dtype=bool)
    found = Flights(tuple(rows), time, middle, params, free_sd, noise, weight, none)
    return found, left


def find_few_flights(
    time: np.ndarray,
    height: np.ndarray,
    sd: np.ndarray,
    gamma: float | None,
    *,
    gates: bool,
) -> Flights:
    """Fall and first rebound, or one flight without an impact, in a track of few rows
    (light gates, a stroboscope, some pictures); sd (n,): of each height, or NaN; gamma:
    gravity in its units where that is known: then five rows are enough, or four with
    stated sds.

    The impact lies between two neighbouring rows; all pairs are tried. Light gates know
    the height and measure the time: a row's error is σ_t times the speed."""
    stated = all_stated(sd)
    unknowns = 4 + (gamma is None)
    least = unknowns + (not stated)
    begin = rows_at_rest(height)
    if len(time) - begin < least:
        gravity_too = tr("gravity, ") if gamma is None else ""
        message = tr(
            "{} rows of fall and rebound for {} unknowns ({}two places and two speeds)",
            len(time) - begin,
            unknowns,
            gravity_too,
        )
        raise MeasurementError(
            tr("{}; {} are needed", message, least)
            + ("" if stated else tr(", or {} with their sd stated", least - 1))
        )
    weight = np.median(sd) / sd if stated else np.ones(len(time))
    by_speed = gates and not stated
    tried = [
        _impact_after(time, height, weight, gamma, begin, j, least, by_speed)
        for j in range(begin + 1, len(time) - 2)
    ]
    found = [flights for flights in tried if flights is not None]
    if not found:
        alone = _one_flight(time, height, weight, gamma, begin)
        if alone is None:
            raise MeasurementError(
                tr(
                    "no impact lies between two of the rows, and they are no flight by"
                    " themselves: a fall and a rebound need two rows each"
                )
            )
        return alone
    share = [1.0 if stated else len(time) / len(np.concatenate(f.rows)) for f in found]
    return found[int(np.argmin([f.noise * s for f, s in zip(found, share)]))]


def _one_flight(time, height, weight, gamma, begin: int) -> Flights | None:
    """All rows as one flight; None where they do not fall as freely as flights do."""
    rows = (np.arange(begin, len(time)),)
    alone, _ = parabolas(rows, time, height, weight)
    doubt = FREE_SD * alone.free_sd
    if alone.free < doubt or alone.noise > NO_PARABOLA * np.ptp(height[begin:]):
        return None
    known = alone.free if gamma is None else gamma
    return alone if abs(alone.free - known) <= max(FREE_SHARE * known, doubt) else None


def _impact_after(
    time, height, weight, gamma, begin: int, j: int, least: int, by_speed: bool
) -> Flights | None:
    """Both flights, fitted with the impact between rows j and j + 1; None where the fit
    puts it elsewhere."""
    slack = SLACK * (time[j + 1] - time[j])
    for end in range(max(j + 3, begin + least), len(time) + 1):
        rows = (np.arange(begin, j + 1), np.arange(j + 1, end))
        flights, _ = parabolas(rows, time, height, weight, gamma)
        for _ in range(2 * by_speed):
            speed = [np.abs(flights.speed(k, time[r])) for k, r in enumerate(rows)]
            slow = np.maximum(fast := np.concatenate(speed), 0.1 * fast.max())
            own = weight.copy()
            own[begin:end] = np.median(slow) / slow
            flights, _ = parabolas(rows, time, height, own, gamma)
        if not flights.free > 0:
            return None
        meets, landing = flights.ends()
        (low, falls), rises = flights.contact_states()[0], flights.speed(1, meets)
        inside = time[j] - slack <= meets <= time[j + 1] + slack
        if not inside or falls >= 0 or rises <= 0 or time[end - 1] > landing:
            return None
        if end < len(time) and time[end] < landing:
            continue
        near = max(3 * flights.noise, STILL * np.ptp(height))
        top = flights.height(1, flights.apex_time(1))
        later = height[end:].max(initial=-math.inf)
        # some row is lower than the plate, or a later bounce would be higher
        wrong = low > height.min() + near or later > top + near
        return None if wrong else flights
    return None
