"""What computes a rig's worlds: our own engine here, LAMMPS in `sim.lammps`. A rig says
what there is, who looks on and what ends it; both engines take that."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.engine.observe import Settled, kinetic_per_seed
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.step import Every, init, run
from benchtwin.sim.engine.world import World
from benchtwin.sim.rigs.bench import Columns, Frames, Watch

# packed; it may creep on, with rolling friction of type A
POURED = Settled(window_s=0.05, displacement=0.1, kinetic=3e-4)
QUIET = Settled(window_s=0.05, displacement=1e-2, kinetic=1e-5)
SETTLED_S = 3.0  # at the latest
FLOWN_S = 6.0  # after the lift, at the latest
SETTLED_BED = (
    0.2  # of a radius: how far seeds of a settled bed may overlap at the start
)


@dataclass(frozen=True)
class Way:
    """One body's way on its rig, which observers end. name, and title: what happens, in
    words; longest_s: the end at the latest; overlap: of a radius, allowed at the start.

    For an engine that cannot be asked at every step, what comes surely after the
    observers' end: surely_s, a time; over, a formula in v_x, v_y, v_z [m], the body's
    place, above 0; still, it lies as this says."""

    name: str
    title: str
    longest_s: float
    overlap: float = 1e-3
    surely_s: float = math.inf
    over: str = ""
    still: Settled | None = None


@dataclass(frozen=True)
class Lift:
    """A heap's end: the seeds are out of their vessel after out_s; photo_s: when the
    picture is taken, None: when all lie still."""

    out_s: float
    photo_s: float | None


class Engine(Protocol):
    """What a rig asks of an engine."""

    def follow(
        self,
        world: World,
        rng: np.random.Generator,
        way: Way,
        observers: Sequence[Every],
        watch: Watch,
    ) -> None:
        """Compute a world until an observer ends it."""

    def lay(
        self, world: World, rng: np.random.Generator, watch: Watch
    ) -> tuple[np.ndarray, np.ndarray]:
        """Positions and orientations of seeds that fell until they lie `POURED`."""

    def flow(
        self,
        world: Callable[[float | None], World],
        lift: Lift,
        rng: np.random.Generator,
        fps: float,
        watch: Watch,
    ) -> tuple[Columns, bool]:
        """Let seeds come to rest, lift and wait; the frames (one at the end with fps =
        0), and whether all lie still. world: its lift beginning at a time, None: not.
        """


def forget(world: World, state: State) -> None:
    """Keep nothing of a run's end."""


@dataclass(frozen=True)
class Ours:
    """The engine of `sim.engine`, on so many threads. keep: is told how each run of a
    rig ended."""

    threads: int = 2
    keep: Callable[[World, State], object] = forget

    def follow(
        self,
        world: World,
        rng: np.random.Generator,
        way: Way,
        observers: Sequence[Every],
        watch: Watch,
    ) -> None:
        """As `Engine.follow`."""
        begin = init(world, rng, allowed_overlap=way.overlap)
        end = run(world, begin, way.longest_s, observers, threads=self.threads)
        self.keep(world, end)

    def lay(
        self, world: World, rng: np.random.Generator, watch: Watch
    ) -> tuple[np.ndarray, np.ndarray]:
        """As `Engine.lay`."""
        state = self.settle(world, init(world, rng), "filling", watch, POURED)
        return state.positions, state.orientations

    def flow(
        self,
        world: Callable[[float | None], World],
        lift: Lift,
        rng: np.random.Generator,
        fps: float,
        watch: Watch,
    ) -> tuple[Columns, bool]:
        """As `Engine.flow`."""
        still = world(None)
        placed = init(still, rng, allowed_overlap=SETTLED_BED)
        state = self.settle(still, placed, "coming to rest", watch)
        frames = Frames(placed.count, fps or 1.0, state.time_s)
        flow = Flow(lift, state.time_s, watch)
        filmed = [Every(1 / fps, frames)] if fps > 0 else []
        lifted = world(state.time_s)
        state = run(lifted, state, flow, filmed, threads=self.threads)
        frames.take(state, state.time_s)
        self.keep(lifted, state)
        return frames.columns(), flow.still

    def settle(
        self,
        world: World,
        state: State,
        stage: str,
        watch: Watch,
        quiet: Settled = QUIET,
    ) -> State:
        """Run until the seeds lie `quiet`, or for SETTLED_S; the share done is told
        from how the kinetic energy falls."""
        begin, quiet, highest = state.time_s, replace(quiet), 1e-12

        def look(world: World, state: State) -> bool:
            nonlocal highest
            now = kinetic_per_seed(state)
            highest = max(highest, now)
            scale = float(state.masses.mean()) * G_M_S2 * 0.006 * quiet.kinetic
            whole = math.log(max(highest / scale, 2.0))
            share = math.log(highest / max(now, scale)) / whole
            watch(stage, float(np.clip(share, 0.0, 0.99)))
            return quiet(world, state) or state.time_s - begin > SETTLED_S

        return run(world, state, look, threads=self.threads)


OURS = Ours()


class Flow:
    """An observer that ends the run at the time of the photo, or when nothing moves any
    more behind the lift."""

    def __init__(self, lift: Lift, begin_s: float, watch: Watch) -> None:
        self.lift, self.begin_s, self.watch = lift, begin_s, watch
        self.settled, self.still = replace(QUIET), False

    def __call__(self, world: World, state: State) -> bool:
        since, out_s = state.time_s - self.begin_s, self.lift.out_s
        if since < out_s:
            self.watch("lifting", min(since / out_s, 0.99))
        else:
            self.watch("settling", min(since - out_s, 0.99))
        self.still = self.settled(world, state)
        if self.lift.photo_s is not None:
            return since >= self.lift.photo_s
        return since >= out_s and (self.still or since > out_s + FLOWN_S)
