"""Whether a law that was found can be what acts, judged within the recordings.

Its reference is about the greatest value of its quantity there, so its size is what it
does where it was seen; a power of less than 0 does most at the least value. There it
may do no more than nature does (`low`, MOST), and what is fitted beside it must not
undo it over the rows: two numbers that cancel are the fit's freedom, no physics."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from benchtwin.infer.linear import Reduced, ridge, stacked

# of the weight: at its terminal speed air holds a seed by just that, and friction on a
# plate seldom is more; of a speed at an impact: all of it
MOST = 1.0
# of what one number does, of which another may undo the rest: half of a resistance, or
# of what a law does to the rows
LEFT = 0.5


@dataclass(frozen=True)
class Reach:
    """Of one term: what it does at most in the recordings, over its size; and the least
    that this may be beside the globals (by name)."""

    greatest: float
    low: Callable[[Mapping[str, float]], float]


def is_possible(
    names: tuple[str, ...],
    effects: Mapping[str, object],
    reduced: tuple[Reduced, ...],
    prior_sd: np.ndarray,
    reaches: list[Reach],
) -> bool:
    """Of the terms whose columns stand behind the globals' (names), the last beside the
    others and the listed effects that are free."""
    a, b = stacked(reduced)
    values = ridge(a, b, prior_sd)[0]
    at, sizes = dict(zip(names, values)), values[len(names) :]
    for size, reach in zip(sizes, reaches, strict=True):
        if not reach.low(at) <= size * reach.greatest <= MOST:
            return False
    free = [n in effects and sd > 0 for n, sd in zip(names, prior_sd)]
    *others, law = (a * values)[:, [*free, *np.ones(len(sizes), dtype=bool)]].T
    left = [float(np.linalg.norm(law + one)) for one in others]
    return min(left, default=np.inf) >= LEFT * float(np.linalg.norm(law))
