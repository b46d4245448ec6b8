"""Slide rig: travel along a tilting plate → slide angle, static and kinetic friction.

Before the onset the block rests; after it

    ẍ = g sin θ(t) − μ_k (g cos θ(t) − 2 θ̇ ẋ),    θ(t) the plate's own motion

(2 θ̇ ẋ: Coriolis; the plate turns away from under the moving block, which presses on it
less) so x(t) = x₀ + A(t; t₀) − μ_k [B(t; t₀) − C(t; t₀)], with A, B the double
integrals of g sin θ and g cos θ from the onset t₀ and C the integral of 2 θ̇ (x − x₀)
over the measured x. For a given t₀ that is linear in x₀ and μ_k; t₀ is fitted, not
found by a threshold. μ_s = tan θ(t₀)."""

import math
from dataclasses import dataclass

import numpy as np
from benchtwin.bench.constants import G_MM_S2
from benchtwin.bench.resolution import reading_step
from benchtwin.bench.robust import difference_noise
from benchtwin.vision.measurement import MeasurementError, Quantity, all_failed, failed
from benchtwin.vision.motion.least_squares import estimate_rho, fit, frame_lag, whiten
from benchtwin.vision.motion.outliers import single_spikes
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording
from scipy.optimize import minimize_scalar
from scipy.signal import savgol_filter

TILT_SD_DEG = 0.05  # of a goniometer or inclinometer, common to a whole session
START_SD_DEG = (
    0.5  # of a stated angle at t = 0: a film may begin somewhat before the tilting
)
RATE_SD = 0.01  # relative, of a stated rate
ANGLE_MISSING = (
    "the plate's angle is unknown: give a tilt_deg column in track.csv, or [slide]"
    " start_deg and tilt_rate_deg_s"
)
START_MISSING = (
    "[slide] start_deg is missing: the plate's angle [deg] at t = 0, 0 where it began"
    " level; the rate alone does not tell at which angle the block let go (a tilt_deg"
    " column in track.csv does as well)"
)
QUANTITIES = (
    ("slide_angle", "deg"),
    ("static_friction", "1"),
    ("kinetic_friction", "1"),
)


@dataclass(frozen=True)
class Slide:
    """Quantities; onset [time unit]; fitted: (time, x) for the plot; notes."""

    quantities: tuple[Quantity, ...]
    onset: float | None
    fitted: tuple[np.ndarray, np.ndarray] | None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Tilt:
    """The plate's angle [rad] and its rate at each row, and integrals of g sin θ and g
    cos θ from the first row. sd [deg]: error that all rows and all recordings of a
    session share; pictured: the angle is from the plate's edge in the picture."""

    angle: np.ndarray
    rate: np.ndarray
    sin1: np.ndarray
    sin2: np.ndarray
    cos1: np.ndarray
    cos2: np.ndarray
    sd: float
    pictured: bool


def measure_slide_track(track: Track, recording: Recording) -> Slide:
    """Quantities slide_angle, static_friction, kinetic_friction; failed, with the
    reason, where the block does not slide."""
    used = track.used()
    used = used.marked(single_spikes(used.x)).used()
    try:
        tilt, notes = _tilt(used, recording)
        return _measure(used, tilt, recording, notes)
    except MeasurementError as error:
        return Slide(all_failed(QUANTITIES, str(error)), None, None)


