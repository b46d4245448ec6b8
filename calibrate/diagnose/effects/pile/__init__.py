"""Candidates of the pile, by name, and their laws."""

import numpy as np

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

ALIKE = 0.05  # weights that differ by no more say nothing of a condition

_FOUND = (
    cohesion.EFFECT, cohesion.TOE, cohesion.ANGLE, gate_speed.EFFECT, gate_speed.TOE, gate_speed.ANGLE, base_vibration.EFFECT,
    base_vibration.TOE, base_vibration.ANGLE, wall_friction.EFFECT, wall_friction.ANGLE, particle_shape.EFFECT,
    base_tilt.EFFECT, camera_roll.EFFECT, *cohesion.BENDS, *gate_speed.BENDS, *base_vibration.BENDS,
)  # fmt: skip
EFFECTS: dict[str, Effect] = {effect.name: effect for effect in _FOUND} | wall_friction.SIZE | particle_shape.SIZE
RIVALS: dict[str, Effect] = kink.EFFECTS  # outside the list: what they explain better is unknown
_MODULES = (cohesion, gate_speed, base_vibration, wall_friction, particle_shape, base_tilt, camera_roll, kink)
LAWS: dict[str, Law] = {name: law for module in _MODULES for name, law in module.LAWS.items()}


def candidates(photos: tuple) -> tuple[dict[str, Effect], dict[str, Law]]:
    """Those that these photos (diagnose.pile.flanks.Photo) can show, rivals included, and their laws.

    Angles, and sizes, tell of an effect only where a stated condition of its law differs.
    """
    effects, laws = EFFECTS | RIVALS, dict(LAWS)
    if any(np.isfinite(p.creep_deg) for p in photos):
        effects |= {e.name: e for e in (base_vibration.GOES_ON, base_vibration.CREST)}
        laws |= base_vibration.LAWS_IN_TURN
    seen = {n: e for n, e in effects.items() if not n.endswith((".angle", ".size")) or np.ptp(laws[n].weight(photos)) > ALIKE}
    return seen, laws
