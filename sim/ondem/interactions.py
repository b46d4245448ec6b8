"""The contacts of a state as arrays: who touches whom, where, with what force."""

from dataclasses import dataclass

import numpy as np

from benchtwin.sim.engine.gathering import OWN_FIRST
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.step import tables_of
from benchtwin.sim.engine.surfaces import nearest
from benchtwin.sim.engine.world import Tables, World, restitution_between
from benchtwin.sim.laws.law import NORMAL_KINDS

PAIR_MODULUS, PAIR_SHEAR = 0, 1  # columns of `Tables.pairs`: E*, G* [Pa]
IMPACT = 3  # column of what a contact remembers: the impact's speed [m/s]


@dataclass(frozen=True, eq=False)
class Interactions:
    """k contacts, those between seeds before those with walls.

    first (k,): row of a ball in `State.ball`; second (k,): that of the other ball, or
    the wall's number; on_wall (k,): which it is;
    points (k, 3) [m], in the middle of the overlap; normals (k, 3): unit vectors from
    the second to the first; overlaps_m (k,); pressing_n (k,): what the normal spring
    and adhesion push the two apart with; shear_n (k, 3): what the tangential spring
    does to the first. Dashpots, which
    do nothing at rest, are left out."""

    first: np.ndarray
    second: np.ndarray
    on_wall: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    overlaps_m: np.ndarray
    pressing_n: np.ndarray
    shear_n: np.ndarray


def interactions(world: World, state: State) -> Interactions:
    """All contacts of a state of this world."""
    tables = tables_of(world)
    kinds = tables.materials
    pairs, walls = np.flatnonzero(state.pair_touch), np.flatnonzero(state.wall_touch)
    i, j = state.pair_i[pairs].astype(int), state.pair_j[pairs].astype(int)
    w, prim = state.wall_i[walls].astype(int), state.wall_p[walls].astype(int)
    between, on_wall = _between(state, i, j), _on_walls(tables, state, w, prim)
    normals, gaps, radii = (
        np.concatenate(both) for both in zip(between, on_wall, strict=True)
    )
    first = np.concatenate([i, w])
    of_first = state.material[state.owner[first]].astype(int)
    of_walls = tables.wall_material[tables.walls.wall[prim]].astype(int)
    of_second = np.concatenate([state.material[state.owner[j]], of_walls]).astype(int)
    memory = np.concatenate([state.pair_memory[pairs], state.wall_memory[walls]])
    numbers = tables.pairs[of_first * len(kinds) + of_second]
    root = np.sqrt(radii * np.maximum(gaps, 0.0))
    pressing = 4.0 / 3.0 * numbers[:, PAIR_MODULUS] * root * np.maximum(gaps, 0.0)
    shear = 8.0 * numbers[:, PAIR_SHEAR] * root
    between = of_first, of_second
    _by_laws(world, between, gaps, radii, numbers, memory, pressing, shear)
    to_first = state.ball[first, 3] - 0.5 * gaps
    return Interactions(
        first=first,
        second=np.concatenate([j, tables.walls.wall[prim]]),
        on_wall=np.repeat([False, True], [len(i), len(prim)]),
        points=state.ball[first, :3] - normals * to_first[:, None],
        normals=normals,
        overlaps_m=gaps,
        pressing_n=pressing,
        shear_n=-shear[:, None] * memory[:, :3],
    )


def _between(state: State, i: np.ndarray, j: np.ndarray) -> tuple[np.ndarray, ...]:
    """Normals from ball j to ball i, overlaps, effective radii."""
    apart = state.ball[i, :3] - state.ball[j, :3]
    distance = np.linalg.norm(apart, axis=1)
    a, b = state.ball[i, 3], state.ball[j, 3]
    return apart / distance[:, None], a + b - distance, a * b / (a + b)


def _on_walls(
    tables: Tables, state: State, i: np.ndarray, prim: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Normals from faces of walls to balls, overlaps, radii."""
    found = [
        nearest(tables.walls.kind[p], state.prim[p], *state.ball[b, :3])[:4]
        for b, p in zip(i, prim, strict=True)
    ]
    told, radii = np.array(found).reshape(-1, 4), state.ball[i, 3]
    return told[:, :3], radii - told[:, 3], radii


def _by_laws(
    world: World,
    between: tuple[np.ndarray, np.ndarray],
    gaps: np.ndarray,
    radii: np.ndarray,
    numbers: np.ndarray,
    memory: np.ndarray,
    pressing: np.ndarray,
    shear: np.ndarray,
) -> None:
    """Put what chosen laws along the normal give at rest into `pressing` [N], and a
    spring's stiffness into `shear` [N/m] (k,)."""
    names, at = list(world.materials), OWN_FIRST
    added = np.zeros(len(gaps))
    for chosen in (c for c in world.active_laws if c.law.kind in NORMAL_KINDS):
        kept = slice(at, at + len(chosen.law.memory))
        at = kept.stop
        for k, (a, b) in enumerate(zip(*between, strict=True)):
            one, other = names[a], names[b]
            if chosen.acts_between(one, other):
                modulus, shear_modulus = numbers[k, [PAIR_MODULUS, PAIR_SHEAR]]
                impact = memory[k, IMPACT] if memory.shape[1] > IMPACT else 0.0
                e = restitution_between(world, one, other, impact)
                of_pair, before = (radii[k], modulus, e), tuple(memory[k, kept])
                told, _ = chosen.along_normal(gaps[k], 0.0, of_pair, before)
                if chosen.law.kind == "spring":
                    pressing[k] = told[0]
                    shear[k] = 4.0 * shear_modulus / modulus * told[2]
                else:
                    added[k] += told[0]
    pressing += added
