"""Plate vibration: the drive shakes the plate along its slope.

At the worst phase of the wave the block lets go while the mean pull is still a below its friction, slips, and sticks again, each
wave a little farther, until the mean pull is up to the friction; from then on it slides without a stop, and is faster than a
block that has only just let go. Shaken across the slope as well it is a + μ a_n that acts.
"""

import math

from numba import njit

from calibrate.diagnose.effects.effect import Effect

HERTZ = 30.0  # about which ln-hertz counts
SHARE, SCATTER = 0.85, 0.2  # of a/ω; between phases


@njit(cache=True)
def released(value: float, ln_hertz: float, chance: float) -> float:
    """Mean speed [m/s] when the mean pull comes up to the friction: a/ω (SHARE + SCATTER `chance`), a = `value` [m/s²],
    ω = 2π HERTZ e^ln_hertz [rad/s], `chance` [sd] the phase's.

    a/ω is the most that any phase gives. Of a pull that grows by q a within a wave the mean over phases is a/ω (1 − q/4) and the
    sd q a/ω/5, so that the two numbers hold for q of 0 to 1.5.
    """
    return value / omega(ln_hertz) * (SHARE + SCATTER * chance)


@njit(cache=True)
def crept(value: float, ln_hertz: float, growth: float, until: float) -> tuple[float, float]:
    """Way [m] and mean speed [m/s] of the slips `until` [s] ≤ 0 before the mean pull, growing by `growth` [m/s³], is up to the
    friction: v = a/ω (1 − s)^2.5 with s = −`growth` `until`/a from 1 to 0 (within 0.02 a/ω of the slips' own mean)."""
    left = 1.0 + growth * until / value if value > 0.0 and growth > 0.0 else 0.0
    if left <= 0.0:
        return 0.0, 0.0
    speed = value / omega(ln_hertz) * left**2.5
    return speed * left * value / growth / 3.5, speed


@njit(cache=True)
def omega(ln_hertz: float) -> float:
    """[rad/s]."""
    return 2 * math.pi * HERTZ * math.exp(min(max(ln_hertz, -6.0), 6.0))


def amplitude(wave_mm: float, omega: float) -> float:
    """Of the acceleration [m/s²] that makes a freely sliding block ripple by `wave_mm` at ω [rad/s]: ω² x."""
    return 1e-3 * wave_mm * omega**2


EFFECT = Effect(
    name="plate-vibration", sector="sliding", unit="m/s^2", meaning="amplitude", prior_sd=0.5, low=0.0, high=20.0,
    source="stepper drives; the slips of a block on a shaken slope: stick while g sin θ + a sin ωt < μ g cos θ",
    twins=("kinetic-friction", "stribeck"),
    separating="the same slide with the plate raised by hand, the drive off",
)  # fmt: skip
FREQUENCY = Effect(
    name="plate-vibration.ln-hertz", sector="sliding", unit="1", meaning="ln of the frequency over 30 Hz", prior_sd=0.7,
    low=-3.0, high=3.0, source="motors, gears and steppers shake at 10 to 100 Hz", group="plate-vibration",
)  # fmt: skip
