"""Plate tilt: the plate is not level in the picture plane, and kicks every seed to the same side."""

import numpy as np

from calibrate.diagnose.effects.effect import Effect, Hits


def kick(hits: Hits, value: float) -> np.ndarray:
    """Δv_x/Δv_n = α lever, α = `value` [deg] positive where the plate falls towards +x; without friction Δv_x = (1 + e) v α."""
    return np.radians(value) * hits.lever


def restitution(hits: Hits, e: np.ndarray, value: float) -> np.ndarray:
    """e − tan α (v_x' + e v_x)/v: what runs down the plate strikes it more gently than it falls, and leaves it less steeply."""
    return e - np.tan(np.radians(value)) * (hits.drift[1] + e * hits.drift[0])


EFFECT = Effect(
    name="plate-tilt", sector="impact", unit="deg", meaning="tilt", prior_sd=1.0, low=-15.0, high=15.0,
    source="reflection about the plate's normal", separating="a spirit level on the plate; the plate turned round by half a turn",
    kick=kick, restitution=restitution,
)  # fmt: skip
