"""Kinetic friction: less friction in motion than at rest."""

from numba import njit

from calibrate.diagnose.effects.effect import Effect


@njit(cache=True)
def at_rest(friction: float, value: float) -> float:
    """μ_s = μ_k + `value` [-]."""
    return friction + value


EFFECT = Effect(
    name="kinetic-friction", sector="onset", unit="1", meaning="mu_static - mu_kinetic", prior_sd=0.08, low=0.0, high=0.5,
    source="Coulomb (1785); seeds on steel lose 5 to 30 % of their friction once they slide: Mohsenin (1986)",
    twins=("stribeck",), separating="the same slide at a tenth of the tilt rate and at a higher frame rate: the first millimetre",
)  # fmt: skip
