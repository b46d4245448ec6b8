"""What the proof knows of a rig: its effects, which of them cases hold, and what draws,
weighs and writes them. A module of this folder, or `cases.py` in a rig's own, holds one
as `CASES`."""

from collections import namedtuple
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from benchtwin.prove.cases.bench import Recording, Request, Scene
from benchtwin.prove.cases.snr import Visibility

FOLLOWS = "follows"  # a contact parameter that follows a condition
ORDER_DRIFT = "order-drift"  # one that drifts from recording to recording


@dataclass(frozen=True)
class Effect:
    """One effect. sectors: where it shows; unit None: it is reported without a
    parameter; least, most: sizes that are believable; sign: of them, 0 for either.
    either: its sign depends on the choice of axes; sizes are compared. listed: whether
    the solver knows it, too."""

    sectors: tuple[str, ...]
    unit: str | None = None
    least: float = 0.0
    most: float = 0.0
    sign: int = 1
    either: bool = False
    listed: bool = True


def field_of(effect: str) -> str:
    """The field of a world that holds the size of an effect."""
    return effect.replace("-", "_")


def world_with(effects: Mapping[str, Effect], base: Any) -> Any:
    """A named tuple of the fields of `base`, of how far a recording lies on the scale
    that a parameter follows (−1 … 1), and of each effect, 0 where it is not."""
    more = ["followed", *map(field_of, effects)]
    return namedtuple(
        "World",
        [*base._fields, *more],
        defaults=[0.0] * len(more),
        module=base.__module__,
    )


@dataclass(frozen=True, kw_only=True)
class Cases:
    """One rig. share: of the cases; colour: in figures; follows: the parameter that may
    follow a condition; design: fields of a world that differ by design.

    draw(request, rng) → scene; visibility(scene, effect's field); record(scene, world,
    name); scored(scene, name): whether one number is true of all recordings. Effects
    that cases hold in turn: singles, one at a time; need_separation: of them those that
    are told apart by further recordings only; confounded: without such, separable: with
    them; pairs."""

    rig: str
    share: float
    colour: str
    effects: Mapping[str, Effect] = field(hash=False)
    draw: Callable[[Request, Any], Scene]
    visibility: Callable[[Scene, str], Visibility]
    record: Callable[[Scene, Any, str], Recording]
    scored: Callable[[Scene, str], bool] = lambda scene, name: True
    design: tuple[str, ...] = ()
    follows: str = ""
    singles: tuple[str, ...]
    need_separation: tuple[str, ...] = ()
    confounded: tuple[str, ...] = ()
    separable: tuple[str, ...] = ()
    pairs: tuple[tuple[str, str], ...] = ()

    @property
    def unlisted(self) -> tuple[str, ...]:
        """Effects that the solver does not know."""
        return tuple(n for n, e in self.effects.items() if not e.listed)