def _measure(
    track: Track, tilt: _Tilt, recording: Recording, notes: list[str]
) -> Slide:
    time, x = track.time, track.x
    sign = 1.0 if _first_mean(x[::-1]) >= _first_mean(x) else -1.0
    noise = difference_noise(x, 2) + 1e-9
    travel = float(np.ptp(x))
    least = max(20 * noise, 0.3 if track.unit == "mm" else 2.0)
    if travel < least:
        raise MeasurementError(
            f"the block does not slide: it moves {travel:.3g} {track.unit} in all"
        )
    stop = _end_of_slide(time, sign * x, noise)
    physical = track.physical
    found, values, cov = _fit_onset(track, tilt, sign, stop, physical)
    onset = float(values[0])
    angle = math.degrees(float(np.interp(onset, time, tilt.angle)))
    rate = math.degrees(abs(float(np.interp(onset, time, tilt.rate))))
    onset_sd = math.sqrt(cov[0, 0])
    sd = math.hypot(rate * onset_sd, tilt.sd)
    radians = math.radians(angle)
    steep = math.radians(1.0) / math.cos(radians) ** 2
    slide_angle = Quantity("slide_angle", angle, sd, "deg", sd_common=tilt.sd)
    static = Quantity(
        "static_friction", math.tan(radians), steep * sd, "1", sd_common=steep * tilt.sd
    )
    if physical:
        kinetic = _kinetic(values, cov, track, tilt, onset, stop, recording)
    else:
        unknown = "camera.mm_per_px" if track.unit == "px" else "camera.fps"
        kinetic = failed(
            "kinetic_friction",
            "1",
            f"the acceleration is known in pixels or frames only; {unknown} is needed",
        )
    quantities = [slide_angle, static, kinetic]
    quantities = [
        _doubts(q, track, onset, stop, found, noise, travel, kinetic, static)
        for q in quantities
    ]
    if found.rho > 0.3:
        notes.append(
            f"successive frames err together (AR(1) ρ = {found.rho:.2f}); the standard"
            " deviations allow for it"
        )
    if stop < len(x):
        notes.append(
            f"the slide ends at {time[stop - 1]:.4g} {track.time_unit}; what follows is"
            " not fitted"
        )
    return Slide(
        tuple(quantities),
        onset,
        (time[:stop], x[:stop] - sign * found.residuals),
        tuple(notes),
    )


