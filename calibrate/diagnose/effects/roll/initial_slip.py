"""Initial slip: the seed slides before it rolls, and reaches the level faster than its spin.

While slip lasts friction takes speed and gives spin; with slip speed u, angular momentum about the point of touch leaves
a rolling seed slower by u (1 − 1/c), c = 1 + I/(m r²) (u/3.5 of a ball). On the incline a seed that gains slip in proportion to
speed, u = s v, turns by (1 − s) v/r only, and so speeds up by c/(1 + (c − 1)(1 − s)) of rolling.
"""

import math

from calibrate.diagnose.effects.effect import Effect

DURATION_S = 0.025  # of slipping on the level
DURATION_SPREAD = 1.0  # ln: 9 to 68 ms; what slips longer has next to no friction, shorter is a loss in the corner


def duration(value: float) -> float:
    """[s] for ln of the duration over 25 ms, which levels off at its ends."""
    return DURATION_S * math.exp(DURATION_SPREAD * math.tanh(value / DURATION_SPREAD))


def speed_lost(value: float, inertia: float) -> float:
    """[m/s] for the slip speed `value` [m/s] and inertia c."""
    return value * (1 - 1 / inertia)


def incline_gain(value: float, share: float, speed: float, inertia: float) -> float:
    """Acceleration on the incline over that of rolling, for slip that has grown there to `value` of `speed` at its end; share:
    ½ + `share` of this slip came about on the incline, the rest in the corner."""
    slip = min(max(value / max(speed, 1e-6), -0.5), 1.0)
    full = inertia / (1 + (inertia - 1) * (1 - slip))
    return 1 + (0.5 + share) * (full - 1)


EFFECT = Effect(
    name="initial-slip", sector="onset", unit="m/s", meaning="slip speed where the incline ends", prior_sd=0.07, low=0.0,
    high=3.0, source="Coulomb friction on a rolling ball; u = 5u0/7 at the end of slip", twins=("corner-loss",),
    separating="the same roll filmed so that the seed's turning is seen: a seed that slips turns too slowly",
)  # fmt: skip
DURATION = Effect(
    name="initial-slip.duration", sector="onset", unit="1", meaning="ln of the time it slips over 25 ms", prior_sd=0.7, low=-3.0,
    high=3.0, source="10 to 60 ms at friction of seeds on plates", group="initial-slip",
)  # fmt: skip
INCLINE = Effect(
    name="initial-slip.incline", sector="onset", unit="1", meaning="share of the slip from the incline, less 1/2", prior_sd=0.5,
    low=-1.0, high=1.0, source="a corner may make a seed slip too", group="initial-slip",
)  # fmt: skip
