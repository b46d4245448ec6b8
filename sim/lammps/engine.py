"""LAMMPS as a rig's engine: the same worlds, seeds, placing and end as ours, from the
same random numbers.

A body on its rig is run as one stage and then shown frame by frame to the observers
that our engine asks: they end the run where ours would end. A heap has three stages:
fill, rest, and pile, in which part of the vessel is lifted.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from benchtwin.sim.engine.observe import Settled
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.step import Every, init
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.lammps.follow import read_pushes
from benchtwin.sim.lammps.run import Lammps
from benchtwin.sim.lammps.stage import Stage
from benchtwin.sim.rigs.bench import Columns, Watch
from benchtwin.sim.rigs.engine import (
    FLOWN_S,
    POURED,
    QUIET,
    SETTLED_BED,
    SETTLED_S,
    Lift,
    Way,
    forget,
)

ASKED_S = 0.05  # about how often a single body's end is asked for
LOOK_S = 0.01  # and a heap's
FRAME_S = 0.05  # of a heap's places where no film is asked for


@dataclass(frozen=True)
class LammpsEngine:
    """LAMMPS in its folder. Worlds: with a law that LAMMPS has
    (`sim.lammps.contact.in_lammps_law`); RuntimeError says what it stopped with. keep:
    is told how the run of a heap ended, as `heap_of` has it."""

    lammps: Lammps
    keep: Callable[[World, State], object] = forget

    def follow(
        self,
        world: World,
        rng: np.random.Generator,
        way: Way,
        observers: Sequence[Every],
        watch: Watch,
    ) -> None:
        """As `sim.rigs.engine.Engine.follow`."""
        first, shortest = observers[0].seconds, min(o.seconds for o in observers)
        frame_s = first / math.ceil(first / shortest - 1e-9)
        stage = Stage(
            way.name,
            world,
            None,
            frame_s,
            frame_s * math.ceil(ASKED_S / frame_s),
            min(way.longest_s, way.surely_s),
            still=way.still,
            over=way.over,
            pushes=True,
        )
        found = self.lammps.run(stage, way.title, watch)
        pushes = read_pushes(self.lammps.folder, stage.name, found.steps, stage.step_s)
        due = [0] * len(observers)
        for k, (step, row) in enumerate(zip(found.steps, found.rows, strict=True)):
            state = cast(State, Seen(step * stage.step_s, row, pushes[k]))
            over = False
            for n, observer in enumerate(observers):
                if k == round(due[n] * observer.seconds / frame_s):
                    due[n] += 1
                    over |= bool(observer.look(world, state))
            if over:
                return

    def lay(
        self, world: World, rng: np.random.Generator, watch: Watch
    ) -> tuple[np.ndarray, np.ndarray]:
        """As `sim.rigs.engine.Engine.lay`."""
        last = self._settle("fill", "filling", world, watch, POURED)
        return last[:, :3], last[:, 3:7]

    def flow(
        self,
        world: Callable[[float | None], World],
        lift: Lift,
        rng: np.random.Generator,
        fps: float,
        watch: Watch,
    ) -> tuple[Columns, bool]:
        """As `sim.rigs.engine.Engine.flow`."""
        lain = self._settle("rest", "coming to rest", world(None), watch, QUIET)
        lifted = world(0.0)
        placed = replace(cast(Placed, lifted.seeds[0]), orientations=lain[:, 3:7])
        frame_s = 1 / fps if fps > 0 else FRAME_S
        photo = lift.photo_s is not None
        pile = Stage(
            "pile",
            replace(lifted, seeds=(placed,)),
            "rest",
            frame_s,
            max(round(LOOK_S / frame_s), 1) * frame_s if fps > 0 else LOOK_S,
            lift.out_s + FLOWN_S if lift.photo_s is None else lift.photo_s,
            least_s=0.0 if photo else lift.out_s,
            still=None if photo else QUIET,
        )
        found = self.lammps.run(pile, "lifting and settling", watch)
        if self.keep is not forget:
            time_s = float(found.steps[-1]) * pile.step_s
            self.keep(*heap_of(lifted, found.rows[-1], time_s))
        return found.columns(pile.step_s), self.lammps.still(pile)

    def _settle(
        self, name: str, title: str, world: World, watch: Watch, quiet: Settled
    ) -> np.ndarray:
        """The seeds' rows, as `follow.Way` has them, once they lie `quiet`."""
        stage = Stage(name, world, None, FRAME_S, LOOK_S, SETTLED_S, still=quiet)
        return self.lammps.run(stage, title, watch).rows[-1]


def heap_of(world: World, rows: np.ndarray, time_s: float) -> tuple[World, State]:
    """LAMMPS's heap, rows (seeds, 13) as `follow.Way` has them, as a state of ours in
    the world without what was lifted: normal forces follow from the overlaps by the
    same law, and friction's springs begin anew."""
    there, lifted = np.isfinite(rows).all(axis=1), cast(Placed, world.seeds[0])
    rows = rows[there]  # without seeds that left
    placed = replace(
        lifted,
        positions=rows[:, :3],
        orientations=rows[:, 3:7],
        velocities=rows[:, 7:10],
        spins=rows[:, 10:13],
        shape_of=None if lifted.shape_of is None else lifted.shape_of[there],
    )
    standing = tuple(wall for wall in world.walls if not wall.moves)
    world = replace(world, seeds=(placed,), walls=standing)
    state = init(world, np.random.default_rng(0), allowed_overlap=SETTLED_BED)
    return world, replace(state, step=round(time_s / state.dt))


@dataclass(frozen=True, eq=False)
class Seen:
    """What observers read of a `State`: rows (seeds, 13) as `follow.Way` has them."""

    time_s: float
    rows: np.ndarray
    wall_push_ns: np.ndarray

    @property
    def ids(self) -> np.ndarray:
        return np.arange(len(self.rows))

    @property
    def positions(self) -> np.ndarray:
        return self.rows[:, 0:3]

    @property
    def orientations(self) -> np.ndarray:
        return self.rows[:, 3:7]

    @property
    def velocities(self) -> np.ndarray:
        return self.rows[:, 7:10]

    @property
    def spins(self) -> np.ndarray:
        return self.rows[:, 10:13]
