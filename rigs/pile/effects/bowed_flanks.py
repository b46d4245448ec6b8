"""Bowed flanks: side walls hold seeds back, and grains of another shape interlock or
roll."""

from collections.abc import Callable

import numpy as np

from benchtwin.infer.effect import Counterpart
from benchtwin.rigs.pile.effects.shapes import (
    HeapEffect,
    Law,
    as_stated,
    bends,
    beyond_plain,
    crest,
    ends,
    further,
    middle,
    toe,
)

_WIDTH = as_stated(width_mm=-1.0)
_SEEDS = (
    "middle",
    "1",
    "a bow some seeds high",
    0.1,
    Law(surface=middle, weight=as_stated(seed_mm=1.0, rig_mm=-1.0)),
)
_WALLS = "tan θ = tan θ₀ + μ_w h/W; Taberlet et al. 2003, Phys. Rev. Lett. 91, 264301"
_GRAINS = (
    "one sphere or a clump of three: a heap of 25° or 37°; no photo of a heap tells it"
    " from friction"
)
_FRICTION = "a heap's angle is what friction and rolling friction of its seeds set"


def _walled(
    seed: dict, pile: dict, stated: dict, strength: float
) -> tuple[dict, dict, dict]:
    """The whole box with its own sides, instead of a slice between smooth ones."""
    if strength == 0:
        return seed, pile, {}
    if "channel_mm" in stated:
        raise ValueError("the twin of a channel has its walls already")
    width, (x, _, z) = stated["box_mm"][1], pile["box_mm"]
    box = {
        "slab": False,
        "box_mm": [x, width, z],
        "gate_mm": [width, pile["gate_mm"][1]],
    }
    return seed, pile | box | {"plate_mm": [pile["plate_mm"][0], 3 * width]}, {}


def _longer(
    seed: dict, pile: dict, stated: dict, strength: float
) -> tuple[dict, dict, dict]:
    """Seeds longer by that share, at equal volume."""
    longer, thinner = 1 + strength, (1 + strength) ** -0.5
    factors = {"length_mm": longer, "width_mm": thinner, "thickness_mm": thinner}
    return seed | {n: f * seed[n] for n, f in factors.items()}, pile, {}


def _loose(
    name: str, source: str, weight: Callable[[tuple], np.ndarray]
) -> tuple[HeapEffect, ...]:
    """Crest and toe that go with a bow, of unknown size."""
    crests, toes = Law(surface=crest, weight=weight), Law(surface=toe, weight=weight)
    more = further(
        name,
        source,
        size=_SEEDS,
        crest=("crest", "1", "crest above a usual one", 0.15, crests),
        toe=("toe", "1", "toe above a usual one", 0.10, toes),
    )
    return (*more, *bends(name, source, weight))


EFFECTS = (
    HeapEffect(
        name="wall-friction",
        of_seeds=True,
        sector="middle",
        unit="1",
        meaning="bow of the flank over the heap's height",
        prior_sd=0.1,
        low=-0.4,
        high=0.4,
        source=_WALLS,
        wording=(
            "friction of the side walls is missing",
            "of the heap's height as a bow",
        ),
        separating=(
            "the same heap in a box twice as wide: what the side walls carry goes as"
            " 1/width"
        ),
        counterpart=Counterpart(
            "the box has its own sides, with friction, in place of smooth ones"
        ),
        law=Law(surface=middle, weight=_WIDTH, twin=_walled, stepless=False),
    ),
    *_loose("wall-friction", _WALLS, _WIDTH),
    *further(
        "wall-friction",
        _WALLS,
        angle=("middle", "deg", "steeper", 6.0, Law(angle_deg=1.0, weight=_WIDTH)),
    ),
    HeapEffect(
        name="particle-shape",
        of_seeds=True,
        sector="middle",
        unit="1",
        meaning="bow of the flank over the heap's height",
        prior_sd=0.1,
        low=-0.4,
        high=0.4,
        source=_GRAINS,
        wording=(
            "the seeds' shape is not as simulated",
            "of the heap's height as a bow",
        ),
        separating=(
            "the seeds' own dimensions from a photo of spread seeds, and their friction"
            " from the slide: no heap can"
        ),
        counterpart=Counterpart(
            "seeds are longer by {value} of their length, at the same volume"
        ),
        law=Law(surface=middle, twin=_longer, most=lambda seeds_high: 0.35),
    ),
    *_loose("particle-shape", _GRAINS, as_stated()),
    *further(
        "particle-shape",
        _GRAINS,
        angle=(
            "middle",
            "deg",
            "steeper",
            6.0,
            Law(angle_deg=1.0, weight=beyond_plain),
        ),
    ),
    HeapEffect(
        name="seed-friction",
        of_seeds=True,
        sector="middle",
        unit="deg",
        meaning="steeper than heaps of plain seeds",
        prior_sd=6.0,
        low=-40.0,
        high=40.0,
        source=_FRICTION,
        wording=(
            "friction or rolling friction between seeds is not that of the plain ones",
            "° steeper",
        ),
        separating="slides and rolls of these seeds on a plate of seeds: no heap can",
        not_simulated="the twin of every heap has the friction that fits its angle",
        law=Law(angle_deg=1.0, weight=beyond_plain),
    ),
    *ends("seed-friction", _FRICTION, beyond_plain),
)
