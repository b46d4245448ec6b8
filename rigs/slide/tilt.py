"""The plate's angle over time, from its column or the stated rate; steps in the
column."""

import math
from dataclasses import dataclass

import numpy as np

from benchtwin.bench.priors import stated_sd

# the angle is learnt from so many times the slide's duration, up to its end
SLIDES_SEEN = 3.0
EXACT_RATE = 1e-9  # [rad/s]: of a column without noise, what rounding leaves
TILTS_SDS = 3.0  # of its rate: a column that rises by less shows a plate that stands
BEND_CHI2 = 16.0  # fall of χ² for quadratic and cubic terms
RESOLUTION_DEG = 0.105  # of a sensor, below which steps are not looked for
# of steps: greatest share of the variance left, least fall of χ²
STAIR_SHARE = 0.6
STAIR_CHI2 = 60.0


@dataclass(frozen=True, eq=False)
class Tilt:
    """The plate's angle over time."""

    origin: float
    coefficients: np.ndarray  # (4,) of θ [rad] in t − origin, lowest first
    level_sd: float  # [rad]
    rate_sd: float  # [rad/s]
    rate_deg_s: float  # at the onset
    sensor: bool  # whether an angle was recorded
    grid_deg: float = 0.0  # height of steps in the column, 0 for none
    read_to_deg: float = 0.0  # step of the column's numbers, 0 unknown
    zero_sd_deg: float | None = None  # of the sensor, if not the usual one

    @property
    def stands(self) -> bool:
        """Whether the plate stands."""
        return not self.coefficients[1]

    def at(self, time: np.ndarray | float) -> np.ndarray:
        """Angle [rad] at some times."""
        since = np.asarray(time, float) - self.origin
        return np.polynomial.polynomial.polyval(since, self.coefficients)


def stated_tilt(
    rate_deg_s: float, start_deg: float, start_sd_deg: float, origin: float
) -> Tilt:
    """A steady rate from the angle at t = 0 on."""
    angle = [start_deg + rate_deg_s * origin, rate_deg_s, 0.0, 0.0]
    rate_sd = stated_sd("tilt-rate") * math.radians(rate_deg_s)
    level_sd = math.hypot(math.radians(start_sd_deg), rate_sd * origin)
    return Tilt(origin, np.radians(angle), level_sd, rate_sd, rate_deg_s, False)


def standing_tilt(angle_deg: float, origin: float) -> Tilt:
    """A plate that stands at a stated angle."""
    angle = np.array([math.radians(angle_deg), 0.0, 0.0, 0.0])
    sd = math.radians(stated_sd("level-plate"))
    return Tilt(origin, angle, sd, 0.0, 0.0, False)


def seen_tilt(time: np.ndarray, column: np.ndarray, origin: float, end: float) -> Tilt:
    """A polynomial of degree ≤ 3 through the column's end; of degree 0 where no
    tilting shows."""
    used = np.isfinite(column)
    near = used & (time >= end - SLIDES_SEEN * (end - origin))
    rows = near if near.sum() >= 50 else used
    s, y = time[rows] - origin, np.radians(column[rows])
    coefficients, covariance, noise = _line(s, y, 1)
    bent, wide, fine = _line(s, y, 3)
    spread = _independent(s, y, bent)
    if len(s) > 20:
        gain = len(s) * math.log(max(noise, 1e-30) / max(fine, 1e-30)) / spread
    else:
        gain = 0.0
    ramp = np.degrees(np.polynomial.polynomial.polyval(s, coefficients))
    stair = _stairs(ramp, np.degrees(y))
    if gain > BEND_CHI2 and not stair:
        coefficients, covariance = bent, wide
    spread = _independent(s, y, coefficients)
    level, rate = np.sqrt(np.diag(covariance)[:2] * spread)
    full = np.zeros(4)
    full[: len(coefficients)] = coefficients
    if abs(full[1]) <= TILTS_SDS * max(rate, EXACT_RATE):
        coefficients, covariance, _ = _line(s, y, 0)
        level = math.sqrt(covariance[0, 0] * _independent(s, y, coefficients))
        full, rate, stair = np.array([*coefficients, 0.0, 0.0, 0.0]), 0.0, 0.0
    level_sd = max(float(level), 1e-7)
    rate_sd = max(float(rate), EXACT_RATE)
    return Tilt(origin, full, level_sd, rate_sd, math.degrees(full[1]), True, stair)


def _line(
    s: np.ndarray, y: np.ndarray, degree: int
) -> tuple[np.ndarray, np.ndarray, float]:
    """Coefficients, their covariance for independent noise, and its variance."""
    design = np.vander(s, degree + 1, increasing=True)
    coefficients = np.linalg.lstsq(design, y, rcond=None)[0]
    variance = float(((y - design @ coefficients) ** 2).sum()) / max(
        len(s) - degree - 1, 1
    )
    return coefficients, variance * np.linalg.pinv(design.T @ design), variance


def _independent(s: np.ndarray, y: np.ndarray, coefficients: np.ndarray) -> float:
    """Rows to an independent one: (1 + ρ)/(1 − ρ) of the residuals."""
    left = y - np.polynomial.polynomial.polyval(s, coefficients)
    power = float((left**2).sum())
    rho = float((left[1:] * left[:-1]).sum()) / power if power > 0 else 0.0
    rho = min(max(rho, 0.0), 0.98)
    return (1 + rho) / (1 - rho)


def _stairs(ramp: np.ndarray, column: np.ndarray) -> float:
    """Height [deg] of steps φ + h ⌊(ramp + h/2 − φ)/h⌋ in the column; 0 for none."""
    span, step = float(np.ptp(ramp)), float(np.median(np.abs(np.diff(ramp))))
    about = float(((column - ramp) ** 2).mean())
    lowest, highest = max(RESOLUTION_DEG, 3 * step), span / 2.5
    if about <= 0 or highest <= lowest:
        return 0.0

    def left(height: float, phase: float) -> float:
        stairs = phase + height * np.floor((ramp + height / 2 - phase) / height)
        return float(((column - stairs) ** 2).mean())

    grid = np.exp(
        np.arange(math.log(lowest), math.log(highest), 0.15 * lowest / span + 0.01)
    )
    best = min((left(h, f * h), h, f * h) for h in grid for f in np.arange(0, 1, 0.1))
    for width in (0.01, 0.003, 0.001):
        near = best
        best = min(
            (
                left(near[1] * (1 + a), near[2] + b * near[1]),
                near[1] * (1 + a),
                near[2] + b * near[1],
            )
            for a in np.linspace(-width, width, 9)
            for b in np.linspace(-3 * width, 3 * width, 9)
        )
    share = best[0] / about
    if share > STAIR_SHARE or -len(ramp) * math.log(max(share, 1e-12)) < STAIR_CHI2:
        return 0.0
    number = np.round((column - best[2]) / best[1])
    return float(np.polyfit(number, column, 1)[0])