def _tilt(track: Track, recording: Recording) -> tuple[_Tilt, list[str]]:
    """The plate's angle from the track, or from the stated start and rate, and notes;
    MeasurementError naming the missing key."""
    time, stated, pictured = track.time, recording.slide, track.tilt_sd_deg is not None
    rate, start, notes = stated.tilt_rate_deg_s, stated.start_deg, []
    if track.tilt_deg is not None and np.isfinite(track.tilt_deg).sum() >= 4:
        known = np.isfinite(track.tilt_deg)
        # local lines over about a thirtieth of the rows
        filled = np.interp(time, time[known], track.tilt_deg[known])
        window = max(5, len(filled) // 30) // 2 * 2 + 1
        angle = savgol_filter(filled, window, 1) if len(filled) > window else filled
        sd = track.tilt_sd_deg or math.hypot(
            TILT_SD_DEG, reading_step(track.tilt_deg[known]) / math.sqrt(12)
        )
    elif rate is None or not track.timed:
        raise MeasurementError(
            f"{recording.toml}: {ANGLE_MISSING}"
            + ("" if track.timed or not rate else " together with camera.fps")
        )
    elif start is None:
        raise MeasurementError(f"{recording.toml}: {START_MISSING}")
    else:
        angle = start + rate * time
        sd = math.hypot(START_SD_DEG, RATE_SD * rate * float(np.abs(time).max()))
        notes = [
            f"the plate's angle is as stated: {start:g}° at t = 0, ± {START_SD_DEG:g}°,"
            f" and {rate:g} °/s, ± {100 * RATE_SD:g} %"
        ]
    theta = np.radians(angle)
    gradient = np.gradient(theta, time)
    double = (
        *integrals(time, G_MM_S2 * np.sin(theta)),
        *integrals(time, G_MM_S2 * np.cos(theta)),
    )
    return _Tilt(theta, gradient, *double, sd, pictured), notes


def integrals(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First and second cumulative integral from the first row; exact for values that
    are linear between rows."""
    h = np.diff(time)
    first = np.concatenate([[0.0], np.cumsum(h * (values[1:] + values[:-1]) / 2)])
    second = np.concatenate(
        [[0.0], np.cumsum(h * first[:-1] + h**2 * (2 * values[:-1] + values[1:]) / 6)]
    )
    return first, second


def _from(
    onset: float,
    time: np.ndarray,
    values1: np.ndarray,
    values2: np.ndarray,
    density: np.ndarray,
) -> np.ndarray:
    """The double integral from `onset` on (0 before it), from the integrals that begin
    at the first row."""
    row = int(np.clip(np.searchsorted(time, onset) - 1, 0, len(time) - 2))
    s = onset - time[row]
    h = time[row + 1] - time[row]
    slope = (density[row + 1] - density[row]) / h
    one = values1[row] + density[row] * s + slope * s**2 / 2
    two = values2[row] + values1[row] * s + density[row] * s**2 / 2 + slope * s**3 / 6
    return np.where(time > onset, values2 - two - one * (time - onset), 0.0)


def _turning(time: np.ndarray, x: np.ndarray, tilt: _Tilt) -> np.ndarray:
    """∫ 2 θ̇ (x − x₀) dt from the first row (Coriolis), without which an onset at 2 °/s
    is found 0.07° late; x downhill."""
    return integrals(time, 2 * tilt.rate * (x - _first_mean(x)))[0]


def _design(
    onset: float, time, tilt: _Tilt, turning, stop: int, physical: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Columns [1, C − B] and the known part A (physical), or [1, A, −B] and μ_s C where
    the length unit is unknown. With the plate's angle from the picture, one more
    column: the angle itself."""
    a = _from(onset, time, tilt.sin1, tilt.sin2, G_MM_S2 * np.sin(tilt.angle))[:stop]
    b = _from(onset, time, tilt.cos1, tilt.cos2, G_MM_S2 * np.cos(tilt.angle))[:stop]
    c = np.where(time > onset, turning - np.interp(onset, time, turning), 0.0)[:stop]
    one = np.ones(stop)
    columns = [one, c - b] if physical else [one, a, -b]
    if (
        tilt.pictured
    ):  # an error of the estimated hinge makes a travel proportional to the angle
        columns.append(tilt.angle[:stop] - tilt.angle[0])
    return np.column_stack(columns), (
        a if physical else math.tan(float(np.interp(onset, time, tilt.angle))) * c
    )


def _fit_onset(track: Track, tilt: _Tilt, sign: float, stop: int, physical: bool):
    """The linear fit at the best onset, and (onset, linear parameters) with their joint
    covariance."""
    time, x, lag = track.time, sign * track.x[:stop], frame_lag(track.frame[:stop])
    turning = _turning(time, sign * track.x, tilt)

    def misfit(onset: float, rho: float) -> float:
        design, known = _design(onset, time, tilt, turning, stop, physical)
        both = whiten(np.column_stack([design, x - known]), lag, rho)
        return float(np.asarray(np.linalg.qr(both, mode="r"))[-1, -1] ** 2)

    rho = onset = 0.0
    for turn in range(2):
        near = (time[stop - 1] - time[0]) / 100
        grid = (
            np.linspace(time[0], time[stop - 3], 160)
            if turn == 0
            else onset + np.linspace(-near, near, 21)
        )
        best = int(np.argmin([misfit(float(t), rho) for t in grid]))
        bounds = (grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)])
        options = {"xatol": 1e-4 * (bounds[1] - bounds[0])}
        onset = float(
            minimize_scalar(
                misfit, args=(rho,), bounds=bounds, method="bounded", options=options
            ).x
        )
        design, known = _design(onset, time, tilt, turning, stop, physical)
        if turn == 0:
            rho = estimate_rho(design, x - known, lag)
    found = fit(design, x - known, lag, rho=rho)

    def model(onset: float) -> np.ndarray:
        columns, part = _design(onset, time, tilt, turning, stop, physical)
        return columns @ found.params + part

    step = max(1e-4 * (time[stop - 1] - time[0]), 0.2 * track.step)
    slope = (model(onset + step) - model(onset - step)) / (2 * step)
    jacobian = whiten(np.column_stack([slope, design]), lag, rho) / found.noise
    cov = np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-15)
    cov[0, 0] = (
        _onset_sd(
            lambda t: misfit(t, rho) / found.noise**2, onset, time[0], time[stop - 3]
        )
        ** 2
    )
    return found, np.concatenate([[onset], found.params]), cov


