"""Candidates of the slide, by name."""

from calibrate.diagnose.effects.effect import Effect
from calibrate.diagnose.effects.slide import (
    adhesion,
    angle_offset,
    clock_offset,
    kinetic_friction,
    partial_rolling,
    plate_vibration,
    reading_delay,
    stepped_tilt,
    stribeck,
    viscous_sliding,
)

_FOUND = (
    kinetic_friction.EFFECT, stribeck.EFFECT, stribeck.SPEED, stribeck.SHAPE, viscous_sliding.EFFECT, adhesion.EFFECT,
    reading_delay.EFFECT, clock_offset.EFFECT, angle_offset.EFFECT, plate_vibration.EFFECT, plate_vibration.FREQUENCY,
    partial_rolling.EFFECT, stepped_tilt.EFFECT,
)  # fmt: skip
EFFECTS: dict[str, Effect] = {effect.name: effect for effect in _FOUND}
