"""Plate vibration: the drive shakes the plate along its slope."""

from calibrate.diagnose.effects.effect import Effect


def amplitude(wave_mm: float, omega: float) -> float:
    """Of the acceleration [m/s²] that makes a freely sliding block ripple by `wave_mm` at ω [rad/s]: ω² x."""
    return 1e-3 * wave_mm * omega**2


EFFECT = Effect(
    name="plate-vibration", sector="sliding", unit="m/s^2", meaning="amplitude", prior_sd=0.5, low=-20.0, high=20.0,
    source="stepper drives; a travel that ripples at one frequency in all runs",
    separating="the same slide with the plate raised by hand, the drive off",
)  # fmt: skip
