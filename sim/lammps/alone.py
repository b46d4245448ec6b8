"""One seed or block on its rig in LAMMPS: run as one stage, then shown frame by frame
to the observers that our engine asks.

They end the run where ours would end; LAMMPS's own end comes surely after that.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from benchtwin.sim.engine.observe import Settled
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.step import Every
from benchtwin.sim.engine.world import World
from benchtwin.sim.lammps.follow import read_pushes
from benchtwin.sim.lammps.run import Lammps
from benchtwin.sim.lammps.stage import Stage
from benchtwin.sim.rigs.bench import Watch

LOOK_S = 0.05  # about how often the end is asked for


@dataclass(frozen=True)
class Alone:
    """An engine for `sim.rigs.alone`. name of the stage, title of its input; still,
    over, longest_s: its end, as in `Stage`."""

    lammps: Lammps
    name: str
    title: str
    watch: Watch
    longest_s: float = math.inf
    still: Settled | None = None
    over: str = ""

    def __call__(
        self,
        world: World,
        rng: np.random.Generator,
        longest_s: float,
        observers: Sequence[Every],
    ) -> None:
        """Run the stage and ask each observer at its times; RuntimeError where LAMMPS
        stops."""
        first, shortest = observers[0].seconds, min(o.seconds for o in observers)
        frame_s = first / math.ceil(first / shortest - 1e-9)
        look_s = frame_s * math.ceil(LOOK_S / frame_s)
        longest_s = min(longest_s, self.longest_s)
        stage = Stage(
            self.name,
            world,
            None,
            frame_s,
            look_s,
            longest_s,
            still=self.still,
            over=self.over,
            pushes=True,
        )
        way = self.lammps.run(stage, self.title, self.watch)
        pushes = read_pushes(self.lammps.folder, stage.name, way.steps, stage.step_s)
        due = [0] * len(observers)
        for k, (step, row) in enumerate(zip(way.steps, way.rows, strict=True)):
            state = cast(State, Seen(step * stage.step_s, row, pushes[k]))
            over = False
            for n, observer in enumerate(observers):
                if k == round(due[n] * observer.seconds / frame_s):
                    due[n] += 1
                    over |= bool(observer.look(world, state))
            if over:
                return


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
