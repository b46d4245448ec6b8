"""Filling a vessel: seeds rain in through a chute of its own cross-section, come to
rest, and are struck off at a height."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.engine.filling import scatter
from benchtwin.sim.engine.walls import Vector
from benchtwin.sim.engine.world import Placed, Scattered, World
from benchtwin.sim.material import Material
from benchtwin.sim.rigs.bench import Bench, Watch, reach
from benchtwin.sim.rigs.engine import Engine
from benchtwin.sim.seed import Seed

# volume fraction that is never exceeded by such a rain: how many seeds are enough
PACKED = 0.64
SPARE = 1.06  # that many more, to have something to strike off
# share of the chute that the rain takes: random sequential addition comes to a halt at
# .37 to .39 in a wide chute, at .22 in one that is a seed wide each way
RAIN = 0.15
LEAST_SEEDS = 10  # fewer make no heap
# of a radius, for an instant where rain falls on what lies: forgotten once the seeds do
RAIN_OVERLAP = 0.25
FALLING_M_S = 0.5  # as the rain begins
STRUCK_OFF = 0.995  # with more left than this share, nothing was struck off


@dataclass(frozen=True, eq=False)
class Filled:
    """Seeds at rest in their vessel: the different shapes, which of them each seed has,
    and where it lies."""

    shapes: tuple[Seed, ...]
    shape_of: np.ndarray
    positions_m: np.ndarray
    orientations: np.ndarray

    def placed(self, bench: Bench) -> Placed:
        x, q = self.positions_m, self.orientations
        return Placed(self.shapes, bench.grain, x, q, shape_of=self.shape_of)


@dataclass(frozen=True)
class Chute:
    """Where seeds rain: corners [m] of a vessel's inside, up to its top; round: of the
    upright cylinder that fits between them."""

    low: Vector
    high: Vector
    round: bool = False

    def top_m(self, seeds: list[Seed]) -> float:
        """How high the rain of these seeds begins. As their centres keep a bounding
        radius from the walls, the chute is as wide as one for balls of their volume."""
        bound = max(seed.bounding_radius_m for seed in seeds)
        volume = sum(seed.volume_m3 for seed in seeds)
        size = (6.0 / np.pi * volume / len(seeds)) ** (1 / 3)
        along, across = (
            max(self.high[k] - self.low[k] - 2 * bound, 0.0) + size for k in (0, 1)
        )
        area = along * across * (np.pi / 4 if self.round else 1.0)
        return self.low[2] + volume / (RAIN * area) + 2 * bound


def count_for(bench: Bench, rng: np.random.Generator, volume_m3: float) -> list[Seed]:
    """Seeds of the lot, more than enough to fill a volume [m3]."""
    lot = bench.draw(np.random.default_rng(0), 200)
    mean = float(np.mean([seed.volume_m3 for seed in lot]))
    count = int(np.ceil(SPARE * PACKED * volume_m3 / mean))
    if count < LEAST_SEEDS:
        raise ValueError(
            f"the vessel holds about {count} seeds only: a pile needs a larger box or a"
            " higher filling"
        )
    return bench.draw(rng, count)


def firm(
    bench: Bench, shapes: tuple[Seed, ...], speed_m_s: float, overlap: float
) -> Material:
    """The bench's grain, or one stiff enough that the smallest balls of two equal seeds
    that meet head on overlap by no more than this share of their radius r.

    ½ m* v² = (8/15) E* √R* (x r)^2.5 with m* = m/2, R* = r/2, E* = G/(1 − ν): Hertz's
    greatest overlap without damping, Johnson (1985), section 11.4."""
    needed = 0.0
    for seed in shapes:
        r = float(seed.radii_m.min())
        energy = 0.25 * seed.mass_kg * speed_m_s**2
        work = 8 / 15 * math.sqrt(r / 2) * (overlap * r) ** 2.5  # over E*
        needed = max(needed, (1 - bench.seed.poisson_ratio) * energy / work)
    if needed <= bench.grain.shear_modulus_pa:
        return bench.grain
    return replace(bench, shear_modulus_pa=needed).grain


def rain(
    bench: Bench,
    rng: np.random.Generator,
    seeds: list[Seed],
    chute: Chute,
    make: Callable[[Placed], World],
    level_m: float,
    engine: Engine,
    watch: Watch,
) -> Filled:
    """Let seeds fall through a chute until they lie, and take away those that stand out
    above `level_m`. make: the vessel, its walls going up to the chute's top, with given
    seeds in it."""
    shapes = tuple(dict.fromkeys(seeds))
    shape_of = np.array([shapes.index(seed) for seed in seeds])
    (x, y, _), falling = chute.high, (0.0, 0.0, -FALLING_M_S)
    high = (x, y, chute.top_m(seeds))
    fastest = math.sqrt(FALLING_M_S**2 + 2 * G_M_S2 * (high[2] - level_m))
    grain = firm(bench, shapes, fastest, RAIN_OVERLAP)
    scattered = Scattered(
        *(shapes, grain, len(seeds), chute.low, high),
        *(falling, chute.round, shape_of),
    )
    world = make(scatter(scattered, rng))
    positions, orientations = engine.lay(world, rng, watch)
    above = [reach(s, q, (0, 0, 1)) for s, q in zip(seeds, orientations)]
    top = np.array(above) + positions[:, 2]
    keep = np.flatnonzero(top <= level_m)
    if len(keep) > STRUCK_OFF * len(seeds):
        raise ValueError(
            f"the filling reaches {1e3 * top.max():.0f} mm only, not"
            f" {1e3 * level_m:.0f} mm"
        )
    return Filled(shapes, shape_of[keep], positions[keep], orientations[keep])
