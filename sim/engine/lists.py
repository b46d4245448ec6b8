"""Making the neighbour lists of a state anew: seeds outside removed, bodies sorted,
pairs found, memory carried over, blocks cut."""

from functools import cache

import numpy as np
from numba import njit

from benchtwin.sim.engine import neighbours
from benchtwin.sim.engine.bodies import BOUND, X
from benchtwin.sim.engine.compiled import ALLOCATING, fingerprint, kernel
from benchtwin.sim.engine.neighbours import Bodies, Grid
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.walls import Vector
from benchtwin.sim.engine.world import Tables

# ball–ball and ball–primitive pairs up to which all are listed for good, and nothing is
# ever searched
FEW = 600
SKIN = 0.2  # of the smallest ball's diameter; from 0.1 to 0.4 the cost changes little
BODIES_PER_BLOCK = 128
MOST_CELLS_PER_BODY = 4
MOST_BLOCKS = 16  # more make the windows overlap more: 32 cost 3 %, 64 10 %


@cache
def _kernels():
    mark = fingerprint("lists")
    stencil = njit(**ALLOCATING)(neighbours.stencil)
    return {
        "pairs": kernel(neighbours.find_pairs, mark, ALLOCATING, stencil=stencil),
        "walls": kernel(neighbours.find_walls, mark),
        "carry": kernel(neighbours.carry, mark, ALLOCATING),
    }


def choose_skin(radii: np.ndarray, primitives: int, reach: float = 0.0) -> float:
    """Skin [m] of a run's lists; endless where everything may be listed for good.

    Never less than the farthest `reach` [m] of a law: surfaces that still act on each
    other must stay listed."""
    if len(radii) * (len(radii) + 2 * primitives) <= FEW:
        return 1e9
    return max(SKIN * 2.0 * float(np.min(radii)), 1.01 * reach)


def ball_counts(tables: Tables, shape_of: np.ndarray) -> np.ndarray:
    """How many balls each body has (n,)."""
    return np.diff(tables.shape_start)[shape_of]


def relist(
    tables: Tables, state: State, domain: tuple[Vector, Vector] | None = None
) -> State:
    """The state with new lists; same physics, other order. Bodies whose centre is
    outside `domain` are gone."""
    keep = np.arange(state.count)
    if domain is not None:
        centre = state.motion[:, X : X + 3]
        keep = np.flatnonzero(
            ((centre >= domain[0]) & (centre <= domain[1])).all(axis=1)
        )
        if len(keep) == 0:
            raise RuntimeError(
                f"every seed has left the domain {domain[0]} … {domain[1]} by t ="
                f" {state.time_s:.4g} s"
            )
    old, removed = state, state.removed
    if len(keep) < state.count:
        removed = np.concatenate([removed, np.setdiff1d(state.ids, state.ids[keep])])
    order, grid = _grid(tables, state, keep)
    state = _reordered(tables, state, keep[order], removed)
    bodies = Bodies(
        state.motion, state.shape_of, tables.shape, state.ball_start, state.ball
    )
    first_pair, pair_i, pair_j = _pairs(state, bodies, grid)
    before = old.ball_id[old.pair_i], old.ball_id[old.pair_j]
    now = state.ball_id[pair_i], state.ball_id[pair_j]
    memory, touch = _carried(
        before, old.pair_touch, old.pair_memory, now, directed=True
    )
    wall_i, wall_p = _walls(tables, state, bodies, grid)
    before, now = (old.ball_id[old.wall_i], old.wall_p), (state.ball_id[wall_i], wall_p)
    wall_memory, wall_touch = _carried(
        before, old.wall_touch, old.wall_memory, now, directed=False
    )
    blocks = cut_blocks(state.count)
    window = _window(state, blocks, first_pair, pair_j)
    wall_owner = state.owner[wall_i]
    return state.changed(
        pair_i=pair_i,
        pair_j=pair_j,
        pair_memory=memory,
        pair_touch=touch,
        wall_i=wall_i,
        wall_p=wall_p,
        wall_memory=wall_memory,
        wall_touch=wall_touch,
        block_body=blocks,
        block_pair=first_pair[blocks],
        block_wall=np.searchsorted(wall_owner, blocks),
        block_window=window,
        sums=np.zeros((len(blocks) - 1, state.sums.shape[1])),
        totals=np.zeros((len(blocks) - 1, state.totals.shape[1])),
    )


