"""Rolls of few rows, or that never leave their incline: accelerations of the legs that are seen → rolling friction.

    on the incline  a = g (sin β − μ_r cos β) / (1 + I/(m r²)),    on the level  b = −g μ_r / (1 + I/(m r²))

μ_r is torque over normal force times rolling radius, the force against the motion over that across the plate (Eq. 3 of the run-out has
the same; a coefficient as a length is it times the radius). Each leg is a parabola that is cut off where it comes to rest, at its
vertex: a seed that waits to be let go and one that has stopped are rows of the same three numbers. With both legs they share place, time
and speed at the corner, but for what the corner takes. Drag bends each parabola a little (`Air`).

Light gates know the place and read the time: a row's error is σ_t times the speed, and the gate's own. A stated sd is used, unless
the rows contradict it; otherwise the residuals give it, and with few rows Student's t makes the interval as wide as it must be.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import chi2 as chi_square
from scipy.stats import t as student

from vision.measurement import MeasurementError, Quantity, failed
from vision.motion.correlated import estimate_rho, frame_lag, propagate, whiten
from vision.motion.flight import G_MM_S2
from vision.motion.gravity import UNKNOWN_DRAG_PER_M, drag_per_metre
from vision.motion.rolling import inertia_in
from vision.motion.run_out import INCLINE_SD_DEG, LENGTH_SD_MM, RunOut, ends_on_incline, measure_run_out
from vision.motion.track import Track
from vision.recording import Recording

FEW_ROWS = 30  # of fewer, stop and corner are not told by the rows about them, but by the legs as wholes
LEAST_ROWS = 4
POINTS = 400  # of a curve in a picture
LEAST_WAY_MM = 1.0
SURELY_WRONG = 0.01  # of a χ² as great by chance, below which a stated sd is not that of the rows
DRAG_SD = 0.5  # relative: of a ball's drag beside a plate or rails, over that in free air
GUESSED_DENSITY = 1000.0  # kg/m³ of a seed whose mass is not stated, for how much drag may be
LEVEL = "say [roll] level = false where the seed stays on its incline"


@dataclass(frozen=True)
class Leg:
    """One leg's parabola about `at` [s]: place [mm], speed [mm/s], acceleration [mm/s²], drag over mass and inertia [1/mm]."""

    at: float
    place: float
    speed: float
    acceleration: float
    drag: float

    def rest(self) -> float:
        """When it is at rest [s]: before `at` where it speeds up, after where it slows down."""
        return self.at - self.speed / self.acceleration if self.acceleration else -math.inf

    def _tau(self, time: np.ndarray) -> np.ndarray:
        late = self.rest() - self.at
        return np.asarray(np.maximum(time - self.at, late) if self.acceleration >= 0 else np.minimum(time - self.at, late))

    def x(self, time: np.ndarray) -> np.ndarray:
        tau, v, a = self._tau(time), self.speed, self.acceleration
        return self.place + v * tau + a * tau**2 / 2 - self.drag * tau**2 * (v**2 / 2 + v * a * tau / 3 + a**2 * tau**2 / 12)

    def v(self, time: np.ndarray) -> np.ndarray:
        tau, v, a = self._tau(time), self.speed, self.acceleration
        return v + a * tau - self.drag * tau * (v**2 + v * a * tau + a**2 * tau**2 / 3)


@dataclass(frozen=True)
class Rows:
    """What is fitted: time [s], x [mm] along the motion, sd (n,) of x, NaN where not stated; gates: their times are read."""

    time: np.ndarray
    x: np.ndarray
    sd: np.ndarray
    lag: np.ndarray
    gates: bool


@dataclass(frozen=True)
class Known:
    """What the rows do not say: drag over mass and inertia [1/mm], the corner's place [mm], the share of the speed kept there,
    1 + I/(m r²), the incline [rad], scale (1: as stated)."""

    drag: float
    corner: float
    keep: float
    inertia: float
    incline: float
    scale: float = 1.0


Legs = Callable[[np.ndarray, Known], tuple[Leg, ...]]


@dataclass(frozen=True)
class Fitted:
    """params with cov (95 % is ± 1.96 √var), what speaks against a stated sd."""

    params: np.ndarray
    cov: np.ndarray
    strained: str


def measure_roll(track: Track, recording: Recording, *, junction: tuple[float, float] | None = None) -> RunOut:
    """What a roll says: of its incline only, of few rows on both legs, or, of a track from end to end, of its run-out."""
    used = track.used()
    stays = stays_on_incline(used, recording)
    few = junction is None and (recording.evidence == "gates.csv" or len(used) < FEW_ROWS)
    if not stays and not few:
        return measure_run_out(track, recording, junction=junction)
    try:
        rows, sign = rows_of(used, recording)
        return _of_incline(rows, sign, recording) if stays else _of_both(rows, sign, recording)
    except MeasurementError as error:
        first = ("acceleration", "m/s²") if stays else ("run_out", "mm")
        return RunOut((failed(*first, str(error)), failed("rolling_resistance", "1", str(error))))


