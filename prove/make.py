"""One case: its bench folder and its key, both from the plan's line and one seed of random numbers."""

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from prove.cases import drop, drop_bench, drop_effects, drop_snr, pile, roll, slide
from prove.cases.drop_effects import IN_CAMERA
from prove.cases.folder import write_bench
from prove.cases.truth import Bench, Wish
from prove.effects import EFFECTS, OUTSIDE
from prove.plan import Spec

SCENES, ROUNDS = 5, 5
NEAR = 1.25  # a size that makes the wanted SNR within this factor will do


@dataclass(frozen=True)
class Rig:
    """What a rig's file offers: draw a scene, tell an effect's SNR, make the bench; (least, most, sign) of each effect."""

    draw: Callable[[Wish, np.random.Generator], Any]
    visibility: Callable[[Any, dict[str, float], str], float]
    bench: Callable[[Any, dict[str, float]], Bench]
    ranges: dict[str, tuple[float, float, int]]


@dataclass(frozen=True)
class Concealed:
    """One effect of a case. unit None: without a parameter; scored: whether one number is true of all recordings."""

    name: str
    value: float
    unit: str | None
    snr: float
    either: bool = False
    scored: bool = True


@dataclass(frozen=True)
class Key:
    """What is concealed in a case, and what was known of it when it was made. sectors: where it shows."""

    case: str
    rig: str
    kind: str
    effects: tuple[Concealed, ...]
    sectors: tuple[str, ...]
    separated: bool | None
    rendered: bool
    noise: dict = field(default_factory=dict)

    @property
    def snr(self) -> float:
        """Of the least visible effect; 0 when clean."""
        return min((e.snr for e in self.effects), default=0.0)

    def to_dict(self) -> dict:
        return asdict(self)

    @staticmethod
    def from_dict(content: dict) -> "Key":
        effects = tuple(Concealed(**e) for e in content["effects"])
        return Key(**{**content, "effects": effects, "sectors": tuple(content["sectors"])})


def _rig(module: ModuleType) -> Rig:
    return Rig(module.draw, module.visibility, module.bench, module.RANGES)


RIGS = {
    "drop": Rig(drop.draw, drop_snr.visibility, drop_bench.bench, drop_effects.RANGES),
    "slide": _rig(slide),
    "roll": _rig(roll),
    "pile": _rig(pile),
}


def make(spec: Spec, seed: int) -> tuple[Bench, Key]:
    """The case of this line of the plan. The same seed makes the same case."""
    scene, sizes, key = conceal(spec, seed)
    return RIGS[spec.rig].bench(scene, sizes), key


def conceal(spec: Spec, seed: int) -> tuple[Any, dict[str, float], Key]:
    """The scene in which the wished effects come nearest to the wished SNRs, their sizes, and the key."""
    rig, tried = RIGS[spec.rig], []
    wish = Wish(spec.effects, spec.separated, spec.rendered)
    for attempt in range(SCENES if spec.effects else 1):
        rng = np.random.default_rng([seed, spec.index, attempt])
        scene = rig.draw(wish, rng)
        sizes, snrs = sized(rig, scene, spec, rng)
        off = max((abs(math.log(max(v, 1e-3) / w)) for v, w in zip(snrs, spec.wanted_snr)), default=0.0)
        tried.append((off, scene, sizes, snrs))
        if off < math.log(NEAR):
            break
    _, scene, sizes, snrs = min(tried, key=lambda one: one[0])
    return scene, sizes, _key(spec, scene, sizes, snrs)


def sized(rig: Rig, scene: Any, spec: Spec, rng: np.random.Generator) -> tuple[dict[str, float], list[float]]:
    """Sizes with which the effects have about the SNR that is wanted, as far as sizes are believable; and the SNRs they have."""
    sizes: dict[str, float] = {}
    for name, wanted in zip(spec.effects, spec.wanted_snr):
        low, high, sign = rig.ranges[name]
        sign = sign or int(rng.choice([-1, 1]))
        size, before, seen = math.sqrt(low * high), 0.0, 0.0  # nothing is seen of nothing; what a nuisance hides is a hinge
        for _ in range(ROUNDS):
            snr = rig.visibility(scene, sizes | {name: sign * size}, name)
            if max(snr / wanted, wanted / max(snr, 1e-9)) < 1.08:
                break
            slope = (snr - seen) / (size - before)
            better = size + (wanted - snr) / slope if slope > 0 else math.inf
            better = float(np.clip(np.clip(better, 0.1 * size, 6.0 * size), low, high))
            if better == size:
                break
            size, before, seen = better, size, snr
        sizes[name] = sign * float(f"{size:.4g}")
    return sizes, [rig.visibility(scene, sizes, name) for name in spec.effects]


def _key(spec: Spec, scene, sizes: dict[str, float], snrs: list[float]) -> Key:
    listed = EFFECTS[spec.rig]
    effects = []
    for name, snr in zip(spec.effects, snrs):
        entry = listed.get(name)
        unit, either = (entry.unit, entry.either) if entry else (None, False)
        split = spec.rig == "drop" and name in IN_CAMERA and scene.one_session and len(scene.cameras) > 1
        effects.append(
            Concealed(name, float(sizes[name]), unit, round(snr, 3), either, bool(unit) and not split)
        )
    # a compound shows in several places; where is then not asked
    sectors = _sectors(spec) if len(effects) == 1 else ()
    noise = {k: v if math.isfinite(v) else None for k, v in asdict(scene.noise).items()} if hasattr(scene, "noise") else {}
    return Key(spec.name, spec.rig, spec.kind, tuple(effects), sectors, spec.separated, spec.rendered, noise)


def _sectors(spec: Spec) -> tuple[str, ...]:
    name = spec.effects[0]
    listed = EFFECTS[spec.rig]
    return listed[name].sectors if name in listed else OUTSIDE[spec.rig][name]


def make_folder(spec: Spec, seed: int, folder: Path) -> dict:
    """Make the case, write its bench folder unless it is there, return its key as a dict (for worker processes)."""
    scene, sizes, key = conceal(spec, seed)
    if not folder.exists():
        write_bench(RIGS[spec.rig].bench(scene, sizes), folder)
    return key.to_dict()
