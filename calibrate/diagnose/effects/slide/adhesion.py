"""Adhesion: a constant pull towards the plate on top of the weight."""

from numba import njit

from calibrate.diagnose.effects.effect import Effect


@njit(cache=True)
def press(value: float, mass_g: float) -> float:
    """Normal force over mass that the pull adds [m/s²]: `value` [mN] / mass of the whole block [g]."""
    return value / mass_g


EFFECT = Effect(
    name="adhesion", sector="onset", unit="mN", meaning="pull", prior_sd=1.5, low=0.0, high=30.0,
    source="tan θ_s = μ + μ F/(m g cos θ): the offset goes as 1/load", twins=("angle-offset", "clock-offset", "viscous-sliding"),
    separating="the same slide with one seed and with eight seeds taped together: a pull counts for less the heavier the block",
)  # fmt: skip
