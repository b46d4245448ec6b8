"""Corner loss: speed is lost at once where the incline ends, beyond what a corner takes from every seed.

The foot on the level is a new point of touch, and only the angular momentum about it is kept: of a seed that rolls round a sharp
corner of β it takes  (1 − cos β)/(1 + I/(m r²)),  0.024 of a ball's speed at 15°; a bounce changes nothing of that, rolling
friction under the blow adds to it, and a rounded corner takes nothing. This range belongs to the baseline.
"""

import math
from dataclasses import replace

from calibrate.diagnose.effects.effect import Effect

USUAL, USUAL_SD = 0.6, 0.5  # of a sharp corner's loss, in the baseline: from a rounded one (0) to one with friction (1.5)


def sharp(incline: float, inertia: float) -> float:
    """Share of the speed that a sharp corner of `incline` [rad] takes; inertia: 1 + I/(m r²)."""
    return (1 - math.cos(incline)) / inertia


def kept(value: float, usual: float = 0.0) -> float:
    """Share of the speed left behind the corner when `value` of it is lost beside the usual."""
    return 1 - usual - value


EFFECT = Effect(
    name="corner-loss", sector="onset", unit="1", meaning="lost fraction of speed", prior_sd=0.1, low=0.0, high=1.0,
    source="angular momentum about the new point of touch: (1 − cos β)/(1 + I/(m r²)), 0.024 for a ball at 15°",
    twins=("initial-slip",),
    separating="the same roll over a rounded corner, or on a gentler incline: the loss grows as the square of the angle",
)  # fmt: skip


def beside(usual: float) -> Effect:
    """The effect for a baseline that already loses `usual` of the speed; all that is lost is reported."""
    return replace(EFFECT, low=-usual, high=1 - usual, reported=lambda value: value + usual)
