"""Slowing down on the level → rolling resistance: torque over normal force times radius.

    ẍ (1 + I/(m r²)) = −μ_r g cos λ − g sin λ − k v²        λ the level's own slope, rising ahead; k v² the air's drag over mass

Unlike Eq. 3 of the run-out this leaves out neither the air nor what the seed loses at the corner, and needs neither the incline nor
a stop in the picture. The way is a parabola bent by the drag, whose double integral is taken over the parabola's own speed.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vision.measurement import MeasurementError, Quantity, failed
from vision.motion.correlated import Fit, fit, frame_lag
from vision.motion.flight import G_MM_S2
from vision.motion.gravity import UNKNOWN_DRAG_PER_M, drag_per_metre
from vision.motion.rolling import inertia_in
from vision.motion.slide import integrals
from vision.motion.track import Track
from vision.recording import Recording

NAME = "rolling_resistance"
LEVEL_SD_DEG = 0.05  # of a plate that was set with a spirit level
STATED_SLOPE_SD_DEG = 0.02
DRAG_SD = 0.3  # relative: a seed's shape, and the plate beneath it
CORNER_SHARE, STOP_SHARE = 0.1, 0.05  # of the way on the level: where the seed may hop and slip, where it may rock
LEAST_ROWS, LEAST_WAY_MM = 8, 5.0
UNEVEN = 0.01  # of the way: a seed that strays so far from its curve does not slow down evenly


@dataclass(frozen=True)
class Drag:
    """k [1/mm] at speeds [mm/s]; sd: relative, infinite where the seed is not described and k is a soybean's."""

    speed: np.ndarray
    k: np.ndarray
    sd: float

    def deceleration(self, speed: np.ndarray) -> np.ndarray:
        """k v² [mm/s²]."""
        return np.interp(speed, self.speed, self.k) * speed**2


@dataclass(frozen=True)
class Level:
    """rolling_resistance; rows (n,) from which it is, and the fitted way there [mm], one a row."""

    resistance: Quantity
    rows: np.ndarray
    curve: np.ndarray


def measure_level(track: Track, x: np.ndarray, junction: tuple[float, float], stop: float | None, recording: Recording) -> Level:
    """rolling_resistance of a seed on the level; failed, with the reason, where its rows do not tell.

    x (n,): way along the motion; junction: (place, sd), where the level begins; stop: where the seed came to rest, None where
    that is not in the picture; all in the track's unit.
    """
    try:
        if track.unit != "mm" or not track.timed:
            missing = "mm_per_px" if track.unit != "mm" else "fps"
            raise MeasurementError(f"{recording.toml}: [camera] {missing} is missing; an acceleration needs lengths and times")
        rows = _rows(track, x, junction, x.max() if stop is None else stop, stop is not None)
        return Level(*_resistance(track.take(rows), x[rows], rows, recording))
    except MeasurementError as error:
        return Level(failed(NAME, "1", str(error)), np.zeros(len(x), dtype=bool), np.zeros(0))


def _rows(track: Track, x: np.ndarray, junction: tuple[float, float], end: float, rests: bool) -> np.ndarray:
    """The rows that roll evenly: behind the corner, before the stop."""
    way = end - junction[0]
    begin = junction[0] + max(CORNER_SHARE * way, 3 * junction[1])
    there = (x > begin) & (x < end - (STOP_SHARE * way if rests else 0.0))
    if rests:
        there &= np.arange(len(x)) < np.argmax(x >= end - STOP_SHARE * way)
    if way < LEAST_WAY_MM or there.sum() < LEAST_ROWS:
        raise MeasurementError(f"{there.sum()} rows on {max(way, 0):.3g} mm of level: too few to see the seed slow down")
    return there


