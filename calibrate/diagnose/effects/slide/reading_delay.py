"""Reading delay: the angle is noted only when the block has visibly moved.

What is fitted is the third root of the travel: angles are linear in it, and it has a slope at nil.
"""

import math

from calibrate.diagnose.effects.effect import Effect

G_M_S2 = 9.80665


def overshoot_deg(root: float, rate_deg_s: float, onset_deg: float) -> float:
    """By how much the angle at a travel x of `root`³ [mm] exceeds the onset's: x = g Ω t³/(6 cos θ), so
    Ω t = (6 x cos θ Ω²/g)^⅓."""
    cube = 6e-3 * math.cos(math.radians(onset_deg)) * math.radians(rate_deg_s) ** 2 / G_M_S2
    return root * math.degrees(cube ** (1 / 3))


def travel_mm(root: float) -> float:
    """As it is reported."""
    return root**3


EFFECT = Effect(
    name="reading-delay", sector="measurement", unit="mm", meaning="travel at which the angle is read", prior_sd=1.3,
    low=0.0, high=4.0, source="third-power onset where μ_k = μ_s; an eye sees 0.1 to 10 mm", twins=("clock-offset",),
    separating="readings at a tenth and at ten times the tilt rate: overshoot grows as the rate to the 2/3; a clock's: 1",
    reported=travel_mm,
)  # fmt: skip
