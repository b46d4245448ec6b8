"""Filling a vessel: seeds rain in through a chute of its own cross-section, come to
rest, and are struck off at a height."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.engine.filling import scatter
from benchtwin.sim.engine.observe import Settled, kinetic_per_seed
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.step import run
from benchtwin.sim.engine.walls import Vector
from benchtwin.sim.engine.world import Placed, Scattered, World
from benchtwin.sim.rigs.bench import Bench, Watch, reach
from benchtwin.sim.seed import Seed

# volume fraction that is never exceeded by such a rain: how many seeds are enough
PACKED = 0.64
SPARE = 1.06  # that many more, to have something to strike off
# packed; it may creep on, with rolling friction of type A
POURED = Settled(window_s=0.05, displacement=0.1, kinetic=3e-4)
QUIET = Settled(window_s=0.05, displacement=1e-2, kinetic=1e-5)
LONGEST_S = 3.0

# a world run until its seeds lie: their places and orientations
Lay = Callable[[World], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True, eq=False)
class Filled:
    """Seeds at rest in their vessel: the different shapes, which of them each seed has,
    and where it lies."""

    shapes: tuple[Seed, ...]
    shape_of: np.ndarray
    positions_m: np.ndarray
    orientations: np.ndarray

    def placed(self, bench: Bench) -> Placed:
        return Placed(
            self.shapes,
            bench.grain,
            self.positions_m,
            self.orientations,
            shape_of=self.shape_of,
        )


def count_for(bench: Bench, rng: np.random.Generator, volume_m3: float) -> list[Seed]:
    """Seeds of the lot, more than enough to fill a volume [m3]."""
    mean = float(
        np.mean([seed.volume_m3 for seed in bench.draw(np.random.default_rng(0), 200)])
    )
    count = int(np.ceil(SPARE * PACKED * volume_m3 / mean))
    if count < 10:
        raise ValueError(
            f"the vessel holds about {count} seeds only: a pile needs a larger box or a"
            " higher filling"
        )
    return bench.draw(rng, count)


def rain(
    bench: Bench,
    rng: np.random.Generator,
    seeds: list[Seed],
    low: Vector,
    high: Vector,
    make: Callable[[Placed], World],
    level_m: float,
    lay: Lay,
) -> Filled:
    """Let seeds fall between corners `low` and `high` (the vessel's inside, [m]) until
    they lie as `POURED` says, and take away those that stand out above `level_m`. make:
    the vessel, its walls going up to `chute_height`, with given seeds in it. lay: runs
    it until they lie."""
    shapes = tuple(dict.fromkeys(seeds))
    shape_of = np.array([shapes.index(seed) for seed in seeds])
    scattered = Scattered(
        shapes,
        bench.grain,
        len(seeds),
        low,
        (high[0], high[1], chute_height(seeds, low, high)),
        (0, 0, -0.5),
    )
    world = make(replace(scatter(scattered, rng), shape_of=shape_of))
    positions, orientations = lay(world)
    top = (
        np.array([reach(s, q, (0, 0, 1)) for s, q in zip(seeds, orientations)])
        + positions[:, 2]
    )
    keep = np.flatnonzero(top <= level_m)
    if len(keep) > 0.995 * len(seeds):
        raise ValueError(
            f"the filling reaches {1e3 * top.max():.0f} mm only, not"
            f" {1e3 * level_m:.0f} mm"
        )
    return Filled(shapes, shape_of[keep], positions[keep], orientations[keep])


def chute_height(seeds: list[Seed], low: Vector, high: Vector) -> float:
    """Height [m] of the column in which that many seeds hang without touching."""
    pitch = 2.0 * max(seed.bounding_radius_m for seed in seeds) * 1.03
    a_layer = max(int((high[0] - low[0]) / pitch), 1) * max(
        int((high[1] - low[1]) / pitch), 1
    )
    return low[2] + pitch * (np.ceil(len(seeds) / a_layer) + 1)


def settle(
    world: World,
    state: State,
    stage: str,
    *,
    threads: int,
    watch: Watch,
    longest_s: float = LONGEST_S,
    quiet: Settled = QUIET,
) -> State:
    """Run until the seeds lie `quiet`, or for longest_s; the share done is told from
    how the kinetic energy falls."""
    begin, quiet = state.time_s, replace(quiet)
    highest = [1e-12]

    def look(world: World, state: State) -> bool:
        now = kinetic_per_seed(state)
        highest[0] = max(highest[0], now)
        scale = float(state.masses.mean()) * G_M_S2 * 0.006 * quiet.kinetic
        share = np.log(highest[0] / max(now, scale)) / np.log(
            max(highest[0] / scale, 2.0)
        )
        watch(stage, float(np.clip(share, 0.0, 0.99)))
        return quiet(world, state) or state.time_s - begin > longest_s

    return run(world, state, observers=[], until=look, threads=threads, every_s=0.01)
