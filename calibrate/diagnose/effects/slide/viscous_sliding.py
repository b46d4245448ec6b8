"""Viscous sliding: friction grows with speed."""

from numba import njit

from calibrate.diagnose.effects.effect import Effect


@njit(cache=True)
def friction(speed: float, value: float) -> float:
    """Δμ = `value` v [-], `value` in s/m."""
    return value * speed


EFFECT = Effect(
    name="viscous-sliding", sector="sliding", unit="s/m", meaning="slope of mu on speed", prior_sd=0.15, low=0.0, high=3.0,
    source="wet or waxy seed coats; Armstrong-Hélouvry et al. (1994)", twins=("stribeck", "angle-offset"),
    separating="the same slide at three times the tilt rate: higher speeds at the same places",
)  # fmt: skip
