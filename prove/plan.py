"""Which cases there are: half clean, the others of the kinds in KIND_SHARES."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from benchtwin.prove.effects import FOLLOWING, OUTSIDE

CLEAN = "clean"
SINGLE = "single"
CONFOUNDED = "confounded"
SEPARATED = "separated"
COMPOUND = "compound"
UNLISTED_KIND = "outside"
CONDITION = "condition"
CLEAN_SHARE, RENDERED_SHARE = 0.5, 0.22
KIND_SHARES = {
    SINGLE: 0.43,
    CONFOUNDED: 0.12,
    SEPARATED: 0.11,
    COMPOUND: 0.11,
    UNLISTED_KIND: 0.13,
    CONDITION: 0.10,
}
RIG_SHARES = {"drop": 0.55, "slide": 0.18, "roll": 0.17, "pile": 0.10}
# of the others 7
MOST_SNR = 40.0
LEAST_SNR = {SINGLE: 2.0, CONDITION: 2.0, COMPOUND: 11.0}

SINGLES = {
    "drop": (
        "drag",
        "magnus",
        "draught",
        "viscoelastic-restitution",
        "plastic-restitution",
        "plate-compliance",
        "film-adhesion",
        "impact-damage",
        "plate-tilt",
        "shape-conversion",
        "camera-roll",
        "perspective",
        "silhouette-wobble",
    ),
    "slide": (
        "kinetic-friction",
        "viscous-sliding",
        "adhesion",
        "reading-delay",
        "clock-offset",
        "plate-vibration",
        "partial-rolling",
        "stepped-tilt",
    ),
    "roll": ("slope", "initial-slip", "corner-loss", "shape-barrier"),
    "pile": (
        "cohesion",
        "gate-speed",
        "base-vibration",
        "base-tilt",
    ),  # of the tilts the one whose flanks stay upright
}
NEED_SEPARATION = (
    "film-adhesion",
    "impact-damage",
    "adhesion",
    "clock-offset",
    "slope",
    "cohesion",
    "gate-speed",
)
CONFOUNDED_EFFECTS = {
    "drop": ("scale-error", "clock-error", "film-adhesion", "impact-damage"),
    "slide": ("stribeck",),
    "roll": ("viscous-rolling", "drag"),
    # one kind of heap tells of no gate; a rolled picture is that of a heap tilted after
    # it was poured
    "pile": ("gate-speed", "wall-friction", "particle-shape", "camera-roll"),
}
SEPARABLE_EFFECTS = {
    "drop": ("film-adhesion", "impact-damage", "draught", "camera-roll"),
    "slide": ("clock-offset", "adhesion", "stribeck"),
    "roll": ("slope",),
    "pile": ("cohesion", "gate-speed"),
}
PAIRS = {
    "drop": (
        ("drag", "plate-tilt"),
        ("drag", "camera-roll"),
        ("drag", "silhouette-wobble"),
        ("plate-tilt", "perspective"),
        ("camera-roll", "viscoelastic-restitution"),
        ("draught", "viscoelastic-restitution"),
        ("perspective", "impact-damage"),
    ),
    "slide": (
        ("kinetic-friction", "viscous-sliding"),
        ("clock-offset", "kinetic-friction"),
        ("adhesion", "viscous-sliding"),
    ),
    "roll": (
        ("slope", "corner-loss"),
        ("slope", "shape-barrier"),
        ("corner-loss", "shape-barrier"),
    ),
}
UNLISTED_EFFECTS = {rig: tuple(names) for rig, names in OUTSIDE.items()}
CONDITIONS = {rig: ("follows",) for rig in FOLLOWING}


@dataclass(frozen=True)
class Spec:
    """One case to make. separated: whether it holds the recordings that tell the effect
    from its twins; None: as it comes."""

    index: int
    rig: str
    kind: str
    effects: tuple[str, ...]
    wanted_snr: tuple[float, ...]
    separated: bool | None
    rendered: bool

    @property
    def name(self) -> str:
        return f"case-{self.index:04d}"


def plan(cases: int, rng: np.random.Generator) -> list[Spec]:
    """`cases` specs in random order; the number of a case says nothing about it."""
    kinds = _apportioned(
        {CLEAN: CLEAN_SHARE}
        | {k: (1 - CLEAN_SHARE) * s for k, s in KIND_SHARES.items()},
        cases,
    )
    drawn = []
    for kind in dict.fromkeys(kinds):
        shares = {rig: s for rig, s in RIG_SHARES.items() if rig in _offered(kind)}
        drawn += [(kind, rig) for rig in _apportioned(shares, kinds.count(kind))]
    turn: dict[tuple, int] = {}
    order, drops, specs = rng.permutation(cases), 0, {}
    for index, (kind, rig) in zip(order, drawn):
        turn[kind, rig] = turn.get((kind, rig), int(rng.integers(100))) + 1
        rendered = False
        if rig == "drop":
            drops += 1
            rendered = int(drops * RENDERED_SHARE) > int((drops - 1) * RENDERED_SHARE)
        specs[int(index)] = _spec(
            int(index) + 1, kind, rig, turn[kind, rig], rendered, rng
        )
    return [specs[i] for i in range(cases)]


def _spec(
    index: int, kind: str, rig: str, turn: int, rendered: bool, rng: np.random.Generator
) -> Spec:
    offered = _offered(kind)[rig]
    chosen = offered[turn % len(offered)]
    effects = (chosen,) if isinstance(chosen, str) else chosen
    separated = {CONFOUNDED: False, SEPARATED: True}.get(kind)
    if kind in (SINGLE, COMPOUND) and set(effects) & set(NEED_SEPARATION):
        separated = True
    wanted = tuple(
        float(np.exp(rng.uniform(*np.log([LEAST_SNR.get(kind, 7.0), MOST_SNR]))))
        for _ in effects
    )
    few = rendered and not set(effects) & {
        "follows",
        "order-drift",
    }  # films in pictures are three: too few for that
    return Spec(index, rig, kind, effects, wanted, separated, few)


def _offered(kind: str) -> dict[str, Any]:
    """Of each rig, the effects or pairs of effects that cases of this kind hold in
    turn."""
    if kind == CLEAN:
        return dict.fromkeys(RIG_SHARES, ((),))
    offered: dict[str, dict[str, Any]] = {
        SINGLE: SINGLES,
        CONFOUNDED: CONFOUNDED_EFFECTS,
        SEPARATED: SEPARABLE_EFFECTS,
        COMPOUND: PAIRS,
        UNLISTED_KIND: UNLISTED_EFFECTS,
        CONDITION: CONDITIONS,
    }
    return offered[kind]


def _apportioned(shares: dict[str, float], count: int) -> list[str]:
    """`count` names in these shares, as nearly as whole numbers go (largest
    remainders)."""
    total = sum(shares.values())
    exact = {name: count * s / total for name, s in shares.items()}
    dealt = {name: int(v) for name, v in exact.items()}
    for name in sorted(exact, key=lambda n: dealt[n] - exact[n])[
        : count - sum(dealt.values())
    ]:
        dealt[name] += 1
    return [name for name, n in dealt.items() for _ in range(n)]
