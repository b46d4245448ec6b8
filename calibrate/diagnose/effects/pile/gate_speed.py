"""Gate speed: a gate that moved faster than stated lets the seeds fall and run: round crest, long toe."""

from calibrate.diagnose.effects.effect import Effect
from calibrate.diagnose.effects.pile.shapes import Law, as_stated, bends, crest, toe

_SPEED = as_stated(gate_speed_mm_s=1.0, rig_mm=-0.5)
_NEXT = "the same heap at half and at twice the gate speed: what the gate does grows with it, shaking does not"
_SOURCE = "a wheat heap: 10, 25, 50 mm/s left 18.4°, 12.3°, 10.4°; over a fall's speed √(gH)"

EFFECT = Effect(
    name="gate-speed", sector="crest", unit="1", meaning="crest below a usual one over the heap's height", prior_sd=0.15, low=0.0,
    high=0.8, source=_SOURCE, twins=("base-vibration",), separating=_NEXT,
)  # fmt: skip
TOE = Effect("gate-speed.toe", "toe", "1", "toe above a usual one", 0.10, 0.0, 0.6, _SOURCE, group="gate-speed")
ANGLE = Effect("gate-speed.angle", "crest", "deg", "flatter", 6.0, 0.0, 40.0, _SOURCE, group="gate-speed")
BENDS, _BENT = bends("gate-speed", _SOURCE, _SPEED)
LAWS = {
    "gate-speed": Law(surface=lambda u: -crest(u), weight=_SPEED),
    "gate-speed.toe": Law(surface=toe, weight=_SPEED),
    "gate-speed.angle": Law(angle_deg=-1.0, weight=_SPEED),
} | _BENT