def cut_blocks(count: int) -> np.ndarray:
    """First body of each block, and the end: a matter of the number of bodies alone, so
    that sums do not depend on threads."""
    blocks = min(MOST_BLOCKS, max(1, count // BODIES_PER_BLOCK))
    return np.arange(blocks + 1, dtype=np.int64) * count // blocks


def _grid(tables: Tables, state: State, keep: np.ndarray) -> tuple[np.ndarray, Grid]:
    """Order of the bodies by cell, and the cells: as wide as two bodies that touch, or
    wider rather than many empty ones, the bed's longest side outermost."""
    at = state.motion[keep, X : X + 3]
    low, wide = at.min(axis=0), np.ptp(at, axis=0)
    size = 2.0 * float(tables.shape[state.shape_of[keep], BOUND].max()) + state.skin
    while np.prod(np.floor(wide / size) + 1) > MOST_CELLS_PER_BODY * len(at) + 27:
        size *= 1.25
    sides = (np.floor(wide / size) + 1).astype(np.int64)
    axes = np.argsort(-sides, kind="stable")
    strides = np.empty(3, np.int64)
    strides[axes] = sides[axes[1]] * sides[axes[2]], sides[axes[2]], 1
    cell = np.minimum(((at - low) / size).astype(np.int64), sides - 1) @ strides
    counts = np.bincount(cell, minlength=int(sides.prod()))
    starts = np.concatenate([[0], np.cumsum(counts)])
    order = np.argsort(cell, kind="stable")
    return order, Grid(size, sides, low, strides, axes, starts)


def _reordered(
    tables: Tables, state: State, keep: np.ndarray, removed: np.ndarray
) -> State:
    counts = ball_counts(tables, state.shape_of[keep])
    ball_start = np.concatenate([[0], np.cumsum(counts)])
    within = np.arange(ball_start[-1]) - np.repeat(ball_start[:-1], counts)
    balls = np.repeat(state.ball_start[keep], counts) + within
    return state.changed(
        ids=state.ids[keep],
        motion=state.motion[keep],
        turn=state.turn[keep],
        spin=state.spin[keep],
        load=state.load[keep],
        calm=state.calm[keep],
        shape_of=state.shape_of[keep],
        material=state.material[keep],
        ball=state.ball[balls],
        ball_id=state.ball_id[balls],
        owner=np.repeat(np.arange(len(keep), dtype=np.uint32), counts),
        ball_start=ball_start,
        path=np.zeros(len(balls)),
        prim_ref=state.prim.copy(),
        removed=removed,
    )


def _pairs(state: State, bodies: Bodies, grid: Grid):
    first = np.empty(state.count + 1, np.int64)
    room = max(64, int(1.2 * len(state.pair_i)))
    while True:
        i, j = np.empty(room, np.uint32), np.empty(room, np.uint32)
        count = _kernels()["pairs"](bodies, grid, state.skin, i, j, first)
        if count <= room:
            return first, i[:count].copy(), j[:count].copy()
        room = int(1.1 * count)


def _carried(
    before: tuple[np.ndarray, np.ndarray],
    old_touch: np.ndarray,
    old_memory: np.ndarray,
    now: tuple[np.ndarray, np.ndarray],
    *,
    directed: bool,
) -> tuple[np.ndarray, np.ndarray]:
    """What the contacts `now` remember, and whether they touch, from those before."""
    memory = np.zeros((len(now[0]), old_memory.shape[1]))
    touch = np.zeros(len(now[0]), np.uint8)
    carry = _kernels()["carry"]
    carry(*before, old_touch, old_memory, *now, directed, memory, touch)
    return memory, touch


def _walls(tables: Tables, state: State, bodies: Bodies, grid: Grid):
    room = max(64, int(1.2 * len(state.wall_i)))
    walls = tables.walls
    while True:
        i, p = np.empty(room, np.uint32), np.empty(room, np.uint32)
        count = _kernels()["walls"](
            bodies,
            grid,
            state.skin,
            state.prim,
            walls.kind,
            walls.moving,
            np.empty((3, 2), np.int64),
            i,
            p,
        )
        if count <= room:
            break
        room = int(1.1 * count)
    i, p = i[:count], p[:count]
    # balls of one body on one wall next to each other
    key = state.owner[i].astype(np.int64) * len(state.twist) + walls.wall[p]
    order = np.argsort((key * len(state.ball) + i) * len(walls.kind) + p)
    return i[order], p[order]


def _window(
    state: State, blocks: np.ndarray, first_pair: np.ndarray, pair_j: np.ndarray
) -> np.ndarray:
    """Where each block's window of forces begins: it holds the block's bodies and all
    up to its farthest partner."""
    rows = [0]
    for b in range(len(blocks) - 1):
        partners = pair_j[first_pair[blocks[b]] : first_pair[blocks[b + 1]]]
        end = max(
            int(blocks[b + 1]),
            int(state.owner[partners.max()]) + 1 if len(partners) else 0,
        )
        rows.append(rows[-1] + end - int(blocks[b]))
    return np.array(rows, np.int64)
