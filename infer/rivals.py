"""What else could be true of a measured number: other explanations with their odds.

One that has less than 5 % of the probability cannot make a 95 % interval fail."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

INSIDE_SDS = 1.96
CAN_BE_TRUE = 0.05  # probability from which a rival counts


class Measured(Protocol):
    """A number with its standard deviation."""

    @property
    def name(self) -> str: ...
    @property
    def value(self) -> float: ...
    @property
    def sd(self) -> float: ...


@dataclass(frozen=True)
class Rival:
    """Another explanation: odds over the fit, and the value of a quantity if it holds,
    NaN where that is not shown then."""

    odds: float
    words: str
    value: Callable[[Measured], float]


def by_name(values: Mapping[str, float]) -> Callable[[Measured], float]:
    """Values of quantities if a rival holds, as a Rival has them."""
    return lambda q: values[q.name]


def unless(rivals: list[Rival], q: Measured) -> list[str]:
    """Why the interval of a quantity would not hold if a rival were true."""
    whole, out = 1 + sum(r.odds for r in rivals), []
    for rival in rivals:
        share = rival.odds / whole
        value = rival.value(q)
        if share >= CAN_BE_TRUE and not abs(value - q.value) <= INSIDE_SDS * q.sd:
            other = f"is {value:.3g}" if math.isfinite(value) else "is not shown"
            out.append(f"it {other} if {rival.words} (probability {share:.2g})")
    return out
