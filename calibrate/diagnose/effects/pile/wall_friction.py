"""Wall friction: side walls hold seeds back: the flank is bowed in the middle, and steeper the narrower the box."""

from calibrate.diagnose.effects.effect import Effect
from calibrate.diagnose.effects.pile.shapes import Law, as_stated, in_seeds, middle

_WIDTH = as_stated(width_mm=-1.0)
_NEXT = "the same heap in a box twice as wide: what the side walls carry goes as 1/width"
_SOURCE = "tan θ = tan θ₀ + μ_w h/W; Taberlet et al. 2003, Phys. Rev. Lett. 91, 264301"

EFFECT = Effect(
    name="wall-friction", sector="middle", unit="1", meaning="bow of the flank over the heap's height", prior_sd=0.06, low=-0.4,
    high=0.4, source=_SOURCE, twins=("particle-shape",), separating=_NEXT,
)  # fmt: skip
ANGLE = Effect("wall-friction.angle", "middle", "deg", "steeper", 6.0, 0.0, 40.0, _SOURCE, group="wall-friction")
SIZE, _LAWS = in_seeds("wall-friction", "middle", 0.06, "a bow some seeds high", middle)
LAWS = {
    "wall-friction": Law(surface=middle, weight=_WIDTH),
    "wall-friction.angle": Law(angle_deg=1.0, weight=_WIDTH),
} | _LAWS
