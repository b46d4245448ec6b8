"""Gravity, air drag and motion in depth of a drop: priors for the fit of its flights,
and a check of scale and frame rate.

Air drag is a small known correction of every parabola (flight.drag_shift) where the
recording describes the seed and its air. It reduces the speed of a soybean that falls
310 mm by 0.9 %; without it a restitution of 0.50 is measured as 0.497. Motion of a
bouncing seed towards the camera or away from it changes the scale."""

import math

import numpy as np
from benchtwin.bench.air import (
    SHAPE_SD,
    SLOWEST_M_S,
    UNKNOWN_DRAG_PER_M,
    air_of,
    drag_at,
)
from benchtwin.bench.constants import G_MM_S2
from benchtwin.bench.priors import unstated_sd
from benchtwin.vision.motion.flight import Flights, Gravity
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording

UNKNOWN_FALL_M = 0.6  # assumed height of an unknown fall: rms of heights up to 1 m
NEAREST_MM, FARTHEST_MM = (
    300.0,
    20_000.0,
)  # of a camera at unknown distance; log-uniform


def drag_per_metre(recording: Recording, speed: float) -> float | None:
    """k [1/m] of a = −k v |v| for the recording's seed and air at `speed` [m/s], as of
    a sphere of equal volume (bench.air); None where the seed is not described."""
    seed = recording.seed
    if not recording.air.density_kg_m3:
        return 0.0
    if not seed.sizes_mm or not (seed.mass_g or seed.density_kg_m3):
        return None
    about = {
        "seed": seed.model_dump(exclude_none=True),
        "air": recording.air.model_dump(exclude_none=True),
    }
    return drag_at(air_of(about), max(speed, SLOWEST_M_S))


def known_gravity(track: Track, recording: Recording) -> tuple[Gravity, list[str]]:
    """The prior of γ, and notes about scale, time and air."""
    if not track.physical:
        missing = (["scale"] if track.unit == "px" else []) + (
            [] if track.timed else ["frame rate"]
        )
        text = (
            f"{' and '.join(missing)} unknown: lengths in {track.unit}, times in"
            f" {track.time_unit}; ratios do not need them"
        )
        return Gravity(
            None, recording.camera.scale_sd if track.unit == "mm" else 0.0
        ), [text]
    fall_m = max(float(np.ptp(track.y)), 1e-9) / 1000
    speed = math.sqrt(fall_m * 2 * (G_MM_S2 / 1000))
    # local gravity, and what a lens and a camera's pitch do to a fall's curvature
    other = math.hypot(
        unstated_sd("gravity"),
        unstated_sd("perspective") * fall_m,
        2 * unstated_sd("lens"),
    )
    drag = drag_per_metre(recording, 0.75 * speed)
    if drag is None:
        text = (
            "air drag is not allowed for: [seed] sizes and mass_g or density_kg_m3 are"
            " unknown"
        )
        return Gravity(
            G_MM_S2,
            recording.camera.scale_sd,
            # drag takes k 2H/3 of g, on average over a fall
            math.hypot(other, 2 / 3 * UNKNOWN_DRAG_PER_M * fall_m),
        ), [text]
    share = drag * speed**2 / (G_MM_S2 / 1000)
    notes = (
        [
            f"air drag (up to {100 * share:.1f} % of the weight) is allowed for in the"
            " parabolas"
        ]
        if drag
        else []
    )
    return (
        Gravity(G_MM_S2, recording.camera.scale_sd, other, drag / 1000),
        notes,
    )  # the drag's own error: other_drag


def drag_one_sd_off(
    flights: Flights, track: Track, gravity: Gravity, recording: Recording
) -> float | None:
    """The drag, per length unit of the track, one sd from the assumed one; None where
    there is no air. Known drag has a relative sd of SHAPE_SD; where it is unknown,
    UNKNOWN_DRAG_PER_M is the sd. The length unit in metres follows from the scale, else
    from gravity, else (no clock) from the stated height or UNKNOWN_FALL_M."""
    if recording.air.density_kg_m3 == 0:
        return None
    if gravity.drag > 0:
        return gravity.drag * (1 + SHAPE_SD)
    if not track.timed:
        fall_m = (
            recording.drop.height_mm / 1000
            if recording.drop.height_mm
            else UNKNOWN_FALL_M
        )
        length_m = 1e-3 if track.unit == "mm" else fall_m / max(flights.fall(), 1e-9)
    else:
        length_m = (
            1e-3
            if gravity.value is not None
            else G_MM_S2 / 1000 / max(flights.free, 1e-9)
        )
    return UNKNOWN_DRAG_PER_M * length_m


