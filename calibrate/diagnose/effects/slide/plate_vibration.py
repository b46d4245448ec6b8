"""Plate vibration: the drive shakes the plate along its slope."""

import math

from numba import njit

from calibrate.diagnose.effects.effect import Effect


@njit(cache=True)
def shake(time_s: float, value: float, omega: float, phase: float) -> float:
    """Acceleration beside gravity's [m/s²]: `value` cos(ω t + φ)."""
    return value * math.cos(omega * time_s + phase)


EFFECT = Effect(
    name="plate-vibration", sector="sliding", unit="m/s^2", meaning="amplitude", prior_sd=0.5, low=-20.0, high=20.0,
    source="stepper drives; a travel that ripples at one frequency in all runs",
    separating="the same slide with the plate raised by hand, the drive off",
)  # fmt: skip
