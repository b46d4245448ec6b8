"""Base vibration: a base that shook makes the heap creep: round crest, long toe, and flatter with time.

Where one heap was photographed in turn, in one view, it is told by what goes on between its photos: that is its first parameter
then, and how it looks on the whole comes after.
"""

from calibrate.diagnose.effects.effect import Effect
from calibrate.diagnose.effects.pile.shapes import Law, as_stated, bends, crest, toe

_TIME = as_stated(photo_s=1.0)
_NEXT = "two photos of one heap a minute apart, photo_s stated: what shakes goes on, what the gate did is over"
_SOURCE = "creep of a shaken heap; its height shrinks with time"

EFFECT = Effect(
    name="base-vibration", sector="crest", unit="1", meaning="crest below a usual one over the heap's height", prior_sd=0.15,
    low=0.0, high=0.8, source=_SOURCE, twins=("gate-speed",), separating=_NEXT,
)  # fmt: skip
TOE = Effect("base-vibration.toe", "toe", "1", "toe above a usual one", 0.10, 0.0, 0.6, _SOURCE, group="base-vibration")
ANGLE = Effect("base-vibration.angle", "crest", "deg", "flatter", 6.0, 0.0, 40.0, _SOURCE, group="base-vibration")
GOES_ON = Effect(
    name="base-vibration", sector="crest", unit="deg", meaning="flatter in the last photo of a heap than in its first",
    prior_sd=3.0, low=0.0, high=40.0, source=_SOURCE, separating=_NEXT,
)  # fmt: skip
CREST = Effect("base-vibration.crest", "crest", "1", EFFECT.meaning, 0.15, 0.0, 0.8, _SOURCE, group="base-vibration")
BENDS, _BENT = bends("base-vibration", _SOURCE, _TIME)
LAWS = {
    "base-vibration": Law(surface=lambda u: -crest(u), weight=_TIME),
    "base-vibration.toe": Law(surface=toe, weight=_TIME),
    "base-vibration.angle": Law(angle_deg=-1.0, weight=_TIME),
} | _BENT
LAWS_IN_TURN = {"base-vibration": Law(creep_deg=1.0), "base-vibration.crest": LAWS["base-vibration"]}