def stays_on_incline(track: Track, recording: Recording) -> bool:
    """Whether a roll's rows are all on its incline: stated, or, where its length is, as the rows say."""
    if recording.roll.level is not None:
        return not recording.roll.level
    way = recording.roll.incline_length_mm
    if way is None or track.unit != "mm" or not track.timed or len(track) < LEAST_ROWS:
        return False
    if len(track) >= FEW_ROWS:
        return ends_on_incline(track.t_s, track.x, way)
    along = np.abs(track.x - track.x[0])
    return bool(along.max() <= way + LENGTH_SD_MM and np.polyfit(track.t_s - track.t_s[0], along, 2)[0] > 0)


def rows_of(track: Track, recording: Recording) -> tuple[Rows, float]:
    """Rows as they are fitted, and the sign of the motion; MeasurementError where they cannot be."""
    if track.unit != "mm" or not track.timed:
        missing = "mm_per_px" if track.unit != "mm" else "fps"
        raise MeasurementError(f"{recording.toml}: [camera] {missing} is missing; an acceleration needs lengths and times")
    if len(track) < LEAST_ROWS:
        raise MeasurementError(f"{len(track)} usable rows; place, speed and acceleration need at least {LEAST_ROWS}")
    sign = 1.0 if track.x[-1] >= track.x[0] else -1.0
    x, gates = sign * track.x, recording.evidence == "gates.csv"
    if np.ptp(x) < LEAST_WAY_MM:
        raise MeasurementError(f"the seed does not roll: it moves {np.ptp(x):.3g} mm in all")
    lag = np.full(len(x), np.inf) if len(x) < FEW_ROWS else frame_lag(track.frame)
    return Rows(track.t_s, x, track.sd, lag, gates), sign


def _of_incline(rows: Rows, sign: float, recording: Recording) -> RunOut:
    """acceleration and rolling_resistance of a seed that stays on its incline."""
    rows, notes = _before_the_end(rows)
    known, doubts, more = _known(rows, recording)
    going = int(np.argmax(rows.x > rows.x[0] + 0.02 * np.ptp(rows.x)))
    first = max(min(going - 1, len(rows.x) - LEAST_ROWS), 0)
    at = float((rows.time[first] + rows.time[-1]) / 2)
    start = np.polyfit(rows.time[first:] - at, rows.x[first:], 2)[::-1] * [1, 1, 2]

    def legs(p: np.ndarray, k: Known) -> tuple[Leg, ...]:
        return (Leg(at, p[0], p[1], p[2], k.drag),)

    def derived(p: np.ndarray, k: Known) -> np.ndarray:
        pull = p[2] * k.scale * k.inertia / G_MM_S2
        return np.array([p[2] * k.scale / 1000, math.tan(k.incline) - pull / math.cos(k.incline)])

    found = fit_legs(rows, legs, start, known)
    value, sd, common = _with_doubts(rows, legs, found, known, doubts, derived)
    if value[0] < -1.96 * sd[0]:
        raise MeasurementError("the seed slows down on its way; are its rows on an incline, and in the right order?")
    acceleration = _strained(Quantity("acceleration", value[0], sd[0], "m/s²", sd_common=common[0]), found)
    notes = [*notes, *more]
    drawn = _drawn(rows, legs(found.params, known), sign)
    if recording.roll.incline_deg is None:
        said = f"{recording.toml}: [roll] incline_deg is missing; without it an acceleration tells no rolling friction"
        return RunOut((acceleration, failed("rolling_resistance", "1", said)), fitted=drawn, notes=tuple(notes))
    friction = _strained(Quantity("rolling_resistance", value[1], sd[1], "1", sd_common=common[1]), found)
    if friction.value < -2 * friction.sd:
        friction = friction.doubt("negative: the seed rolls faster than without resistance; check incline_deg, scale and inertia_factor")
    return RunOut((acceleration, friction), fitted=drawn, notes=tuple(notes))


def _before_the_end(rows: Rows) -> tuple[Rows, list[str]]:
    """Rows until the seed meets the end of its incline, where it slows down at once."""
    speed = np.diff(rows.x) / np.diff(rows.time)
    top = int(np.argmax(speed))
    slow = np.flatnonzero(speed[top:] < 0.5 * speed[top])
    if rows.gates or not len(slow):
        return rows, []
    stop = max(top + int(slow[0]), LEAST_ROWS)
    text = f"the seed is stopped at {rows.time[stop - 1]:.4g} s; what follows is not fitted"
    return replace(rows, **{n: getattr(rows, n)[:stop] for n in ("time", "x", "sd", "lag")}), [text]


