"""What a law is, and how a run chooses one: frozen records, checked when they are
made."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from benchtwin.sim.laws.contract import FIXED, RETURNED, broken

KINDS = tuple(FIXED)
CONTACT_KINDS = tuple(kind for kind in KINDS if kind not in ("body", "motion"))
NORMAL_KINDS = ("normal", "spring")  # along the normal
ALONE = ("spring", "rolling_spring")  # one between two materials


@dataclass(frozen=True)
class Parameter:
    """One number of a law: its name (an argument of the function), unit, range (ends
    included) and meaning."""

    name: str
    unit: str
    low: float
    high: float
    meaning: str
    default: float | None = None

    def __post_init__(self):
        if not -math.inf < self.low < self.high < math.inf or not (
            self.default is None or self.low <= self.default <= self.high
        ):
            raise ValueError(
                f"parameter {self.name!r}: low = {self.low} must be below high ="
                f" {self.high}, both finite, and default = {self.default} between them"
            )


@dataclass(frozen=True)
class Law:
    """A force law: a pure scalar function, its kind (see `sim.laws`) and the parameters
    that follow the fixed arguments.

    Of laws along the normal only: `reach`, how far apart [m] two surfaces that have
    touched still act on each other; `memory`, what a contact remembers from step to
    step (0 when it begins): arguments between the fixed ones and the parameters, and
    results after the others."""

    name: str
    kind: str
    function: Callable
    parameters: tuple[Parameter, ...] = ()
    reach: Callable | None = None
    source: str = ""
    memory: tuple[Parameter, ...] = ()

    def __post_init__(self):
        if self.kind not in KINDS:
            raise ValueError(
                f"law {self.name!r}: kind {self.kind!r} is none of {', '.join(KINDS)}"
            )
        if (self.reach or self.memory) and self.kind not in NORMAL_KINDS:
            raise ValueError(
                f"law {self.name!r}: only laws of kind 'normal' and 'spring' have a"
                f" reach or a memory, not {self.kind!r}"
            )
        own = {p.name: (p.low, p.high) for p in self.parameters}
        kept = {p.name: (p.low, p.high) for p in self.memory}
        why = broken(self.kind, self.function, kept | own, len(kept))
        if not why and self.reach is not None:
            why = broken("reach", self.reach, own)
        if why:
            raise ValueError(f"law {self.name!r} of kind {self.kind!r}: {why}")

    def use(
        self, *, between: tuple[str, str] | None = None, **values: float
    ) -> "Chosen":
        """This law with its parameters' values; `between` limits a contact law to one
        pair of materials."""
        return Chosen(self, tuple(sorted(values.items())), between)


@dataclass(frozen=True)
class Chosen:
    """A law as one run uses it. `numbers` are the values in the order in which the
    function takes them."""

    law: Law
    given: tuple[tuple[str, float], ...] = ()
    between: tuple[str, str] | None = None
    numbers: tuple[float, ...] = field(init=False)

    def __post_init__(self):
        given = dict(self.given)
        unknown = set(given) - {p.name for p in self.law.parameters}
        if unknown:
            names = ", ".join(p.name for p in self.law.parameters) or "no parameters"
            raise ValueError(
                f"law {self.law.name!r} takes {names}; it does not know"
                f" {', '.join(sorted(unknown))}"
            )
        if self.between is not None and self.law.kind not in CONTACT_KINDS:
            raise ValueError(
                f"law {self.law.name!r} of kind {self.law.kind!r} acts on no pair of"
                " materials: leave `between` out"
            )
        object.__setattr__(
            self,
            "numbers",
            tuple(_checked(self.law, p, given) for p in self.law.parameters),
        )

    def acts_between(self, one: str, other: str) -> bool:
        """Whether it acts between these materials."""
        return self.between is None or set(self.between) == {one, other}

    def along_normal(
        self,
        overlap: float,
        speed: float,
        of_pair: tuple[float, float, float],
        memory: tuple[float, ...] | None = None,
    ) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """What a law along the normal gives for a pair of R* [m], E* [Pa] and e, the
        force [N] first; and what the contact remembers then."""
        law, before = self.law, memory or (0.0,) * len(self.law.memory)
        given = RETURNED.get(law.kind, 1)
        reach = law.reach(*of_pair[:2], *self.numbers) if law.reach else 0.0
        if -overlap > reach:
            return (0.0,) * given, before
        fixed = (overlap, speed, *of_pair)[: len(FIXED[law.kind])]
        told = law.function(*fixed, *before, *self.numbers)
        told = told if isinstance(told, tuple) else (told,)
        return told[:given], told[given:]


def _checked(law: Law, parameter: Parameter, given: dict[str, float]) -> float:
    value = given.get(parameter.name, parameter.default)
    if value is None:
        raise ValueError(
            f"law {law.name!r} needs {parameter.name} [{parameter.unit}]:"
            f" {parameter.meaning}"
        )
    if not parameter.low <= value <= parameter.high:  # NaN fails too
        raise ValueError(
            f"law {law.name!r}: {parameter.name} = {value} {parameter.unit} is outside"
            f" {parameter.low} … {parameter.high}"
        )
    return float(value)