def _onset_sd(misfit, onset: float, first: float, last: float) -> float:
    """sd of the onset from the interval in which the misfit [σ²] rises by less than
    1.96². The linearised covariance does not suffice: with μ_k = μ_s the misfit rises
    with the fourth power."""
    least = misfit(onset)
    reach = []
    for limit in (first, last):
        near, far = 0.0, 1.0
        for _ in range(16):  # shares of the way from the onset to the limit
            middle = far / 16 if near == 0 else (near + far) / 2
            inside = misfit(onset + middle * (limit - onset)) < least + 1.96**2
            near, far = (middle, far) if inside else (near, middle)
        reach.append(abs(limit - onset) * (near + far) / 2)
    return sum(reach) / 2 / 1.96


def _kinetic(
    params,
    cov,
    track: Track,
    tilt: _Tilt,
    onset: float,
    stop: int,
    recording: Recording,
) -> Quantity:
    """Quantity kinetic_friction, with errors of scale and tilt: Δμ = (a / g cos θ)
    Δscale and Δμ = Δθ / cos² θ."""
    late = slice(np.searchsorted(track.time, onset), stop)
    theta = (
        float(np.mean(tilt.angle[late]))
        if stop > late.start
        else float(tilt.angle[stop - 1])
    )
    value = float(params[2])
    pull = math.tan(theta) - value
    parts = [
        math.sqrt(cov[2, 2]),
        pull * recording.camera.scale_sd,
        math.radians(tilt.sd) / math.cos(theta) ** 2,
    ]
    return Quantity(
        "kinetic_friction",
        value,
        math.hypot(*parts),
        "1",
        sd_common=math.hypot(*parts[1:]),
    )


def _doubts(
    q: Quantity, track: Track, onset, stop, found, noise, travel, kinetic, static
) -> Quantity:
    if q.quality == "failed":
        return q
    before = int((track.time[:stop] < onset).sum())
    if before < 4:
        q = q.doubt(
            "the block moves from the first frames on: the onset is not in the"
            " recording"
        )
    if stop - before < 6:
        q = q.doubt(f"only {stop - before} frames of sliding")
    if found.noise > max(5 * noise, 0.02 * travel):
        q = q.doubt(
            "the travel is not that of one block under constant friction (off by"
            f" {found.noise:.2g} {track.unit})"
        )
    if math.isfinite(kinetic.value) and kinetic.value > static.value + 2 * math.hypot(
        kinetic.sd, static.sd
    ):
        q = q.doubt("kinetic friction above static friction")
    if math.isfinite(kinetic.value) and kinetic.value < -2 * kinetic.sd:
        q = q.doubt("negative kinetic friction: is the scale or the frame rate wrong?")
    return q


def _end_of_slide(time: np.ndarray, x: np.ndarray, noise: float) -> int:
    """Row at which the block meets a stop or leaves the plate: its speed has fallen
    well below the greatest."""
    width = max(3, len(x) // 100)
    if len(x) < 3 * width + 4:
        return len(x)
    speed = (x[width:] - x[:-width]) / (time[width:] - time[:-width])
    peak = int(np.argmax(speed))
    error = 2 * noise / max(float(np.median(time[width:] - time[:-width])), 1e-12)
    slower = np.flatnonzero(speed[peak:] < 0.75 * speed[peak] - 3 * error)
    return len(x) if not len(slower) else max(peak + 1, 8)


def _first_mean(x: np.ndarray) -> float:
    return float(np.median(x[: max(3, len(x) // 20)]))
