"""Rolling resistance (torque over normal force times radius) from the deceleration on
the level.

    ẍ (1 + I/(m r²)) = −μ_r g cos λ − g sin λ − k v²

λ is the slope of the level, rising ahead; k v² the drag of the air over mass. Unlike
Eq. 3 of the run-out this accounts for the air and for the energy lost at the corner,
and needs neither the incline nor a stop in the picture. The path is a parabola plus the
double integral of the drag along that parabola."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from benchtwin.bench.air import UNKNOWN_DRAG_PER_M
from benchtwin.bench.constants import G_MM_S2
from benchtwin.vision.measurement import MeasurementError, Quantity, failed
from benchtwin.vision.motion.gravity import drag_per_metre
from benchtwin.vision.motion.inertia import inertia_of_recording
from benchtwin.vision.motion.least_squares import Fit, fit, frame_lag
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording

NAME = "rolling_resistance"
LEVEL_SD_DEG = 0.05  # of a plate that was set with a spirit level
STATED_SLOPE_SD_DEG = 0.02
DRAG_SD = 0.3  # relative: due to a seed's shape and the plate below it
# of the distance on the level: where the seed may hop and slip, and where it may rock
CORNER_SHARE, STOP_SHARE = (0.1, 0.05)
LEAST_ROWS, LEAST_TRAVEL_MM = 8, 5.0
# of the distance: residuals above it mean that the seed does not slow down evenly
UNEVEN = 0.01


@dataclass(frozen=True)
class Drag:
    """Drag coefficient k [1/mm] at speeds [mm/s]; sd: relative, infinite where the seed
    is not described and k is a soybean's."""

    speed: np.ndarray
    k: np.ndarray
    sd: float

    def deceleration(self, speed: np.ndarray) -> np.ndarray:
        """k v² [mm/s²]."""
        return np.interp(speed, self.speed, self.k) * speed**2


@dataclass(frozen=True)
class ResistanceFit:
    """Quantity rolling_resistance; rows (n,): mask of the rows used; curve: the fitted
    place [mm] at each of these."""

    resistance: Quantity
    rows: np.ndarray
    curve: np.ndarray


def fit_resistance(
    track: Track,
    x: np.ndarray,
    junction: tuple[float, float],
    stop: float | None,
    recording: Recording,
) -> ResistanceFit:
    """Fit rolling_resistance to the rows on the level; failed, with the reason, where
    they do not suffice. x (n,): place along the motion; junction: (place, sd) where the
    level begins; stop: place of rest, None where that is not in the picture; all in the
    track's unit."""
    try:
        track.need_physical(recording)
        rows = _rows(x, junction, x.max() if stop is None else stop, stop is not None)
        return ResistanceFit(*_resistance(track.take(rows), x[rows], rows, recording))
    except MeasurementError as error:
        return ResistanceFit(
            failed(NAME, "1", str(error)), np.zeros(len(x), dtype=bool), np.zeros(0)
        )


def _rows(
    x: np.ndarray, junction: tuple[float, float], end: float, rests: bool
) -> np.ndarray:
    """Mask of the rows between corner and stop."""
    distance = end - junction[0]
    begin = junction[0] + max(CORNER_SHARE * distance, 3 * junction[1])
    there = (x > begin) & (x < end - (STOP_SHARE * distance if rests else 0.0))
    if rests:
        there &= np.arange(len(x)) < np.argmax(x >= end - STOP_SHARE * distance)
    if distance < LEAST_TRAVEL_MM or there.sum() < LEAST_ROWS:
        raise MeasurementError(
            f"{there.sum()} rows on {max(distance, 0):.3g} mm of level: too few for a"
            " deceleration"
        )
    return there


