"""The state of a run: every array that the next step depends on, so that a run can be
stopped, stored and continued bit for bit."""

from copy import copy
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from benchtwin.sim.engine.bodies import MASS, V, W, X

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class State:
    """n bodies with m balls, in the order of the neighbour lists (`ids` tells who is
    who); arrays belong to this state alone.

    step: steps done; dt [s]; ids (n,): place of each body at `init`; motion (n, 10):
    centre [m], velocity [m/s], spin [rad/s], mass [kg]; turn (n, 4): unit quaternion
    (w, x, y, z), principal frame to world; spin (n, 3): angular momentum [kg m²/s];
    load (n, 7): force [N], torque [N m], and the most that rolling friction brakes the
    spin by [N m]; calm (n,): looks in a row at which it lay still (`sleeping.CALM`: it
    sleeps); shape_of, material (n,); ball (m, 4): centre and radius [m]; owner, ball_id
    (m,); path (m,): how far each ball has come since the lists were made, bends
    included [m]. pair_*, wall_*: listed pairs, what contacts remember, whether they
    touch. block_*: first body, pair, wall pair, window row of each block. wall_push_ns
    (walls, 3): time integral of the seeds' push on each wall [N s]; wall_load (walls,
    3): that push now [N]. ledger: see `kernels.LEDGER_NAMES` [J]. removed: ids gone.
    """

    step: int
    dt: float
    skin: float
    ids: Array
    motion: Array
    turn: Array
    spin: Array
    load: Array
    calm: Array
    shape_of: Array
    material: Array
    ball: Array
    owner: Array
    ball_id: Array
    ball_start: Array
    path: Array
    pair_i: Array
    pair_j: Array
    pair_memory: Array
    pair_touch: Array
    wall_i: Array
    wall_p: Array
    wall_memory: Array
    wall_touch: Array
    block_body: Array
    block_pair: Array
    block_wall: Array
    block_window: Array
    sums: Array
    totals: Array
    prim: Array
    prim_ref: Array
    twist: Array
    wall_load: Array
    wall_push_ns: Array
    ledger: Array
    removed: Array

    @property
    def time_s(self) -> float:
        return self.step * self.dt

    @property
    def count(self) -> int:
        """Seeds still in the domain."""
        return len(self.ids)

    @property
    def order(self) -> Array:
        """Rows sorted by id: state.motion[state.order] is in the order of `init`."""
        return np.argsort(self.ids)

    @property
    def positions(self) -> Array:
        """Centres of mass (n, 3) [m], by id; likewise the next ones."""
        return self.motion[self.order, X : X + 3]

    @property
    def velocities(self) -> Array:
        return self.motion[self.order, V : V + 3]

    @property
    def spins(self) -> Array:
        return self.motion[self.order, W : W + 3]

    @property
    def orientations(self) -> Array:
        return self.turn[self.order]

    @property
    def masses(self) -> Array:
        return self.motion[self.order, MASS]

    @property
    def shapes(self) -> Array:
        """Number of each seed's shape, counted over all groups of the world."""
        return self.shape_of[self.order]

    def changed(self, **fields: Any) -> "State":
        """The state with these fields in place of its own: `dataclasses.replace`
        without its constructor, which costs as much as a search for neighbours."""
        new = copy(self)
        vars(new).update(fields)
        return new

    def copy(self) -> "State":
        arrays: dict[str, Any] = {
            f.name: v.copy()
            for f in fields(self)
            if isinstance(v := getattr(self, f.name), np.ndarray)
        }
        return self.changed(**arrays)


def free_energies(
    state: State, gravity: tuple[float, float, float]
) -> tuple[float, float]:
    """Kinetic energy, rotation included, and potential energy [J]."""
    m = state.motion
    kinetic = 0.5 * m[:, MASS] @ (m[:, V : V + 3] ** 2).sum(axis=1)
    kinetic += 0.5 * (m[:, W : W + 3] * state.spin).sum()
    return float(kinetic), -float(m[:, MASS] @ (m[:, X : X + 3] @ np.array(gravity)))


def save(state: State, path: Path | str) -> None:
    """Write a checkpoint (.npz): the whole state, nothing rounded."""
    np.savez(path, **{f.name: getattr(state, f.name) for f in fields(state)})


def load(path: Path | str) -> State:
    """Read a checkpoint written by `save`; it continues in the world it was made in."""
    kinds = {"step": int, "dt": float, "skin": float}
    with np.load(path, allow_pickle=False) as stored:
        missing = {f.name for f in fields(State)} - set(stored.files)
        if missing:
            raise ValueError(
                f"{path} is no checkpoint of this version: {', '.join(sorted(missing))}"
                " missing"
            )
        return State(
            **{
                f.name: (
                    kinds[f.name](stored[f.name]) if f.name in kinds else stored[f.name]
                )
                for f in fields(State)
            }
        )