def _of_both(rows: Rows, sign: float, recording: Recording) -> RunOut:
    """run_out and rolling_resistance of few rows, some of them on the level."""
    known, doubts, notes = _known(rows, recording)
    if not math.isfinite(known.corner):
        said = "of few rows it says which are on the level"
        raise MeasurementError(f"{recording.toml}: [roll] incline_length_mm is missing; {said} ({LEVEL})")
    level = rows.x >= known.corner
    count = int(level.sum())
    if not count:
        length = recording.roll.incline_length_mm
        raise MeasurementError(f"no row lies behind the incline of {length:g} mm: there is no run-out ({LEVEL})")
    speed = np.gradient(rows.x, rows.time)
    if count == len(level):
        at = float(rows.time[0])
        slow = -(speed[0] ** 2) / 2 / max(np.ptp(rows.x), 1e-9)
        start, last = np.array([rows.x[0], speed[0], slow]), 0

        def legs(p: np.ndarray, k: Known) -> tuple[Leg, ...]:
            return (Leg(at, p[0], p[1], p[2], k.drag),)
    else:
        at = float(np.interp(known.corner, np.maximum.accumulate(rows.x), rows.time))
        fast = float(np.interp(at, rows.time, speed))
        start = np.array([at, fast, fast**2 / 2 / known.corner, -(fast**2) / 2 / max(rows.x[-1] - known.corner, 1.0)])
        last = 1

        def legs(p: np.ndarray, k: Known) -> tuple[Leg, ...]:
            return Leg(p[0], k.corner, p[1], p[2], k.drag), Leg(p[0], k.corner, p[1] * k.keep, p[3], k.drag)

    def derived(p: np.ndarray, k: Known) -> np.ndarray:
        leg = legs(p, k)[last]
        stop = float(leg.x(np.array([leg.rest()]))[0])
        return np.array([(stop - k.corner) * k.scale, -leg.acceleration * k.scale * k.inertia / G_MM_S2])

    found = fit_legs(rows, legs, start, known)
    if legs(found.params, known)[last].acceleration >= 0:
        raise MeasurementError("the seed does not slow down on the level: its rows say neither a run-out nor a friction")
    value, sd, common = _with_doubts(rows, legs, found, known, doubts, derived)
    run_out = _strained(Quantity("run_out", value[0], sd[0], "mm", sd_common=common[0]), found)
    ahead = value[0] / known.scale + known.corner - rows.x[-1]
    if ahead > 0.25 * value[0]:
        run_out = run_out.doubt(f"the stop is extrapolated by {ahead:.3g} mm beyond the last row")
    friction = _strained(Quantity("rolling_resistance", value[1], sd[1], "1", sd_common=common[1]), found)
    notes.append("few rows: the rolling friction is that of slowing down on the level, the run-out where that ends")
    drawn = _drawn(rows, legs(found.params, known), sign)
    return RunOut((run_out, friction), sign * known.corner, sign * (known.corner + value[0]), float(rows.time[-1]), drawn, tuple(notes))


def _drawn(rows: Rows, legs: tuple[Leg, ...], sign: float) -> tuple[np.ndarray, np.ndarray]:
    """The curve for a picture: times, places."""
    time = np.linspace(rows.time[0], rows.time[-1], POINTS)
    return time, sign * travel(legs, time)[0]


def _known(rows: Rows, recording: Recording) -> tuple[Known, dict[str, float], list[str]]:
    """What is known beside the rows, its sds, and what is to be said of it."""
    roll, inertia, notes = recording.roll, inertia_in(recording), []
    beta = math.nan if roll.incline_deg is None else math.radians(roll.incline_deg)
    speed = float(np.ptp(rows.x) / np.ptp(rows.time)) / 1000
    drag = drag_per_metre(recording, speed)
    drag_sd = None if drag is None else DRAG_SD * drag
    if drag is None:
        dense = recording.seed.model_copy(update={"density_kg_m3": GUESSED_DENSITY})
        drag, drag_sd = 0.0, drag_per_metre(replace(recording, seed=dense), speed) or UNKNOWN_DRAG_PER_M
        if drag_sd * 1000 * speed**2 > 3e-3 * 9806.65:
            notes.append("air drag is not allowed for: [seed] sizes and mass_g or density_kg_m3 are unknown; the sd holds what it may be")
    waits = abs(rows.x[1] - rows.x[0]) < 0.01 * np.ptp(rows.x) and not rows.gates
    corner = math.nan if roll.incline_length_mm is None else roll.incline_length_mm + (rows.x[0] if waits else 0.0)
    lost = 0.0 if math.isnan(beta) else (1 - math.cos(beta)) / inertia.factor
    known = Known(drag / 1000 / inertia.factor, corner, 1 - lost / 2, inertia.factor, beta)
    scale_sd = 0.0 if recording.evidence == "gates.csv" else recording.camera.scale_sd
    doubts = {
        "drag": (drag_sd or 0.0) / 1000 / inertia.factor, "corner": LENGTH_SD_MM, "keep": lost / math.sqrt(12),
        "inertia": inertia.factor * inertia.sd, "incline": math.radians(INCLINE_SD_DEG), "scale": scale_sd,
    }  # fmt: skip
    on = f"on rails {roll.rail_gap_mm:g} mm apart" if roll.rail_gap_mm else "on a plate"
    notes.append(f"1 + I/(m r²) is taken as {inertia.factor:.4g} ± {inertia.factor * inertia.sd:.2g}, {on}")
    return known, doubts, notes


