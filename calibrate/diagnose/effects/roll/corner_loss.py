"""Corner loss: speed is lost at once where the incline ends, beyond what a corner takes from every seed.

The foot on the level is a new point of touch, and only the angular momentum about it is kept: of a seed that rolls round a sharp
corner of β it takes  (1 − cos β)/(1 + I/(m r²)),  0.024 of a ball's speed at 15°; a bounce changes nothing of that, rolling
friction μ under the blow, of impulse m v sin β, adds  μ sin β/(1 + I/(m r²)),  and a rounded corner takes nothing. This range
belongs to the baseline.
"""

import math

from scipy.special import ndtr

from calibrate.diagnose.effects.effect import Effect


def sharp(incline: float, inertia: float) -> float:
    """Share of the speed that a sharp corner of `incline` [rad] takes; inertia: 1 + I/(m r²)."""
    return (1 - math.cos(incline)) / inertia


def most(incline: float, inertia: float, rolling: float) -> float:
    """Share of the speed that a corner takes at most by itself; rolling: friction."""
    return sharp(incline, inertia) + rolling * math.sin(incline) / inertia


def usual(most: float, rank: float) -> float:
    """Share of the speed that a corner takes, anything from nil to `most` as likely; rank: standard normal."""
    return most * float(ndtr(rank))


def kept(value: float, usual: float = 0.0) -> float:
    """Share of the speed left behind the corner when `value` of it is lost beside the usual."""
    return 1 - usual - value


EFFECT = Effect(
    name="corner-loss", sector="onset", unit="1", meaning="lost fraction of speed", prior_sd=0.1, low=0.0, high=1.0,
    source="angular momentum about the new point of touch: (1 − cos β)/(1 + I/(m r²)), 0.024 for a ball at 15°",
    twins=("initial-slip",),
    separating="the same roll over a rounded corner, or on a gentler incline: the loss grows as the square of the angle",
)  # fmt: skip
