"""What the proof knows of a rig: its effects, which of them cases hold, and what draws,
weighs and writes them. A module of this folder, or `cases.py` in a rig's own, holds one
as `CASES`."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from benchtwin.prove.cases.bench import Bench, Request
from benchtwin.prove.cases.snr import Visibility

FOLLOWS = "follows"  # a contact parameter that follows a condition


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


@dataclass(frozen=True, kw_only=True)
class Cases:
    """One rig. share: of the cases; colour: in figures; follows: the parameter that may
    follow a condition; design: fields of a run that differ by design.

    draw(request, rng) → scene; visibility(scene, sizes, name); bench(scene, sizes);
    scored(scene, name): whether one number is true of all recordings. Effects that
    cases hold in turn: singles, one at a time; need_separation: of them those that are
    told apart by further recordings only; confounded: without such, separable: with
    them; pairs."""

    rig: str
    share: float
    colour: str
    effects: Mapping[str, Effect] = field(hash=False)
    draw: Callable[[Request, Any], Any]
    visibility: Callable[[Any, dict[str, float], str], Visibility]
    bench: Callable[[Any, dict[str, float]], Bench]
    scored: Callable[[Any, str], bool] = lambda scene, name: True
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

    @property
    def conditions(self) -> tuple[str, ...]:
        """What cases hold in which a parameter follows a condition."""
        return (FOLLOWS,) if self.follows else ()
