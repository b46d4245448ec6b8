"""Drops on a plate of seeds: single seeds fall on seeds that are glued down, and rise
again in any direction; how far tells restitution of seed on seed."""

from dataclasses import dataclass

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.engine.step import Every, init, run
from benchtwin.sim.engine.world import Placed
from benchtwin.sim.motion import Motion
from benchtwin.sim.rigs.bench import Bench, Frames, Watch, no_watch, reach
from benchtwin.sim.rigs.engine import OURS, Ours
from benchtwin.sim.rigs.rise import LOOK_S, Rise
from benchtwin.sim.rigs.seed_plate import SeedPlate, laid, on_glued
from benchtwin.sim.rotation import any_turn
from benchtwin.sim.seed import Seed

HALF_SEEDS = 4.0  # of the plate, in lengths of a seed: what one impact can touch
MIDDLE = 0.3  # of it, where seeds fall
NEAR_M = 2e-3  # above the seeds, where a falling seed begins to look out for them
LONGEST_S = 2.0


@dataclass(frozen=True)
class SeedDrop:
    """height_m: from the tops of the glued seeds up to the seed's lowest point when it
    is let go, turned any way. coverage: share of the plate that seeds cover. drops:
    seeds that fall on the plate, each in a place of its own. glue_loss: share that the
    glue takes of what an impact gives back of the energy."""

    height_m: float = 0.310
    coverage: float = 0.78
    drops: int = 10
    glue_loss: float = 0.0

    def __post_init__(self) -> None:
        if not self.height_m > 0:
            raise ValueError(f"height_m = {self.height_m:g}: must be above 0")
        if self.drops < 1:
            raise ValueError(f"drops = {self.drops}: at least 1 is needed")
        if not 0 <= self.glue_loss < 1:
            raise ValueError(f"glue_loss = {self.glue_loss:g}: must be 0 to below 1")


def run_seed_drop(
    rig: SeedDrop,
    bench: Bench,
    rng: np.random.Generator,
    *,
    fps: float = 1000.0,
    watch: Watch = no_watch,
    engine: Ours = OURS,
) -> Motion:
    """Drop the seeds, each on a part of the plate that is laid for it; the film is that
    of the first. Truth, over all drops: rebound_height_mm, the mean of how far they
    rose from where they touched, and sd_mm between drops."""
    half = HALF_SEEDS * bench.mean_dimensions_m[0]
    seeds, rises, films = bench.draw(rng, rig.drops), [], []
    for k, seed in enumerate(seeds):
        watch("dropping", k / rig.drops)
        plate = laid(bench, rng, rig.coverage, (-half, -half), (half, half))
        frames, rise = Frames(1, fps), Rise(0, reckoned=k > 0)
        _drop(rig, bench, plate, seed, rng, (frames, rise), engine)
        rises.append(1e3 * rise.rise_m)
        films.append((frames, plate))
    frames, plate = films[0]
    motion = Motion(
        shapes=(seeds[0],),
        shape_of=np.zeros(1, int),
        parts=plate.parts(),
        **frames.columns(),
    )
    motion.readings["rebound_height_mm"] = rises
    motion.truth["rebound_height_mm"] = float(np.mean(rises))
    if rig.drops > 1:
        motion.truth["sd_mm"] = float(np.std(rises, ddof=1))
    return motion


def _drop(
    rig: SeedDrop,
    bench: Bench,
    plate: SeedPlate,
    seed: Seed,
    rng: np.random.Generator,
    seen: tuple[Frames, Rise],
    engine: Ours,
) -> None:
    """A seed let go above a place in the middle of the plate: it falls with nothing
    near it, then onto the seeds."""
    frames, rise = seen
    filmed = [Every(1 / frames.fps, frames)]
    turn = any_turn(rng)
    x, y = MIDDLE * np.array(plate.high) * rng.uniform(-1, 1, 2)
    z = plate.top_m + rig.height_m + reach(seed, turn, (0, 0, -1))
    held = Placed((seed,), bench.grain, np.array([[x, y, z]]), turn[None])
    alone = bench.world(held, [plate.board(bench)])
    near_s = np.sqrt(2 * max(rig.height_m - NEAR_M, 0.0) / G_M_S2)
    near_s = np.floor(near_s * frames.fps) / frames.fps
    state = run(alone, init(alone, rng), near_s, filmed, threads=engine.threads)
    falling = Placed(
        (seed,),
        bench.grain,
        state.positions,
        state.orientations,
        state.velocities,
        state.spins,
    )
    glue = on_glued(bench, rig.glue_loss)
    world = bench.world(falling, plate.walls(bench), contacts=[glue])
    frames.begin_s = -near_s
    del frames.t_s[-1], frames.rows[-1]  # the moment is both worlds'
    looks = [Every(LOOK_S, rise), *filmed]
    end = run(world, init(world, rng), LONGEST_S, looks, threads=engine.threads)
    engine.keep(world, end)
