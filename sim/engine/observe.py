"""Looking at a state: where its energy is, whether it has settled, what it looked like
along the way."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchtwin.sim.engine import gathering
from benchtwin.sim.engine.bodies import DIAMETER
from benchtwin.sim.engine.kernels import LEDGER_NAMES, T_KINETIC
from benchtwin.sim.engine.state import State, free_energies
from benchtwin.sim.engine.step import tables_of
from benchtwin.sim.engine.world import World


@dataclass(frozen=True)
class Energy:
    """Where the energy of a state is [J]. Everything after `potential` needs
    World(ledger=True).

    elastic_normal, elastic_tangential: stored in the contact springs now. Since the
    start of the run: damping (normal dashpots, and what chosen springs took and hold no
    more); friction (tangential springs, dashpots
    and sliding, less what the springs hold); rolling (resistance and its springs);
    adhesion (normal plug-in laws); body_laws (given to the seeds, like walls: work done
    by moving walls)."""

    kinetic: float
    potential: float
    elastic_normal: float
    elastic_tangential: float
    damping: float
    friction: float
    rolling: float
    adhesion: float
    walls: float
    body_laws: float

    @property
    def mechanical(self) -> float:
        return (
            self.kinetic
            + self.potential
            + self.elastic_normal
            + self.elastic_tangential
        )

    @property
    def dissipated(self) -> float:
        return self.damping + self.friction + self.rolling + self.adhesion

    @property
    def total(self) -> float:
        """What must stay the same: mechanical and dissipated energy, less what walls
        and body laws have put in."""
        return self.mechanical + self.dissipated - self.walls - self.body_laws


def energy(world: World, state: State) -> Energy:
    """The account of a state's energy; seeds that have left the domain took theirs with
    them."""
    sums = state.sums.sum(axis=0)
    spent = dict(zip(LEDGER_NAMES, (float(v) for v in state.ledger), strict=True))
    normal = float(sums[gathering.S_NORMAL])
    tangential = float(sums[gathering.S_TANGENTIAL])
    spent["friction"] -= tangential
    if any(c.law.kind == "spring" for c in world.laws):
        spent["damping"] -= normal
    return Energy(*free_energies(state, world.gravity), normal, tangential, **spent)


def kinetic_per_seed(state: State) -> float:
    """Mean kinetic energy of a seed as of the last step [J], without looking at every
    seed again."""
    return float(state.totals[:, T_KINETIC].sum()) / state.count


@dataclass
class Settled:
    """True once, over a whole window, no seed has moved by more than `displacement` of
    its diameter and the kinetic energy a seed is below `kinetic` of m g d at both its
    ends. Give it to `run` as `until`.

    window_s [s]. A run that is stopped and restarted begins a new window; the state
    itself does not depend on being looked at."""

    window_s: float = 0.1
    displacement: float = 1e-3
    kinetic: float = 1e-6
    _since: float = field(default=-np.inf, init=False)
    _then: np.ndarray | None = field(default=None, init=False)

    def __call__(self, world: World, state: State) -> bool:
        shapes = tables_of(world).shape[state.shapes]
        gravity = float(np.linalg.norm(world.gravity))
        scale = float(np.mean(state.masses * gravity * shapes[:, DIAMETER]))
        if free_energies(state, world.gravity)[0] / state.count > self.kinetic * scale:
            self._then = None
            return False
        if self._then is None or len(self._then) != state.count:
            self._since, self._then = state.time_s, state.positions
            return False
        way = np.linalg.norm(state.positions - self._then, axis=1) / shapes[:, DIAMETER]
        if way.max() > self.displacement:
            self._since, self._then = state.time_s, state.positions
            return False
        return state.time_s - self._since >= self.window_s * (1.0 - 1e-9)


@dataclass
class Track:
    """Collects one number or array a look: `Every(0.001, Track(lambda world, state:
    state.positions[0]))`. times_s and values."""

    what: Callable[[World, State], Any]
    times_s: list = field(default_factory=list)
    values: list = field(default_factory=list)

    def __call__(self, world: World, state: State) -> None:
        self.times_s.append(state.time_s)
        self.values.append(self.what(world, state))
