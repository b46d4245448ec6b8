"""Candidates of the pile, by name, and their laws."""

from calibrate.diagnose.effects.effect import Effect
from calibrate.diagnose.effects.pile import (
    base_tilt,
    base_vibration,
    camera_roll,
    cohesion,
    gate_speed,
    kink,
    particle_shape,
    wall_friction,
)
from calibrate.diagnose.effects.pile.shapes import Law

_FOUND = (
    cohesion.EFFECT, cohesion.TOE, cohesion.ANGLE, gate_speed.EFFECT, gate_speed.TOE, gate_speed.ANGLE, base_vibration.EFFECT,
    base_vibration.TOE, base_vibration.ANGLE, wall_friction.EFFECT, wall_friction.ANGLE, particle_shape.EFFECT,
    base_tilt.EFFECT, camera_roll.EFFECT, *cohesion.BENDS, *gate_speed.BENDS, *base_vibration.BENDS,
)  # fmt: skip
EFFECTS: dict[str, Effect] = {effect.name: effect for effect in _FOUND}
RIVALS: dict[str, Effect] = kink.EFFECTS  # outside the list: what they explain better is unknown
_MODULES = (cohesion, gate_speed, base_vibration, wall_friction, particle_shape, base_tilt, camera_roll, kink)
LAWS: dict[str, Law] = {name: law for module in _MODULES for name, law in module.LAWS.items()}
