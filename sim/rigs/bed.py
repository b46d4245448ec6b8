"""Bed: single seeds fall onto a bed of seeds and rise again, a little: what restitution
of seed on seed leaves, with friction and the bed's own give averaged over (Beladjine,
Ammi, Oger & Valance 2007, Phys. Rev. E 75, 061305)."""

from dataclasses import dataclass

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.engine.step import Every
from benchtwin.sim.engine.walls import Rectangle, Wall
from benchtwin.sim.engine.world import Placed
from benchtwin.sim.motion import Motion
from benchtwin.sim.rigs.bench import Bench, Frames, Watch, no_watch, reach
from benchtwin.sim.rigs.engine import OURS, SETTLED_BED, Engine, Way
from benchtwin.sim.rigs.filling import Chute, Filled
from benchtwin.sim.rigs.heap import Vessel, fill
from benchtwin.sim.rigs.parts import slab
from benchtwin.sim.rigs.rise import LOOK_S, ONE_IMPACT_S, Rise
from benchtwin.sim.rotation import any_turn
from benchtwin.sim.seed import Seed

MIDDLE = 1 / 3  # of the box's length and width: where seeds fall, clear of its walls
THICKNESS_M = 3e-3
STAYED_M = 1e-3  # a rise that nobody sees


@dataclass(frozen=True)
class Bed:
    """box_m: inside length (x), width (y) and height of the box; depth_m: of the bed,
    struck off there. height_m: from the bed's surface up to the seed's lowest point
    when it is let go, turned any way. drops: seeds that fall on one bed, one after the
    other, each on the bed as it was."""

    box_m: tuple[float, float, float] = (0.060, 0.060, 0.050)
    depth_m: float = 0.025
    height_m: float = 0.150
    drops: int = 10

    def __post_init__(self) -> None:
        if not all(v > 0 for v in (*self.box_m, self.depth_m, self.height_m)):
            raise ValueError(f"every length must be above 0 in {self}")
        if self.depth_m > self.box_m[2]:
            raise ValueError(
                f"depth_m = {self.depth_m:g}: the box is only {self.box_m[2]:g} m high"
            )
        if self.drops < 1:
            raise ValueError(f"drops = {self.drops}: at least 1 is needed")


def run_bed(
    rig: Bed,
    bench: Bench,
    rng: np.random.Generator,
    *,
    fps: float = 200.0,
    watch: Watch = no_watch,
    engine: Engine = OURS,
) -> Motion:
    """Lay the bed, drop the seeds; the film is that of the first. Truth, over all
    drops: bed_rebound_mm, the mean of how far they rose, and its sd between drops;
    stayed, the share that rose by less than `STAYED_M`."""
    filled = fill(_vessel(rig, bench), bench, rng, engine, watch)
    seeds = bench.draw(rng, rig.drops)
    rises: list[float] = []
    motion = None
    for k, seed in enumerate(seeds):
        watch("dropping", k / rig.drops)
        dropped = _dropped(rig, bench, filled, seed, rng)
        count = len(filled.shape_of) + 1
        frames = Frames(count, fps)
        fall = Rise(count - 1)
        looks = [Every(LOOK_S, fall)]
        looks += [Every(1 / fps, frames)] if motion is None else []
        world = bench.world(dropped, _walls(rig, bench, 0.0), sleep=bench.sleep)
        speed = np.sqrt(2 * G_M_S2 * rig.height_m)
        longest = 2 * speed / G_M_S2 + 2 * ONE_IMPACT_S
        way = Way("bed", "falling on the bed", longest, overlap=SETTLED_BED)
        engine.follow(world, rng, way, looks, watch)
        rises.append(fall.rise_m)
        if motion is None:
            motion = Motion(
                shapes=dropped.shapes,
                shape_of=np.asarray(dropped.shape_of),
                parts=_parts(rig),
                **frames.columns(),
            )
    assert motion is not None  # there is at least one drop
    rise = np.array(rises)
    motion.truth.update(
        bed_rebound_mm=float(1e3 * rise.mean()),
        stayed=float((rise < STAYED_M).mean()),
        first_rebound_mm=float(1e3 * rise[0]),
    )
    if rise.size > 1:
        motion.truth["sd_mm"] = float(1e3 * rise.std(ddof=1))
    return motion


def _dropped(
    rig: Bed, bench: Bench, filled: Filled, seed: Seed, rng: np.random.Generator
) -> Placed:
    """The bed, and a seed above it that is let go."""
    turn = any_turn(rng)
    half = MIDDLE / 2 * np.array(rig.box_m[:2])
    x, y = rng.uniform(-half, half)
    z = rig.depth_m + rig.height_m + reach(seed, turn, (0, 0, -1))
    shapes = (*filled.shapes, seed)
    return Placed(
        shapes,
        bench.grain,
        np.vstack([filled.positions_m, [x, y, z]]),
        np.vstack([filled.orientations, turn]),
        shape_of=np.append(filled.shape_of, len(shapes) - 1),
    )


def _vessel(rig: Bed, bench: Bench) -> Vessel:
    """The box as something that is filled; it is never opened."""
    x, y, z = rig.box_m
    return Vessel(
        chute=Chute((-x / 2, -y / 2, 0.0), (x / 2, y / 2, z)),
        volume_m3=x * y * rig.depth_m,
        fill_height_m=rig.depth_m,
        lift_m_s=1.0,
        lift_m=z,
        photo_s=None,
        walls=lambda tall, lift: _walls(rig, bench, tall),
        domain=((-x, -y, -0.03), (x, y, 2.0)),
        opening_m=min(x, y),
        parts=_parts(rig),
    )


def _walls(rig: Bed, bench: Bench, tall: float) -> list[Wall]:
    """Floor and four sides, as high as the box or up to `tall`."""
    (x, y, z), of = rig.box_m, bench.wall
    up, along, across = (0, 0, max(tall, z)), (x, 0, 0), (0, y, 0)
    corner = (-x / 2, -y / 2, 0)
    return [
        Rectangle("floor", of, corner, along, across),
        Rectangle("near side", of, corner, along, up),
        Rectangle("far side", of, (-x / 2, y / 2, 0), along, up),
        Rectangle("left side", of, corner, across, up),
        Rectangle("right side", of, (x / 2, -y / 2, 0), across, up),
    ]


def _parts(rig: Bed):
    """The floor and the sides beside the bed; the near one would hide it."""
    (x, y, z), t = rig.box_m, THICKNESS_M
    x, y = x / 2, y / 2
    return (
        slab("floor", (-x, -y, -t), (x, y, 0.0)),
        slab("left side", (-x - t, -y, -t), (-x, y, z)),
        slab("right side", (x, -y, -t), (x + t, y, z)),
    )
