"""Partial rolling: part of the motion goes into turning."""

from numba import njit

from calibrate.diagnose.effects.effect import Effect


@njit(cache=True)
def share(value: float) -> float:
    """Of the acceleration that is left where inertia over mass is `value` [-]: 1/(1 + value); 5/7 for a rolling ball."""
    return 1.0 / max(1.0 + value, 0.05)


EFFECT = Effect(
    name="partial-rolling", sector="sliding", unit="1", meaning="added inertia over mass", prior_sd=0.2, low=0.0, high=1.0,
    source="a seed that comes loose rolls: I/mr² = 2/5 of a ball",
    twins=("angle-offset", "clock-offset", "adhesion", "viscous-sliding"),
    separating="the same block filmed from the side with a mark on it, and a ruler in the picture: turning against scale",
)  # fmt: skip
