"""Stribeck: friction falls smoothly with sliding speed."""

import math

from numba import njit

from calibrate.diagnose.effects.effect import Effect

SPEED_M_S = 0.05  # typical; a block slides at 0 to 0.5 m/s


@njit(cache=True)
def friction(speed: float, value: float, ln_scale: float, shape: float) -> float:
    """Δμ = `value` exp(−(v/v_s)^n) [-], v_s = SPEED e^ln_scale [m/s], n = e^shape.

    ln_scale within ±6, shape within ±3 [-]: far outside what a candidate may be, so that a fit meets no edge."""
    if value == 0.0:
        return 0.0
    ratio = abs(speed) / (SPEED_M_S * math.exp(min(max(ln_scale, -6.0), 6.0)))
    return value * math.exp(-(ratio ** math.exp(min(max(shape, -3.0), 3.0))))


EFFECT = Effect(
    name="stribeck", sector="sliding", unit="1", meaning="mu at rest - mu at high speed", prior_sd=0.08, low=0.0, high=0.5,
    source="Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), Automatica 30, 1083",
    twins=("kinetic-friction", "viscous-sliding"),
    separating="the same slide at a tenth of the tilt rate: speeds between rest and a few cm/s",
)  # fmt: skip
SPEED = Effect(
    name="stribeck.ln-speed", sector="sliding", unit="1", meaning="ln of the speed scale over 0.05 m/s", prior_sd=0.8, low=-3.0,
    high=3.0, source="scales of 0.01 to 0.25 m/s show within a slide", group="stribeck",
)  # fmt: skip
SHAPE = Effect(
    name="stribeck.shape", sector="sliding", unit="1", meaning="ln of the exponent", prior_sd=0.4, low=-1.0, high=1.0,
    source="exponents of 0.5 to 2 are in use; 1 (Bo & Pavelescu 1982, Wear 82, 277) is the DEM's", group="stribeck",
)  # fmt: skip
