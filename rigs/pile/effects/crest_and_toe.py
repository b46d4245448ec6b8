"""Crest and toe: sticking grains steepen both, running or creeping ones round and
lengthen."""

from collections.abc import Callable

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.ellipsoid import ellipsoid_volume
from benchtwin.infer.effect import Counterpart
from benchtwin.rigs.pile.effects.shapes import (
    HeapEffect,
    Law,
    as_stated,
    bends,
    crest,
    ends,
    further,
    toe,
)

_SIZE = as_stated(seed_mm=-1.0, rig_mm=-1.0)
_SPEED = as_stated(gate_speed_mm_s=1.0, rig_mm=-0.5)
_TIME = as_stated(photo_s=1.0)
# toe drawn out, and flank flattened [deg], per fall of the crest
TOE = 0.5
FLATTER_DEG = 20.0
STRONGEST = 0.1  # pull of a neck over the weight of all seeds above it
NECK = 0.1  # its length when it breaks, of a seed's diameter
_FILM = (
    "a film's pull ∝ d, a seed's weight ∝ d³: the stress it holds ∝ 1/d, over that of a"
    " heap's weight ∝ 1/(d H)"
)
_FALL = (
    "a wheat heap: 10, 25, 50 mm/s left 18.4°, 12.3°, 10.4°; over a fall's speed √(gH)"
)
_CREEP = "creep of a shaken heap; its height shrinks with time"


def _seen_in_turn(photos: tuple) -> np.ndarray:
    return np.full(len(photos), float(any(np.isfinite(p.creep_deg) for p in photos)))


def _bridges(
    seed: dict, pile: dict, stated: dict, strength: float
) -> tuple[dict, dict, dict]:
    """Liquid whose necks pull at strength 1 with the weight of a seed of mean length,
    π d γ = m g (Willett et al. 2000), and as strongly ∝ d on others; V^⅓ = NECK d,
    V = 0.008 R³, more than the 0.001 R³ for which the law of the pull's fall is
    stated."""
    axes_mm = (seed[f"{axis}_mm"] for axis in ("length", "width", "thickness"))
    volume_mm3 = ellipsoid_volume(*axes_mm)
    mean = seed["mean_mm"] / seed["length_mm"]
    d_m = 1e-3 * np.cbrt(6 / np.pi * volume_mm3)
    weight = 1e-9 * G_M_S2 * volume_mm3 * seed["density_kg_m3"] * mean**3
    bridge = {
        "surface_tension": float(f"{strength * weight / (np.pi * mean * d_m):.6g}"),
        "volume": float(f"{(NECK * d_m) ** 3:.6g}"),
    }
    return seed, pile, {"liquid_bridge": bridge}


def _faster(
    seed: dict, pile: dict, stated: dict, strength: float
) -> tuple[dict, dict, dict]:
    speed = pile["gate_speed_mm_s"] * (1 + strength)
    return seed, pile | {"gate_speed_mm_s": speed}, {}


def _rounder(share: float, weight: Callable[[tuple], np.ndarray], **more) -> Law:
    """A crest lower by `share` of the height, and what usually goes with it."""
    surface = lambda u: share * (TOE * toe(u) - crest(u))  # noqa: E731
    return Law(surface=surface, angle_deg=-share * FLATTER_DEG, weight=weight, **more)


EFFECTS = (
    HeapEffect(
        name="cohesion",
        of_seeds=True,
        sector="crest",
        unit="deg",
        meaning="steeper than without",
        prior_sd=6.0,
        low=0.0,
        high=40.0,
        source=_FILM,
        wording=("the seeds stick together", "° steeper"),
        separating=(
            "the same of seeds, or in a heap, half and twice as large: cohesion counts"
            " for more the smaller they are"
        ),
        counterpart=Counterpart(
            "liquid between seeds pulls with {value} of a seed's weight"
        ),
        law=Law(
            angle_deg=1.0,
            weight=_SIZE,
            twin=_bridges,
            most=lambda seeds_high: STRONGEST * seeds_high,
        ),
    ),
    *ends("cohesion", _FILM, _SIZE),
    HeapEffect(
        name="gate-speed",
        sector="crest",
        unit="1",
        meaning="crest below a usual one over the heap's height",
        prior_sd=0.15,
        low=0.0,
        high=0.8,
        source=_FALL,
        wording=(
            "the gate moved at another speed than stated",
            "of the heap's height at its crest",
        ),
        separating=(
            "the same heap at half and at twice the gate speed: what the gate does"
            " grows with it, shaking does not"
        ),
        counterpart=Counterpart(
            "the gate moves faster than stated by {value} of its speed"
        ),
        law=_rounder(1.0, _SPEED, twin=_faster, most=lambda seeds_high: 3.0),
    ),
    *further(
        "gate-speed",
        _FALL,
        toe=(
            "toe",
            "1",
            "toe above a usual one",
            0.10,
            Law(surface=toe, weight=_SPEED),
        ),
        angle=("crest", "deg", "flatter", 6.0, Law(angle_deg=-1.0, weight=_SPEED)),
    ),
    *bends("gate-speed", _FALL, _SPEED),
    HeapEffect(
        name="base-vibration",
        sector="crest",
        unit="deg",
        prior_sd=3.0,
        low=0.0,
        high=40.0,
        source=_CREEP,
        meaning=(
            "flatter in the last photo of a heap than in its first; of heaps not seen"
            " in turn by their shape"
        ),
        wording=("the base vibrated", "° flatter from the first to the last photo"),
        not_simulated="how its base shook was not recorded",
        separating=(
            "two photos of one heap a minute apart, photo_s stated: what shakes goes"
            " on, what the gate did is over"
        ),
        law=_rounder(1 / FLATTER_DEG, _TIME, creep_deg=1.0),
    ),
    *further(
        "base-vibration",
        _CREEP,
        crest=(
            "crest",
            "1",
            "what its crest is lower by beside that",
            0.15,
            Law(surface=crest, weight=_seen_in_turn),
        ),
        toe=("toe", "1", "toe above a usual one", 0.10, Law(surface=toe, weight=_TIME)),
        angle=("crest", "deg", "flatter", 6.0, Law(angle_deg=-1.0, weight=_TIME)),
    ),
    *bends("base-vibration", _CREEP, _TIME),
)
