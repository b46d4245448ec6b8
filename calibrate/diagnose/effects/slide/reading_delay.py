"""Reading delay: the angle is noted only when the block has visibly moved."""

import math

from calibrate.diagnose.effects.effect import Effect

G_M_S2 = 9.80665


def overshoot_deg(value: float, rate_deg_s: float, onset_deg: float) -> float:
    """By how much the angle at a travel of `value` [mm] exceeds the onset's: x = g Ω t³/(6 cos θ), so
    Ω t = (6 x cos θ Ω²/g)^⅓."""
    rate = math.radians(rate_deg_s)
    cube = 6e-3 * abs(value) * math.cos(math.radians(onset_deg)) * rate**2 / G_M_S2
    return math.copysign(math.degrees(cube ** (1 / 3)), value)


EFFECT = Effect(
    name="reading-delay", sector="measurement", unit="mm", meaning="travel at which the angle is read", prior_sd=4.0,
    low=0.0, high=60.0, source="third-power onset where μ_k = μ_s", twins=("clock-offset",),
    separating="readings at a tenth and at ten times the tilt rate: overshoot grows as the rate to the 2/3; a clock's: 1",
)  # fmt: skip
