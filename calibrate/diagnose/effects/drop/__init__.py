"""Candidates of the drop that act in flight and in the picture, by name; those of the impact are in impact.py."""

from calibrate.diagnose.effects.drop import (
    camera_roll,
    clock_error,
    drag,
    draught,
    magnus,
    perspective,
    scale_error,
    silhouette_wobble,
)
from calibrate.diagnose.effects.effect import Effect

_FOUND = (
    drag.EFFECT, magnus.EFFECT, draught.EFFECT, scale_error.EFFECT, clock_error.EFFECT, camera_roll.EFFECT, perspective.EFFECT,
    perspective.WHERE, silhouette_wobble.EFFECT, silhouette_wobble.OTHER_PHASE,
)  # fmt: skip
EFFECTS: dict[str, Effect] = {effect.name: effect for effect in _FOUND}
