"""Measures a roll: chooses the method, and measures rolls of few rows or on an incline
only by their accelerations.

    on the incline  a = g (sin β − μ_r cos β) / (1 + I/(m r²)),
    on the level    b = −g μ_r / (1 + I/(m r²))

μ_r is torque over normal force times rolling radius (as a length: μ_r times that
radius). For tracks from release to stop see `run_out`; for the fit of the legs
`roll_legs`."""

import math
from dataclasses import replace

import numpy as np
from benchtwin.bench.air import UNKNOWN_DRAG_PER_M
from benchtwin.bench.constants import G_MM_S2
from benchtwin.vision.measurement import MeasurementError, Quantity, all_failed, failed
from benchtwin.vision.motion.gravity import drag_per_metre
from benchtwin.vision.motion.inertia import inertia_of_recording
from benchtwin.vision.motion.least_squares import frame_lag
from benchtwin.vision.motion.roll_legs import (
    FEW_ROWS,
    Leg,
    Nuisance,
    Rows,
    fit_legs,
    travel,
    with_nuisance_errors,
)
from benchtwin.vision.motion.run_out import (
    INCLINE_SD_DEG,
    LENGTH_SD_MM,
    RunOut,
    ends_on_incline,
    measure_run_out,
)
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording

LEAST_ROWS = 4
CURVE_POINTS = 400  # of a curve in a picture
LEAST_TRAVEL_MM = 1.0
DRAG_SD = (
    0.5  # relative: a ball's drag beside a plate or rails differs from that in free air
)
ASSUMED_DENSITY = 1000.0  # kg/m³ of a seed of unknown mass, for the error due to drag
TOO_FAST = (
    "negative: the seed rolls faster than without resistance; check incline_deg, scale"
    " and inertia_factor"
)
LEVEL_HINT = "say [roll] level = false where the seed stays on its incline"


def measure_roll(
    track: Track, recording: Recording, *, junction: tuple[float, float] | None = None
) -> RunOut:
    """Measure a roll; junction: (place, sd) along the path where the picture shows
    it."""
    used = track.used()
    stays = stays_on_incline(used, recording)
    few = junction is None and (
        recording.evidence == "gates.csv" or len(used) < FEW_ROWS
    )
    if not stays and not few:
        return measure_run_out(track, recording, junction=junction)
    try:
        rows, sign = rows_of(used, recording)
        return (
            _measure_on_incline(rows, sign, recording)
            if stays
            else _measure_both_legs(rows, sign, recording)
        )
    except MeasurementError as error:
        first = ("acceleration", "m/s²") if stays else ("run_out", "mm")
        return RunOut(all_failed((first, ("rolling_resistance", "1")), str(error)))


def stays_on_incline(track: Track, recording: Recording) -> bool:
    """Whether all rows of a roll are on its incline: as stated or, where only its
    length is stated, by the rows."""
    if recording.roll.level is not None:
        return not recording.roll.level
    length = recording.roll.incline_length_mm
    if length is None or not track.physical or len(track) < LEAST_ROWS:
        return False
    if len(track) >= FEW_ROWS:
        return ends_on_incline(track.t_s, track.x, length)
    along = np.abs(track.x - track.x[0])
    return bool(
        along.max() <= length + LENGTH_SD_MM
        and np.polyfit(track.t_s - track.t_s[0], along, 2)[0] > 0
    )


def rows_of(track: Track, recording: Recording) -> tuple[Rows, float]:
    """The rows for the fit, and the sign of the motion; MeasurementError where they
    lack a unit or are too few."""
    track.need_physical(recording)
    if len(track) < LEAST_ROWS:
        raise MeasurementError(
            f"{len(track)} usable rows; place, speed and acceleration need at least"
            f" {LEAST_ROWS}"
        )
    sign = 1.0 if track.x[-1] >= track.x[0] else -1.0
    x, gates = sign * track.x, recording.evidence == "gates.csv"
    if np.ptp(x) < LEAST_TRAVEL_MM:
        raise MeasurementError(
            f"the seed does not roll: it moves {np.ptp(x):.3g} mm in all"
        )
    lag = np.full(len(x), np.inf) if len(x) < FEW_ROWS else frame_lag(track.frame)
    return Rows(track.t_s, x, track.sd, lag, gates), sign


