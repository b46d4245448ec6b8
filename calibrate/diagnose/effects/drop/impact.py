"""Candidates of the drop that act in impacts, by name."""

from calibrate.diagnose.effects.drop import (
    film_adhesion,
    impact_damage,
    plastic_restitution,
    plate_compliance,
    plate_tilt,
    restitution_falls_with_speed,
    viscoelastic_restitution,
)
from calibrate.diagnose.effects.effect import Effect

_FOUND = (
    plate_tilt.EFFECT, restitution_falls_with_speed.EFFECT, viscoelastic_restitution.EFFECT, plastic_restitution.EFFECT,
    plate_compliance.EFFECT, film_adhesion.EFFECT, impact_damage.EFFECT,
    restitution_falls_with_speed.CURVATURE,
)  # fmt: skip
IMPACT_EFFECTS: dict[str, Effect] = {effect.name: effect for effect in _FOUND}
FALLING = tuple(e.name for e in _FOUND[1:5])  # laws of e that a seed hardly tells apart; the first is the class's name
