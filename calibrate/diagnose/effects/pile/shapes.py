"""Where along a flank something shows, and what a law of heaps says.

u: share of the flank's way, 0 at the crest, 1 where its line meets the plate; changes of the surface in shares of its height.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from calibrate.diagnose.effects.effect import Effect

CREST_WIDTH, TOE_WIDTH = 0.2, 0.15
BENDS, BEND_WIDTH, BEND_SD = (0.05, 0.2, 0.35), 0.08, 0.04


def crest(u: np.ndarray) -> np.ndarray:
    """1 at the crest, gone a third of the way down: exp(−½ (u/0.2)²)."""
    return np.exp(-0.5 * (u / CREST_WIDTH) ** 2)


def toe(u: np.ndarray) -> np.ndarray:
    """1 at the toe, gone a third of the way up, and running out beyond: exp(−|u − 1|/0.15)."""
    return np.exp(-np.abs(u - 1) / TOE_WIDTH)


def middle(u: np.ndarray) -> np.ndarray:
    """A bow between crest and toe: 1 half way, 0 and level with the line at both ends: sin²(π u)."""
    return np.where((u > 0) & (u < 1), np.sin(np.pi * np.clip(u, 0, 1)) ** 2, 0.0)


def bends(effect: str, source: str, weight: Callable[[tuple], np.ndarray]) -> tuple[tuple[Effect, ...], dict[str, "Law"]]:
    """Further parameters by which the crest's shape may differ from `crest`: nobody knows the law that well."""
    effects, laws = [], {}
    for at in BENDS:
        name = f"{effect}.bend-{at:g}"
        effects.append(
            Effect(name, "crest", "1", f"crest's own shape at {at:.0%} of the way", BEND_SD, -1.0, 1.0, source, group=effect)
        )
        laws[name] = Law(surface=_bump(at), weight=weight)
    return tuple(effects), laws


def in_seeds(effect: str, sector: str, prior_sd: float, source: str, surface: Callable[[np.ndarray], np.ndarray]):
    """A further parameter: as much of the same as is fixed in seeds, not in shares of the heap (none where sizes do not differ).

    Small heaps depart from large ones in any way that is some seeds large: by that alone nothing is cohesion.
    """
    name = f"{effect}.size"
    more = Effect(name, sector, "1", "the same, in seeds", prior_sd, -1.0, 1.0, source, group=effect)
    return {name: more}, {name: Law(surface=surface, weight=as_stated(seed_mm=1.0, rig_mm=-1.0))}


def _bump(at: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda u: np.exp(-0.5 * ((u - at) / BEND_WIDTH) ** 2)


@dataclass(frozen=True)
class Law:
    """What one unit of a parameter does to a photo, times `weight`.

    surface(u) → (n,) added to the surface; angle_deg: added to every flank's angle; turn_deg, plate_deg: by how much flanks and
    plate turn clockwise, by what the photo's angles count from (flanks.Photo.reference); creep_deg: how much flatter a heap
    becomes from its first to its last photo. weight(photos) → (R,): how strongly it acts in each photo, 1 on average; all the
    same where nothing stated differs.
    """

    surface: Callable[[np.ndarray], np.ndarray] | None = None
    angle_deg: float = 0.0
    turn_deg: dict[str, float] | None = None
    plate_deg: float = 0.0
    creep_deg: float = 0.0
    weight: Callable[[tuple], np.ndarray] = lambda photos: np.ones(len(photos))


def as_stated(**powers: float) -> Callable[[tuple], np.ndarray]:
    """Weights in proportion to powers of stated quantities, each left out where a photo does not state it; 1 on average."""

    def weight(photos: tuple) -> np.ndarray:
        raised = np.ones(len(photos))
        for quantity, power in powers.items():
            values = np.array([getattr(p, quantity) for p in photos], dtype=float)
            if np.isfinite(values).all():
                raised = raised * values**power
        return raised / raised.mean()

    return weight
