"""Candidates of the roll, by name; each file holds the law that acts along the path."""

from calibrate.diagnose.effects.effect import Effect
from calibrate.diagnose.effects.roll import corner_loss, drag, initial_slip, shape_barrier, slope, viscous_rolling

_FOUND = (
    viscous_rolling.EFFECT, drag.EFFECT, drag.EXPONENT, slope.EFFECT, initial_slip.EFFECT, initial_slip.DURATION,
    initial_slip.INCLINE, corner_loss.EFFECT, shape_barrier.EFFECT,
)  # fmt: skip
EFFECTS: dict[str, Effect] = {effect.name: effect for effect in _FOUND}