def _resistance(track: Track, x: np.ndarray, rows: np.ndarray, recording: Recording) -> tuple[Quantity, np.ndarray, np.ndarray]:
    time = track.t_s - track.t_s.mean()
    lag, inertia = frame_lag(track.frame), inertia_in(recording)
    design = np.column_stack([np.ones(len(time)), time, -(time**2) / 2])
    drag, parabola = drag_of(recording), fit(design, x, lag).params

    def slowing(share: float) -> Fit:
        """The parabola of rolling alone, with `share` of the drag taken out; its third number is the deceleration [mm/s²]."""
        speed = parabola[1] - parabola[2] * time
        for _ in range(3):
            lost, bent = integrals(time, share * drag.deceleration(np.maximum(speed, 0.0)) / inertia.factor)
            found = fit(design, x + bent, lag)
            speed = found.params[1] - found.params[2] * time - lost
        return found

    known = math.isfinite(drag.sd)
    found = slowing(1.0 if known else 0.0)
    slow, slow_sd = float(found.params[2]), math.sqrt(found.cov[2, 2])
    air = slow - float(slowing(1.0 + drag.sd if known else 1.0).params[2])
    value = slow * inertia.factor / G_MM_S2
    slope, slope_sd, to_all = _slope(recording)
    value += slope
    parts = {"scale": recording.camera.scale_sd * value, "inertia": inertia.sd * value, "air": air * inertia.factor / G_MM_S2}
    shared = [*parts.values(), slope_sd if to_all else 0.0]
    own = [slow_sd * inertia.factor / G_MM_S2, 0.0 if to_all else slope_sd]
    common = math.hypot(*shared)
    quantity = Quantity(NAME, value, math.hypot(common, *own), "1", sd_common=common)
    if found.noise > UNEVEN * np.ptp(x):
        quantity = quantity.doubt(f"the seed does not slow down evenly: it is off by {found.noise:.2g} mm")
    if value < -2 * quantity.sd:
        quantity = quantity.doubt("negative: the seed gains speed on the level; is the plate level, is y up?")
    return quantity, rows, x - found.residuals


def drag_of(recording: Recording) -> Drag:
    """Of the recording's seed and air; a soybean's, of infinite sd, where the seed is not described."""
    speeds = np.concatenate([[0.01], np.linspace(0.05, 5.0, 100)])
    k = [drag_per_metre(recording, float(v)) for v in speeds]
    if None in k:
        return Drag(1000 * speeds, np.full(len(speeds), UNKNOWN_DRAG_PER_M / 1000), math.inf)
    return Drag(1000 * speeds, np.array(k, dtype=float) / 1000, DRAG_SD)


def _slope(recording: Recording) -> tuple[float, float, bool]:
    """How much the level falls ahead of the seed, its sd, and whether that is an error of all rolls alike.

    slope_deg counts what falls towards +x. Rolled in both stated directions, what nobody knows of it averages out.
    """
    roll = recording.roll
    if roll.slope_deg is None or roll.direction is None:
        return 0.0, math.radians(LEVEL_SD_DEG), roll.direction is None
    side = 1.0 if roll.direction == "+x" else -1.0
    return side * math.tan(math.radians(roll.slope_deg)), math.radians(STATED_SLOPE_SD_DEG), False


def notes_of(recording: Recording, quantities: Sequence[Quantity]) -> list[str]:
    """What the resistance rests on, in words."""
    if not any(q.name == NAME and math.isfinite(q.value) for q in quantities):
        return []
    inertia, drag = inertia_in(recording), drag_of(recording)
    factor = f"1 + I/(m r²) = {inertia.factor:.4g} ± {inertia.factor * inertia.sd:.2g}"
    said = [f"{NAME}: {factor}; [seed] inertia_factor says it of a hollow seed"]
    if math.isinf(drag.sd):
        said.append(f"{NAME}: air drag is not allowed for: [seed] sizes and mass_g or density_kg_m3 are unknown; the sd holds a soybean's")
    if recording.roll.slope_deg is None:
        both = "rolled both ways it averages out" if recording.roll.direction else "state [roll] direction and roll both ways"
        said.append(f"{NAME}: the plate is level to ± {LEVEL_SD_DEG:g}°, unless [roll] slope_deg says how it slopes; {both}")
    return said