def _measure_on_incline(rows: Rows, sign: float, recording: Recording) -> RunOut:
    """Quantities acceleration and rolling_resistance of a seed that stays on its
    incline."""
    rows, notes = _before_stop(rows)
    nuisance, nuisance_sds, more = _nuisance(rows, recording)
    going = int(np.argmax(rows.x > rows.x[0] + 0.02 * np.ptp(rows.x)))
    first = max(min(going - 1, len(rows.x) - LEAST_ROWS), 0)
    at = float((rows.time[first] + rows.time[-1]) / 2)
    start = np.polyfit(rows.time[first:] - at, rows.x[first:], 2)[::-1] * [1, 1, 2]

    def legs(p: np.ndarray, k: Nuisance) -> tuple[Leg, ...]:
        return (Leg(at, p[0], p[1], p[2], k.drag),)

    def derived(p: np.ndarray, k: Nuisance) -> np.ndarray:
        pull = p[2] * k.scale * k.inertia / G_MM_S2
        return np.array(
            [p[2] * k.scale / 1000, math.tan(k.incline) - pull / math.cos(k.incline)]
        )

    found = fit_legs(rows, legs, start, nuisance)
    value, sd, common = with_nuisance_errors(
        rows, legs, found, nuisance, nuisance_sds, derived
    )
    if value[0] < -1.96 * sd[0]:
        raise MeasurementError(
            "the seed slows down; are its rows on an incline, and in the right order?"
        )
    acceleration = Quantity(
        "acceleration", value[0], sd[0], "m/s²", sd_common=common[0]
    )
    acceleration = acceleration.doubt(found.misfit_doubt)
    notes = [*notes, *more]
    drawn = _curve(rows, legs(found.params, nuisance), sign)
    if recording.roll.incline_deg is None:
        message = (
            f"{recording.toml}: [roll] incline_deg is missing; without it an"
            " acceleration gives no rolling friction"
        )
        return RunOut(
            (acceleration, failed("rolling_resistance", "1", message)),
            fitted=drawn,
            notes=tuple(notes),
        )
    friction = Quantity("rolling_resistance", value[1], sd[1], "1", sd_common=common[1])
    friction = friction.doubt(
        found.misfit_doubt, TOO_FAST if value[1] < -2 * sd[1] else ""
    )
    return RunOut((acceleration, friction), fitted=drawn, notes=tuple(notes))


def _before_stop(rows: Rows) -> tuple[Rows, list[str]]:
    """Rows until the end of the incline, where the seed slows down at once."""
    speed = np.diff(rows.x) / np.diff(rows.time)
    top = int(np.argmax(speed))
    slow = np.flatnonzero(speed[top:] < 0.5 * speed[top])
    if rows.gates or not len(slow):
        return rows, []
    stop = max(top + int(slow[0]), LEAST_ROWS)
    text = (
        f"the seed is stopped at {rows.time[stop - 1]:.4g} s; what follows is not"
        " fitted"
    )
    return replace(
        rows, **{n: getattr(rows, n)[:stop] for n in ("time", "x", "sd", "lag")}
    ), [text]


