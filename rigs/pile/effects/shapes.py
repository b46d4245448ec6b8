"""Shapes along a flank, and laws of heaps; u: share of the flank's way, 0 at the
crest."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from benchtwin.infer.effect import Effect

CREST_WIDTH, TOE_WIDTH = 0.2, 0.15
# sds by which a crest may depart from `crest`
BENDS = (0.0, 0.1, 0.2, 0.3, 0.4)
BEND_WIDTH = 0.08
BEND_SD = 0.04


def crest(u: np.ndarray) -> np.ndarray:
    """1 at the crest, 0 a third of the way down: exp(−½ (u/0.2)²)."""
    return np.exp(-0.5 * (u / CREST_WIDTH) ** 2)


def toe(u: np.ndarray) -> np.ndarray:
    """1 at the toe, 0 a third of the way up or beyond: exp(−|u − 1|/0.15)."""
    return np.exp(-np.abs(u - 1) / TOE_WIDTH)


def middle(u: np.ndarray) -> np.ndarray:
    """A bow: 1 half way, 0 at both ends: sin²(π u)."""
    return np.where((u > 0) & (u < 1), np.sin(np.pi * np.clip(u, 0, 1)) ** 2, 0.0)


@dataclass(frozen=True)
class Law:
    """Change of a Photo (rigs.pile.flanks) by one unit of a parameter, times `weight`.

    twin(seed, pile, stated pile, strength) → (seed, pile, laws) of a simulated heap.
    """

    # (u) → (n,) in shares of the height
    surface: Callable[[np.ndarray], np.ndarray] | None = None
    angle_deg: float = 0.0  # of every flank
    # of flanks by Photo.reference
    turn_deg: dict[str, float] = field(default_factory=dict)
    # after the heap was poured
    turn_after_deg: dict[str, float] = field(default_factory=dict)
    plate_deg: float = 0.0  # clockwise, of the plate
    creep_deg: float = 0.0  # flattening from first to last photo
    weight: Callable[[tuple], np.ndarray] = lambda photos: np.ones(len(photos))  # (R,)
    known_deg: Callable[[tuple], float] | None = None  # (photos) → sd on a good bench
    twin: Callable[[dict, dict, dict, float], tuple[dict, dict, dict]] | None = None
    # strength up to which heaps are simulated, of a filling so many seeds high
    most: Callable[[float], float] = lambda seeds_high: 1.0
    stepless: bool = True  # or there or not


@dataclass(frozen=True)
class HeapEffect(Effect):
    """An effect of heaps, described by a Law; of_seeds: heaps of plain seeds do not
    show it."""

    law: Law = field(default_factory=Law)
    of_seeds: bool = False


def as_stated(**powers: float) -> Callable[[tuple], np.ndarray]:
    """Weights ∝ powers of stated quantities, those not stated left out; 1 on
    average."""

    def weight(photos: tuple) -> np.ndarray:
        raised = np.ones(len(photos))
        for quantity, power in powers.items():
            values = np.array([getattr(p, quantity) for p in photos], dtype=float)
            if np.isfinite(values).all():
                raised = raised * values**power
        return raised / raised.mean()

    return weight


def beyond_plain(photos: tuple) -> np.ndarray:
    """1 where some of the photos show plain seeds, else 0: all heaps' own angle is
    open."""
    return np.full(len(photos), float(any(p.plain for p in photos)))


def further(
    effect: str, source: str, **of: tuple[str, str, str, float, Law]
) -> tuple[HeapEffect, ...]:
    """Further parameters of an effect, each (sector, unit, meaning, prior sd, law)."""
    return tuple(
        HeapEffect(
            f"{effect}.{name}",
            sector,
            unit,
            meaning,
            sd,
            -np.inf,
            np.inf,
            source,
            group=effect,
            law=law,
        )
        for name, (sector, unit, meaning, sd, law) in of.items()
    )


def bends(
    effect: str, source: str, weight: Callable[[tuple], np.ndarray]
) -> tuple[HeapEffect, ...]:
    """The crest's own shape, as bumps at BENDS of the way."""

    def bump(at: float) -> Callable[[np.ndarray], np.ndarray]:
        return lambda u: np.exp(-0.5 * ((u - at) / BEND_WIDTH) ** 2)

    said = "crest's own shape at {:.0%} of the way"
    laws = {at: Law(surface=bump(at), weight=weight) for at in BENDS}
    bumps = {
        f"bend-{at:g}": ("crest", "1", said.format(at), BEND_SD, law)
        for at, law in laws.items()
    }
    return further(effect, source, **bumps)


def ends(
    effect: str, source: str, weight: Callable[[tuple], np.ndarray]
) -> tuple[HeapEffect, ...]:
    """How crest and toe of steeper heaps depart from those of usual ones as steep: by
    some hundredths, as simulated films between seeds have it."""
    tops, feet = (Law(surface=part, weight=weight) for part in (crest, toe))
    more = further(
        effect,
        source,
        crest=("crest", "1", "crest above a usual one", 0.06, tops),
        toe=("toe", "1", "toe above a usual one", 0.05, feet),
    )
    return (*more, *bends(effect, source, weight))
