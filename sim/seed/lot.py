"""A lot of seeds measured one by one, from which simulated seeds are drawn."""

from dataclasses import dataclass

import numpy as np

from benchtwin.sim.seed import Seed


@dataclass(frozen=True, eq=False)
class Lot:
    """The seeds of one lot, all equally frequent; each has its `dimensions_m`."""

    seeds: tuple[Seed, ...]

    def __post_init__(self) -> None:
        if not self.seeds:
            raise ValueError("a lot needs at least one seed")
        if any(seed.dimensions_m is None for seed in self.seeds):
            raise ValueError("every seed of a lot needs its dimensions")

    @property
    def dimensions_m(self) -> np.ndarray:
        """Length, width and thickness of each seed [m], (n, 3)."""
        return np.array([seed.dimensions_m for seed in self.seeds])

    def draw(self, rng: np.random.Generator, count: int) -> list[Seed]:
        """`count` seeds in random order, each of the lot equally often (± 1): means and
        covariances of the lot are kept."""
        rounds = range(-(-count // len(self.seeds)))
        order = np.concatenate([rng.permutation(len(self.seeds)) for _ in rounds])
        return [self.seeds[k] for k in order[:count]]

    def nearest(self, dimensions_m: np.ndarray) -> Seed:
        """The seed whose length, width and thickness are nearest to those given, by the
        sum of squared logarithms."""
        off = np.log(self.dimensions_m / np.asarray(dimensions_m, float))
        return self.seeds[int((off**2).sum(axis=1).argmin())]

    def typical(self) -> Seed:
        """The seed nearest to the lot's mean length, width and thickness."""
        return self.nearest(self.dimensions_m.mean(axis=0))
