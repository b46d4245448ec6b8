"""A toss in the simulation."""

from dataclasses import dataclass

import numpy as np

from benchtwin.sim.engine.step import Every
from benchtwin.sim.engine.walls import Plane
from benchtwin.sim.engine.world import Placed
from benchtwin.sim.motion import Motion
from benchtwin.sim.picture import Camera, Look
from benchtwin.sim.rigs.bench import Bench, Frames, no_watch
from benchtwin.sim.rigs.engine import OURS, Way
from benchtwin.twin.setup import Setup


@dataclass(frozen=True)
class Toss:
    """speed_m_s: upwards, at the start; flight_s: how long it is followed."""

    speed_m_s: float = 1.5
    flight_s: float = 0.25


def run_toss(rig: Toss, bench: Bench, rng, *, fps=500.0, watch=no_watch, engine=OURS):
    """One seed of the lot, thrown from 50 mm above the floor."""
    (seed,) = bench.draw(rng, 1)
    up = np.array([[0.0, 0.0, rig.speed_m_s]])
    thrown = Placed((seed,), bench.grain, [[0.0, 0.0, 0.05]], velocities=up)
    world = bench.world(thrown, [Plane("floor", bench.wall)])
    frames = Frames(1, fps)
    way = Way("toss", "flying", rig.flight_s)
    engine.follow(world, rng, way, [Every(1 / fps, frames)], watch)
    motion = Motion(shapes=(seed,), shape_of=np.zeros(1, int), **frames.columns())
    motion.truth["launch_speed_m_s"] = rig.speed_m_s
    return motion


SETUP = Setup(
    Toss,
    run_toss,
    500.0,
    Camera(600, 1000, 0.27, (0.0, 0.0, 0.12), 10.0),
    Look(grey=True),
    one_seed=True,
)