def fit_legs(rows: Rows, legs: Legs, start: np.ndarray, known: Known) -> Fitted:
    """Least squares over the legs' numbers; MeasurementError where there are not more rows than unknowns."""
    n, freedom = len(rows.x), len(rows.x) - len(start)
    if freedom < 1:
        raise MeasurementError(f"{n} usable rows for {len(start)} unknowns: one more is needed")
    stated = bool(np.isfinite(rows.sd).all() and (rows.sd > 0).all())
    unit, rho = np.maximum(np.abs(start), 1e-3 * np.ptp(rows.x)), 0.0

    def curve(p: np.ndarray) -> np.ndarray:
        return travel(legs(p, known), rows.time)[0]

    for turn in range(3):  # the later ones with the speeds and the noise that the one before found
        weight = np.ones(n)
        if rows.gates and not stated:
            speed = np.abs(travel(legs(start, known), rows.time)[1])
            weight = 1 / np.maximum(speed, 0.05 * speed.max())
        weight = weight / rows.sd if stated else weight / np.median(weight)

        def misfit(u: np.ndarray, weight: np.ndarray = weight, rho: float = rho) -> np.ndarray:
            return whiten((rows.x - curve(u * unit)) * weight, rows.lag, rho)

        found = least_squares(misfit, start / unit, method="lm", xtol=1e-13, ftol=1e-13)
        start = found.x * unit
        if turn == 0 and n >= FEW_ROWS:
            plain = least_squares(lambda u, w=weight: (rows.x - curve(u * unit)) * w, found.x, method="lm", max_nfev=1)
            rho = estimate_rho(plain.jac, plain.fun, rows.lag)
    chi2 = max(float(found.fun @ found.fun), freedom * (1e-9 * np.abs(rows.x).max() * float(np.median(weight))) ** 2)
    power, strained = chi2 / freedom * (student.ppf(0.975, freedom) / 1.96) ** 2, ""
    if stated and chi_square.sf(chi2, freedom) < SURELY_WRONG:
        strained = f"the rows scatter {math.sqrt(chi2 / freedom):.2g} times as much as their stated sd"
    elif stated:
        power = 1.0
    return Fitted(start, power * np.linalg.pinv(found.jac.T @ found.jac) * np.outer(unit, unit), strained)


def travel(legs: tuple[Leg, ...], time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Place [mm] and speed [mm/s] (n,); of two legs the second begins at its `at`."""
    if len(legs) == 1:
        return legs[0].x(time), legs[0].v(time)
    late = time > legs[1].at
    return np.where(late, legs[1].x(time), legs[0].x(time)), np.where(late, legs[1].v(time), legs[0].v(time))


def _with_doubts(rows: Rows, legs: Legs, found: Fitted, known: Known, doubts: dict[str, float], derived: Callable) -> tuple:
    """Values that `derived` makes of parameters and what is known, their sds, by the rows and by each doubt, fitted anew, and what all
    rolls of a session share of them: all but where the seed was laid."""
    value, own = propagate(lambda p: derived(p, known), found.params, found.cov)
    power, shared = np.diag(own).copy(), np.zeros(len(value))
    for name, sd in doubts.items():
        if sd and math.isfinite(getattr(known, name)):
            other = replace(known, **{name: getattr(known, name) + sd})
            again = fit_legs(rows, legs, found.params, other).params if name in ("drag", "corner", "keep") else found.params
            moved = np.nan_to_num(derived(again, other) - value) ** 2
            power += moved
            shared += moved * (name != "corner")
    return value, np.sqrt(power), np.sqrt(shared)


def _strained(quantity: Quantity, found: Fitted) -> Quantity:
    return quantity.doubt(found.strained) if found.strained else quantity
