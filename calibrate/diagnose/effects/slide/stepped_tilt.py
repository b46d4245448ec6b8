"""Stepped tilt: the plate is raised in steps, or its angle read on a grid and rounded up."""

import math

from numba import njit

from calibrate.diagnose.effects.effect import Effect


@njit(cache=True)
def raised(tilt: float, value: float, phase: float) -> float:
    """The stair at or below `tilt`: stairs of height `value` at phase + k `value`, all in one unit."""
    return phase + value * math.floor((tilt - phase) / value)


EFFECT = Effect(
    name="stepped-tilt", sector="measurement", unit="deg", meaning="step", prior_sd=0.5, low=0.0, high=10.0,
    source="ratchets, protractors", twins=("reading-delay",),
    separating="the same slide with the plate raised without a stop, its angle recorded to a hundredth of a degree",
)  # fmt: skip
