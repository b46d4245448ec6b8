"""Kinetic friction of a slide with few rows (light gates along the plate, some
pictures) at a known angle.

    x = x₀ + v₀ τ + A(τ) − μ_k [B(τ) − C(τ)],
    A, B the double integrals of g sin θ and g cos θ, C that of 2 θ̇ ẋ (Coriolis)

θ is the plate's tilt_deg where the rows have it, else [slide] start_deg at t = 0 plus
tilt_rate_deg_s · t (0 where not stated). Linear in x₀, v₀ and μ_k: four rows are
enough. Few rows do not show the onset, so there is no static friction."""

import math

import numpy as np
from benchtwin.bench.constants import G_MM_S2
from benchtwin.vision.measurement import MeasurementError, Quantity, all_failed, failed
from benchtwin.vision.motion.least_squares import all_stated, variance_factor
from benchtwin.vision.motion.outliers import rows_at_rest
from benchtwin.vision.motion.slide import (
    QUANTITIES,
    TILT_SD_DEG,
    Slide,
    integrals,
    measure_slide_track,
)
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording

FEW_ROWS = 16  # with fewer, the rows about the onset do not separate rest and slide
UNKNOWNS = 3
NO_ONSET = (
    "light gates and tracks of few rows do not show when the block lets go; a reading"
    " of the angle, a film or a longer track does"
)


def measure_slide(track: Track, recording: Recording) -> Slide:
    """Measure a slide: kinetic friction for few rows; slide angle and both frictions
    for a track that begins at rest."""
    used = track.used()
    if recording.evidence != "gates.csv" and len(used) >= FEW_ROWS:
        return measure_slide_track(track, recording)
    onset = all_failed(QUANTITIES[:2], NO_ONSET)
    try:
        friction, fitted, notes = _kinetic(used, recording)
    except MeasurementError as error:
        return Slide((*onset, failed("kinetic_friction", "1", str(error))), None, None)
    return Slide((*onset, friction), None, fitted, notes)


def _kinetic(
    track: Track, recording: Recording
) -> tuple[Quantity, tuple[np.ndarray, np.ndarray], tuple[str, ...]]:
    track.need_physical(recording)
    sign = 1.0 if track.x[-1] >= track.x[0] else -1.0
    moving = track.take(slice(rows_at_rest(track.x), None))
    if len(moving) <= UNKNOWNS:
        raise MeasurementError(
            f"{len(moving)} rows of sliding; place, speed and friction need at least"
            f" {UNKNOWNS + 1}"
        )
    time, x = moving.t_s, sign * moving.x
    theta, sd_deg, note = _angle(moving, recording)
    value, sd, curve, doubt = _fit(
        time, x, moving.sd, theta, recording.evidence == "gates.csv"
    )
    middle = float(np.mean(theta))
    scale_sd = 0.0 if recording.evidence == "gates.csv" else recording.camera.scale_sd
    sd = math.sqrt(
        sd**2
        + ((math.tan(middle) - value) * scale_sd) ** 2
        + (math.radians(sd_deg) / math.cos(middle) ** 2) ** 2
    )
    negative = (
        "negative kinetic friction: are angle, scale and times right?"
        if value < -2 * sd
        else ""
    )
    quantity = Quantity("kinetic_friction", value, sd, "1").doubt(negative, doubt)
    return quantity, (time, sign * curve), (note,)


def _angle(track: Track, recording: Recording) -> tuple[np.ndarray, float, str]:
    """The plate's angle (n,) [rad], its sd [deg], a note; MeasurementError naming the
    key where it is unknown."""
    slide = recording.slide
    if track.tilt_deg is not None and np.isfinite(track.tilt_deg).all():
        sd = TILT_SD_DEG if track.tilt_sd_deg is None else track.tilt_sd_deg
        return (
            np.radians(track.tilt_deg),
            sd,
            "the plate's angle is that of tilt_deg at each row",
        )
    if slide.start_deg is None:
        message = (
            "[slide] start_deg, the plate's angle at t = 0, is missing; without it an"
            " acceleration gives no friction"
        )
        raise MeasurementError(f"{recording.toml}: {message}")
    rate = slide.tilt_rate_deg_s or 0.0
    motion = (
        f"tilting at {rate:g} °/s from {slide.start_deg:g}° at t = 0"
        if rate
        else f"standing at {slide.start_deg:g}°"
    )
    sd = math.hypot(TILT_SD_DEG, 0.01 * rate * float(track.t_s[-1]))
    return np.radians(slide.start_deg + rate * track.t_s), sd, f"the plate is {motion}"


def _fit(
    time: np.ndarray, x: np.ndarray, sd: np.ndarray, theta: np.ndarray, gates: bool
) -> tuple[float, float, np.ndarray, str]:
    """μ_k, its sd, the fitted curve (n,), and why stated sds cannot hold ("" where they
    may)."""
    tau, rate = time - time.mean(), np.gradient(theta, time)
    fine = np.linspace(tau[0], tau[-1], 400)
    angle = np.interp(fine, tau, theta)
    speed = np.gradient(np.interp(fine, tau, x), fine)
    turning = (
        2 * np.interp(fine, tau, rate) * np.polyval(np.polyfit(fine, speed, 1), fine)
    )
    pull, press = (
        np.interp(tau, fine, integrals(fine, v)[1])
        for v in (G_MM_S2 * np.sin(angle), G_MM_S2 * np.cos(angle) - turning)
    )
    design = np.column_stack([np.ones(len(tau)), tau, -press])
    stated = all_stated(sd)
    weight = 1 / sd if stated else np.ones(len(tau))
    if gates and not stated:
        weight = 1 / np.maximum(
            np.abs(np.gradient(x, time)), 1e-3 * np.ptp(x) / np.ptp(time)
        )
    found = np.linalg.lstsq(design * weight[:, None], (x - pull) * weight, rcond=None)[
        0
    ]
    left = (x - pull - design @ found) * weight
    freedom, chi2 = len(x) - UNKNOWNS, float(left @ left)
    variance = float(
        np.linalg.pinv((design * weight[:, None]).T @ (design * weight[:, None]))[2, 2]
    )
    factor, doubt = variance_factor(max(chi2, 1e-18 * freedom), freedom, stated)
    return float(found[2]), math.sqrt(factor * variance), pull + design @ found, doubt
