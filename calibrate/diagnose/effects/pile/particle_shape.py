"""Particle shape: grains less round than stated lock: the flank is bowed, and steeper as with more friction."""

from calibrate.diagnose.effects.effect import Effect
from calibrate.diagnose.effects.pile.shapes import Law, in_seeds, middle

EFFECT = Effect(
    name="particle-shape", sector="middle", unit="1", meaning="bow of the flank over the heap's height", prior_sd=0.06, low=-0.4,
    high=0.4, source="one sphere or a clump of three: a heap of 25° or 37°; no photo of a heap tells it from friction",
    twins=("wall-friction", "cohesion"),
    separating="the seeds' own dimensions from a photo of spread seeds, and their friction from the slide: no heap can",
)  # fmt: skip
SIZE, _LAWS = in_seeds("particle-shape", "middle", 0.06, "a bow some seeds high", middle)
LAWS = {"particle-shape": Law(surface=middle)} | _LAWS
