"""Cohesion: grains stick, so that crest and toe stand steeper; in proportion to (pull over weight) over the heap in seeds."""

from calibrate.diagnose.effects.effect import Effect
from calibrate.diagnose.effects.pile.shapes import Law, as_stated, bends, crest, toe

_SIZE = as_stated(seed_mm=-1.0, rig_mm=-1.0)
_NEXT = "the same of seeds, or in a heap, half and twice as large: cohesion counts for more the smaller they are"
_SOURCE = "a film's pull ∝ d, a seed's weight ∝ d³: the stress it holds ∝ 1/d, over that of a heap's weight ∝ 1/(d H)"

EFFECT = Effect(
    name="cohesion", sector="crest", unit="1", meaning="crest above a usual one over the heap's height", prior_sd=0.15, low=0.0,
    high=0.6, source=_SOURCE, twins=("particle-shape",), separating=_NEXT,
)  # fmt: skip
TOE = Effect("cohesion.toe", "toe", "1", "toe below a usual one", 0.10, 0.0, 0.4, _SOURCE, group="cohesion")
ANGLE = Effect("cohesion.angle", "crest", "deg", "steeper", 6.0, 0.0, 40.0, _SOURCE, group="cohesion")
BENDS, _BENT = bends("cohesion", _SOURCE, _SIZE)
LAWS = {
    "cohesion": Law(surface=crest, weight=_SIZE),
    "cohesion.toe": Law(surface=lambda u: -toe(u), weight=_SIZE),
    "cohesion.angle": Law(angle_deg=1.0, weight=_SIZE),
} | _BENT