def _measure_both_legs(rows: Rows, sign: float, recording: Recording) -> RunOut:
    """Quantities run_out and rolling_resistance of few rows, some of them on the
    level."""
    nuisance, nuisance_sds, notes = _nuisance(rows, recording)
    if not math.isfinite(nuisance.corner):
        message = "with few rows it decides which are on the level"
        raise MeasurementError(
            f"{recording.toml}: [roll] incline_length_mm is missing; {message}"
            f" ({LEVEL_HINT})"
        )
    level = rows.x >= nuisance.corner
    count = int(level.sum())
    if not count:
        length = recording.roll.incline_length_mm
        raise MeasurementError(
            f"no row lies behind the incline of {length:g} mm: there is no run-out"
            f" ({LEVEL_HINT})"
        )
    speed = np.gradient(rows.x, rows.time)
    if count == len(level):
        at = float(rows.time[0])
        slow = -(speed[0] ** 2) / 2 / max(np.ptp(rows.x), 1e-9)
        start, last = np.array([rows.x[0], speed[0], slow]), 0

        def legs(p: np.ndarray, k: Nuisance) -> tuple[Leg, ...]:
            return (Leg(at, p[0], p[1], p[2], k.drag),)

    else:
        at = float(np.interp(nuisance.corner, np.maximum.accumulate(rows.x), rows.time))
        fast = float(np.interp(at, rows.time, speed))
        start = np.array(
            [
                at,
                fast,
                fast**2 / 2 / nuisance.corner,
                -(fast**2) / 2 / max(rows.x[-1] - nuisance.corner, 1.0),
            ]
        )
        last = 1

        def legs(p: np.ndarray, k: Nuisance) -> tuple[Leg, ...]:
            return Leg(p[0], k.corner, p[1], p[2], k.drag), Leg(
                p[0], k.corner, p[1] * k.keep, p[3], k.drag
            )

    def derived(p: np.ndarray, k: Nuisance) -> np.ndarray:
        leg = legs(p, k)[last]
        stop = float(leg.x(np.array([leg.rest()]))[0])
        return np.array(
            [
                (stop - k.corner) * k.scale,
                -leg.acceleration * k.scale * k.inertia / G_MM_S2,
            ]
        )

    found = fit_legs(rows, legs, start, nuisance)
    if legs(found.params, nuisance)[last].acceleration >= 0:
        raise MeasurementError(
            "the seed does not slow down on the level: its rows give neither run-out"
            " nor friction"
        )
    value, sd, common = with_nuisance_errors(
        rows, legs, found, nuisance, nuisance_sds, derived
    )
    run_out = Quantity("run_out", value[0], sd[0], "mm", sd_common=common[0]).doubt(
        found.misfit_doubt
    )
    ahead = value[0] / nuisance.scale + nuisance.corner - rows.x[-1]
    if ahead > 0.25 * value[0]:
        run_out = run_out.doubt(
            f"the stop is extrapolated by {ahead:.3g} mm beyond the last row"
        )
    friction = Quantity("rolling_resistance", value[1], sd[1], "1", sd_common=common[1])
    friction = friction.doubt(found.misfit_doubt)
    notes.append(
        "few rows: rolling friction is from the deceleration on the level, the run-out"
        " from where it ends"
    )
    drawn = _curve(rows, legs(found.params, nuisance), sign)
    stop = sign * (nuisance.corner + value[0])
    return RunOut(
        (run_out, friction),
        sign * nuisance.corner,
        stop,
        float(rows.time[-1]),
        drawn,
        tuple(notes),
    )


def _curve(
    rows: Rows, legs: tuple[Leg, ...], sign: float
) -> tuple[np.ndarray, np.ndarray]:
    """Times and places of the fitted curve, for the plot."""
    time = np.linspace(rows.time[0], rows.time[-1], CURVE_POINTS)
    return time, sign * travel(legs, time)[0]


def _nuisance(
    rows: Rows, recording: Recording
) -> tuple[Nuisance, dict[str, float], list[str]]:
    """Nuisance parameters, their sds, and notes."""
    roll, inertia, notes = recording.roll, inertia_of_recording(recording), []
    beta = math.nan if roll.incline_deg is None else math.radians(roll.incline_deg)
    speed = float(np.ptp(rows.x) / np.ptp(rows.time)) / 1000
    drag = drag_per_metre(recording, speed)
    drag_sd = None if drag is None else DRAG_SD * drag
    if drag is None:
        dense = recording.seed.model_copy(update={"density_kg_m3": ASSUMED_DENSITY})
        drag, drag_sd = (
            0.0,
            drag_per_metre(replace(recording, seed=dense), speed) or UNKNOWN_DRAG_PER_M,
        )
        if drag_sd * 1000 * speed**2 > 3e-3 * G_MM_S2:
            missing = "[seed] sizes and mass_g or density_kg_m3 are unknown"
            notes.append(
                f"air drag is not allowed for: {missing}; the sd contains what it"
                " may be"
            )
    waits = abs(rows.x[1] - rows.x[0]) < 0.01 * np.ptp(rows.x) and not rows.gates
    corner = (
        math.nan
        if roll.incline_length_mm is None
        else roll.incline_length_mm + (rows.x[0] if waits else 0.0)
    )
    lost = 0.0 if math.isnan(beta) else (1 - math.cos(beta)) / inertia.factor
    nuisance = Nuisance(
        drag / 1000 / inertia.factor, corner, 1 - lost / 2, inertia.factor, beta
    )
    scale_sd = 0.0 if recording.evidence == "gates.csv" else recording.camera.scale_sd
    nuisance_sds = {
        "drag": (drag_sd or 0.0) / 1000 / inertia.factor,
        "corner": LENGTH_SD_MM,
        "keep": lost / math.sqrt(12),
        "inertia": inertia.factor * inertia.sd,
        "incline": math.radians(INCLINE_SD_DEG),
        "scale": scale_sd,
    }
    on = f"on rails {roll.rail_gap_mm:g} mm apart" if roll.rail_gap_mm else "on a plate"
    notes.append(
        f"1 + I/(m r²) is taken as {inertia.factor:.4g} ±"
        f" {inertia.factor * inertia.sd:.2g}, {on}"
    )
    return nuisance, nuisance_sds, notes
