"""A level plate that is tilted, slowly, until what lies on it has gone."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.step import init, run
from benchtwin.sim.engine.world import World
from benchtwin.sim.rigs.bench import Frames
from benchtwin.sim.rigs.engine import Ours

LIE_S = 0.1  # it comes to rest on the level plate
# the plate is raised by so much at a time; while all lies still, that takes STILL_S
# only, which changes nothing: things let go by angle, not by time
STEP_DEG, STILL_S, MOVES_M_S = 0.5, 0.01, 5e-4
LOOK_S = 1e-3
MOST_DEG = 85.0


@dataclass
class Tilt:
    """Raises the far end (+x) of a plate at rate_deg_s until the one body on it has
    gone travel_m down: in the plate's own axes, gravity turns by steps. what: it is,
    for an error; angle_deg: of the plate so far; frames: where the body was at times at
    which the plate had the angles seen_deg."""

    rate_deg_s: float
    travel_m: float
    what: str
    frames: Frames
    angle_deg: float = 0.0
    seen_deg: list[float] = field(default_factory=list)

    def run(self, world: World, rng: np.random.Generator, engine: Ours) -> float:
        """The angle [deg] at which it had gone; ValueError where it has not by
        MOST_DEG."""
        state = run(world, init(world, rng), LIE_S, threads=engine.threads)
        goal = float(state.positions[0, 0]) - self.travel_m

        def gone(world: World, state: State) -> bool:
            return bool(state.positions[0, 0] <= goal)

        self._look(state)
        while not gone(world, state):
            if self.angle_deg > MOST_DEG:
                raise ValueError(
                    f"{self.what} has not gone {1e3 * self.travel_m:g} mm by"
                    f" {MOST_DEG:g}°"
                )
            world = replace(world, gravity=self._gravity())
            state = self._raised(world, state, gone, engine.threads)
            self._look(state)
        engine.keep(world, state)
        return self.angle_deg

    def _raised(
        self,
        world: World,
        state: State,
        gone: Callable[[World, State], bool],
        threads: int,
    ) -> State:
        """One step on, or as much of it as it takes to be gone."""
        lies = float(np.linalg.norm(state.velocities[0])) < MOVES_M_S
        lasts = STILL_S if lies else STEP_DEG / self.rate_deg_s
        begun, end = state.time_s, state.time_s + lasts

        def over(world: World, state: State) -> bool:
            return state.time_s >= end or gone(world, state)

        state = run(world, state, over, threads=threads, every_s=LOOK_S)
        self.angle_deg += STEP_DEG * min((state.time_s - begun) / lasts, 1.0)
        return state

    def _gravity(self) -> tuple[float, float, float]:
        tilt = np.radians(self.angle_deg)
        return (-G_M_S2 * float(np.sin(tilt)), 0.0, -G_M_S2 * float(np.cos(tilt)))

    def _look(self, state: State) -> None:
        self.frames.take(state, state.time_s)
        self.frames.t_s[-1] = self.angle_deg / self.rate_deg_s
        self.seen_deg.append(self.angle_deg)