def gravity_doubt(
    flights: Flights, track: Track, recording: Recording, gravity: Gravity
) -> str:
    """Why the acceleration of the flights contradicts the stated scale and frame rate;
    "" where it does not."""
    if gravity.value is None:
        return ""
    ratio = flights.free / gravity.value
    air = (
        SHAPE_SD * gravity.drag * float(np.ptp(track.y))
    )  # half of the drag's share of the weight, times its relative error
    allowed = math.sqrt(
        (flights.free_sd / gravity.value) ** 2
        + gravity.scale_sd**2
        + gravity.other_sd**2
        + air**2
    )
    if abs(ratio - 1) < 3 * allowed or len(np.concatenate(flights.rows)) < 6:
        return ""
    text = f"free fall gives {flights.free / 1000:.3g} m/s² instead of 9.81"
    if ratio <= 0:
        return f"{text}: this is no free fall (is y upwards?)"
    rate = math.sqrt(ratio)
    fps = (
        f"the frame rate is stated {max(rate, 1 / rate):.3g} × too"
        f" {'high' if ratio > 1 else 'low'}"
    )
    scale = (
        f"the scale (mm_per_px) {max(ratio, 1 / ratio):.3g} × too"
        f" {'large' if ratio > 1 else 'small'}"
    )
    stated = recording.drop.height_mm
    if stated and len(flights.rows) > 1 and release_seen(flights, track):
        fall = flights.fall()
        if abs(fall / stated - 1) < 0.03:
            return (
                f"{text}: {fps} (the fall of {stated:g} mm is right, so the scale is)"
            )
        if abs(fall / stated / ratio - 1) < 0.05:
            return (
                f"{text}: {scale} (the fall reads {fall:.4g} mm instead of {stated:g})"
            )
    if abs(ratio - 1) < 0.1 and not gravity.drag and recording.air.density_kg_m3:
        return (
            f"{text}: {fps}, or {scale}, or air drag counts (state [seed] sizes and"
            " mass_g)"
        )
    return f"{text}: {fps}, or {scale}"


def release_seen(flights: Flights, track: Track) -> bool:
    """Whether the release, the first flight's apex, is in the track."""
    first, fall_time = (
        flights.apex_time(0),
        track.time[flights.rows[0][-1]] - flights.apex_time(0),
    )
    return first >= track.time[0] - max(0.03 * fall_time, 1.5 * track.step)


def scale_note(flights: Flights, track: Track, gravity: Gravity) -> list[str]:
    """Notes on a scale or frame rate that is not stated, as gravity gives it."""
    gamma, relative = flights.free, flights.free_sd / flights.free
    if gamma <= 0:
        return []
    if track.unit == "px" and track.timed:
        scale = G_MM_S2 / gamma
        return [
            f"gravity makes it {scale:.5g} ± {scale * relative:.2g} mm per px (if the"
            " frame rate is right)"
        ]
    if track.unit == "mm" and not track.timed:
        rate = math.sqrt(G_MM_S2 / gamma)
        return [
            f"gravity makes it {rate:.5g} ± {rate * relative / 2:.2g} frames per second"
            " (if the scale is right)"
        ]
    if gravity.value is not None and abs(flights.params[-1]) > 2e-3:
        return [
            f"gravity corrects the scale by {-100 * flights.params[-1]:.2f} % within"
            " its stated sd"
        ]
    return []


def inverse_distance(distance_mm: float | None) -> float:
    """1/distance [1/mm]; for an unknown distance its root mean square."""
    if distance_mm:
        return 1 / distance_mm
    return math.sqrt(
        (NEAREST_MM**-2 - FARTHEST_MM**-2) / 2 / math.log(FARTHEST_MM / NEAREST_MM)
    )


def depth_drift_sd(
    sideways_mm_s: np.ndarray,
    lasts_s: np.ndarray,
    before_mm_s: float,
    distance_mm: float | None,
) -> float:
    """Relative sd of a restitution due to unseen motion in depth.

    sideways_mm_s, lasts_s: (2,) of the flights before and after. The seed is assumed to
    move in depth about as fast as sideways. Then the scales of the flights differ; and
    a change of depth looks like one of height, in proportion to the distance of the
    plate from the optical axis, which is assumed to be half a fall at `before_mm_s`.
    """
    depth = float(np.hypot(*(sideways_mm_s * lasts_s / 2)))
    lever = before_mm_s**2 / (4 * G_MM_S2)
    return inverse_distance(distance_mm) * math.hypot(
        depth, lever * float(np.hypot(*sideways_mm_s)) / before_mm_s
    )


def depth_drift_shifts(
    flights: Flights,
    time: np.ndarray,
    up: np.ndarray,
    across: np.ndarray,
    axis: float,
    distance_mm: float | None,
) -> list[np.ndarray]:
    """Changes of the heights `up` (n,) if the seed moved in depth during one flight as
    fast as sideways: one array for each flight. In later flights the depth stays
    changed. axis: height of the optical axis. The first flight's speed in depth is at
    most the one that it shows sideways."""
    speeds = np.array(
        [
            np.polyfit(time[r], across[r], 1)[0] if len(r) > 2 else 0.0
            for r in flights.rows
        ]
    )
    typical = float(np.sqrt(np.mean(speeds[1:] ** 2))) if len(speeds) > 1 else 0.0
    begins = [time[0], *(flights.contact_time(k) for k in range(len(flights.rows) - 1))]
    ends = [*begins[1:], time[-1]]
    out = []
    for k, (begin, end) in enumerate(zip(begins, ends)):
        speed = abs(float(speeds[0])) if k == 0 else max(typical, abs(float(speeds[k])))
        depth = speed * (np.clip(time, begin, end) - begin)
        out.append(-(up - axis) * depth * inverse_distance(distance_mm))
    return out