def _resistance(
    track: Track, x: np.ndarray, rows: np.ndarray, recording: Recording
) -> tuple[Quantity, np.ndarray, np.ndarray]:
    time = track.t_s - track.t_s.mean()
    lag, inertia = frame_lag(track.frame), inertia_of_recording(recording)
    design = np.column_stack([np.ones(len(time)), time, -(time**2) / 2])
    drag, parabola = drag_of_recording(recording), fit(design, x, lag).params

    def fit_without_drag(share: float) -> Fit:
        """Parabola of the motion with `share` of the drag removed; its third parameter
        is the deceleration [mm/s²]."""
        speed = parabola[1] - parabola[2] * time
        for _ in range(3):
            lost, bent = integrals(
                time, share * drag.deceleration(np.maximum(speed, 0.0)) / inertia.factor
            )
            found = fit(design, x + bent, lag)
            speed = found.params[1] - found.params[2] * time - lost
        return found

    is_known = math.isfinite(drag.sd)
    found = fit_without_drag(1.0 if is_known else 0.0)
    deceleration, deceleration_sd = float(found.params[2]), math.sqrt(found.cov[2, 2])
    air = deceleration - float(
        fit_without_drag(1.0 + drag.sd if is_known else 1.0).params[2]
    )
    slope, slope_sd, slope_is_shared = _slope_of_level(recording)
    per = inertia.factor / G_MM_S2
    value = deceleration * per + slope
    scale_and_inertia = recording.camera.scale_sd * value, inertia.sd * value
    common = math.hypot(
        *scale_and_inertia, air * per, slope_sd if slope_is_shared else 0.0
    )
    sd = math.hypot(common, deceleration_sd * per, 0.0 if slope_is_shared else slope_sd)
    quantity = Quantity(NAME, value, sd, "1", sd_common=common)
    if found.noise > UNEVEN * np.ptp(x):
        quantity = quantity.doubt(
            f"the seed does not slow down evenly: it is off by {found.noise:.2g} mm"
        )
    if value < -2 * sd:
        quantity = quantity.doubt(
            "negative: the seed gains speed on the level; is the plate level, is y up?"
        )
    return quantity, rows, x - found.residuals


def drag_of_recording(recording: Recording) -> Drag:
    """Drag of the recording's seed in its air; a soybean's, of infinite sd, where the
    seed is not described."""
    speeds = np.concatenate([[0.01], np.linspace(0.05, 5.0, 100)])
    k = [drag_per_metre(recording, float(v)) for v in speeds]
    if None in k:
        return Drag(
            1000 * speeds, np.full(len(speeds), UNKNOWN_DRAG_PER_M / 1000), math.inf
        )
    return Drag(1000 * speeds, np.array(k, dtype=float) / 1000, DRAG_SD)


def _slope_of_level(recording: Recording) -> tuple[float, float, bool]:
    """tan of the level's slope, falling ahead of the seed, its sd, and whether that
    error is shared by all rolls. slope_deg is positive where the level falls towards
    +x. An unknown slope averages out over rolls in both stated directions."""
    roll = recording.roll
    if roll.slope_deg is None or roll.direction is None:
        return 0.0, math.radians(LEVEL_SD_DEG), roll.direction is None
    side = 1.0 if roll.direction == "+x" else -1.0
    return (
        side * math.tan(math.radians(roll.slope_deg)),
        math.radians(STATED_SLOPE_SD_DEG),
        False,
    )


def resistance_notes(recording: Recording, quantities: Sequence[Quantity]) -> list[str]:
    """Notes on what the rolling resistance is based on."""
    if not any(q.name == NAME and math.isfinite(q.value) for q in quantities):
        return []
    inertia, drag = inertia_of_recording(recording), drag_of_recording(recording)
    factor = f"1 + I/(m r²) = {inertia.factor:.4g} ± {inertia.factor * inertia.sd:.2g}"
    notes = [f"{NAME}: {factor}; state [seed] inertia_factor for a hollow seed"]
    if math.isinf(drag.sd):
        missing = "[seed] sizes and mass_g or density_kg_m3 are unknown"
        notes.append(
            f"{NAME}: air drag is not allowed for: {missing}; the sd contains a"
            " soybean's"
        )
    if recording.roll.slope_deg is None:
        both = (
            "rolled both ways it averages out"
            if recording.roll.direction
            else "state [roll] direction and roll in both"
        )
        notes.append(
            f"{NAME}: the plate is assumed level to ± {LEVEL_SD_DEG:g}°, as [roll]"
            f" slope_deg is not stated; {both}"
        )
    return notes


def integrals(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First and second cumulative integral from the first row; exact for values that
    are linear between rows."""
    h = np.diff(time)
    first = np.concatenate([[0.0], np.cumsum(h * (values[1:] + values[:-1]) / 2)])
    second = np.concatenate(
        [[0.0], np.cumsum(h * first[:-1] + h**2 * (2 * values[:-1] + values[1:]) / 6)]
    )
    return first, second
