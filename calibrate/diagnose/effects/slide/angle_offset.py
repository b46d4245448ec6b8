"""Angle offset: the tilt sensor reads off by a constant."""

from calibrate.diagnose.effects.effect import Effect


def true_tilt_deg(tilt_deg: float, value: float) -> float:
    """θ = recorded − `value` [deg]."""
    return tilt_deg - value


EFFECT = Effect(
    name="angle-offset", sector="measurement", unit="deg", meaning="recorded - true tilt", prior_sd=2.0, low=-15.0, high=15.0,
    source="after the onset a = g sin(θ − θ₀)/cos θ₀: only cos θ₀ remembers the angle itself",
    twins=("clock-offset", "adhesion", "partial-rolling", "viscous-sliding"),
    separating="a reading of the tilt sensor on the plate levelled with a spirit level, and a second tilt rate",
)  # fmt: skip
