"""One body on its rig (drop, slide, roll): what computes its way while observers look
on and end it."""

from collections.abc import Callable, Sequence

import numpy as np
from benchtwin.sim.engine.step import Every, init, run
from benchtwin.sim.engine.world import World

Engine = Callable[[World, np.random.Generator, float, Sequence[Every]], None]
"""Computes a world until an observer ends it, or for so many seconds."""


def our_engine(
    world: World, rng: np.random.Generator, longest_s: float, observers: Sequence[Every]
) -> None:
    """The engine of `sim.engine`."""
    run(world, init(world, rng), longest_s, list(observers))
