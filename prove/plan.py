"""Which cases there are: half clean, the others of the kinds in KIND_SHARES."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchtwin.prove.cases.record import FOLLOWS, ORDER_DRIFT, Cases
from benchtwin.prove.rigs import RIGS

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
# of the others 7
MOST_SNR = 40.0
LEAST_SNR = {SINGLE: 2.0, CONDITION: 2.0, COMPOUND: 11.0}
OFFERED: dict[str, Callable[[Cases], tuple]] = {  # what cases of a kind hold in turn
    CLEAN: lambda rig: ((),),
    SINGLE: lambda rig: rig.singles,
    CONFOUNDED: lambda rig: rig.confounded,
    SEPARATED: lambda rig: rig.separable,
    COMPOUND: lambda rig: rig.pairs,
    UNLISTED_KIND: lambda rig: rig.unlisted,
    CONDITION: lambda rig: (FOLLOWS,) if rig.follows else (),
}


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
        shares = {n: rig.share for n, rig in RIGS.items() if OFFERED[kind](rig)}
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
    offered = OFFERED[kind](RIGS[rig])
    chosen = offered[turn % len(offered)]
    effects = (chosen,) if isinstance(chosen, str) else chosen
    separated = {CONFOUNDED: False, SEPARATED: True}.get(kind)
    if kind in (SINGLE, COMPOUND) and set(effects) & set(RIGS[rig].need_separation):
        separated = True
    wanted = tuple(
        float(np.exp(rng.uniform(*np.log([LEAST_SNR.get(kind, 7.0), MOST_SNR]))))
        for _ in effects
    )
    # films in pictures are three: too few for what follows something
    rendered &= not {FOLLOWS, ORDER_DRIFT} & set(effects)
    return Spec(index, rig, kind, effects, wanted, separated, rendered)


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
