"""Where seeds start: as placed, or scattered at random; and that they are apart."""

import numpy as np
from scipy.spatial import cKDTree

from benchtwin.sim.engine.neighbours import extent
from benchtwin.sim.engine.surfaces import PLANE, nearest
from benchtwin.sim.engine.walls import WallTables
from benchtwin.sim.engine.world import Placed, Scattered, World
from benchtwin.sim.rotation import turned

APART = 1.01  # radii that are kept free round every ball
DRAWS = 2000  # of a place for every seed, until they are taken for too many


def place(world: World, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """Shape number (over all groups), centre, orientation, velocity, spin of every
    seed, group by group."""
    parts, first = [], 0
    for k, group in enumerate(world.seeds):
        placed = scatter(group, rng) if isinstance(group, Scattered) else group
        parts.append(_columns(placed, first, f"seeds[{k}]"))
        first += len(group.shapes)
    return tuple(np.concatenate(column) for column in zip(*parts, strict=True))


def _columns(group: Placed, first: int, where: str):
    x = np.asarray(group.positions, float).reshape(-1, 3)
    n = len(x)
    if group.orientations is None:
        q = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    else:
        q = np.array(group.orientations, float).reshape(-1, 4)
    v, w = (
        np.zeros((n, 3)) if a is None else np.asarray(a, float).reshape(-1, 3)
        for a in (group.velocities, group.spins)
    )
    kind = (
        np.zeros(n, int) if group.shape_of is None else np.asarray(group.shape_of, int)
    )
    for name, array in (
        ("positions", x),
        ("orientations", q),
        ("velocities", v),
        ("spins", w),
    ):
        if len(array) != n or not np.isfinite(array).all():
            raise ValueError(
                f"{where}.{name}: {n} rows of finite numbers are needed, not"
                f" {array.shape} with {array}"
            )
    if n == 0 or len(kind) != n or kind.min() < 0 or kind.max() >= len(group.shapes):
        raise ValueError(
            f"{where}.shape_of: {n} numbers of shapes 0 … {len(group.shapes) - 1} are"
            f" needed, not {kind}"
        )
    length = np.linalg.norm(q, axis=1, keepdims=True)
    if not (np.abs(length - 1.0) < 1e-3).all():
        raise ValueError(
            f"{where}.orientations: unit quaternions (w, x, y, z) are needed, not of"
            f" length {length.min()} … {length.max()}"
        )
    return kind + first, x, q / length, v, w


def scatter(group: Scattered, rng: np.random.Generator) -> Placed:
    """Draw shapes, places and orientations for a scattered group.

    Places by random sequential addition: they are drawn evenly, and a seed that touches
    one that lies there already is drawn again."""
    count = max(group.count, 0)
    shape_of = group.shape_of
    if shape_of is None:
        shape_of = rng.integers(0, len(group.shapes), count)
    turns = rng.normal(size=(count, 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    arms, radii, owner = _balls(group.shapes, shape_of, turns)
    at, left = np.full((count, 3), np.nan), np.arange(count)
    for _ in range(DRAWS):
        at[left] = _drawn(group, len(left), rng)
        left = _touching(at[owner] + arms, radii, owner, left)
        if not len(left):
            break
    if len(left) or count == 0:
        raise ValueError(
            f"seeds: count = {count} do not fit between {group.low} and {group.high}:"
            f" {count - len(left)} lie there at random without touching"
        )
    velocities = np.tile(np.asarray(group.velocity, float), (count, 1))
    return Placed(group.shapes, group.material, at, turns, velocities, None, shape_of)


def _balls(
    shapes: tuple, shape_of: np.ndarray, turns: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of all balls: where they are about their seed's centre [m], radius [m], seed."""
    seeds = [shapes[k] for k in shape_of]
    radii = [np.atleast_1d(seed.radii_m) for seed in seeds]
    owner = np.repeat(np.arange(len(seeds)), [len(r) for r in radii])
    centres = np.concatenate([np.zeros((0, 3)), *(seed.centres_m for seed in seeds)])
    arms = turned(turns[owner], centres)
    return arms, np.concatenate([np.zeros(0), *radii]), owner


def _drawn(group: Scattered, count: int, rng: np.random.Generator) -> np.ndarray:
    """Centres (count, 3) [m], evenly within the group's room."""
    bound = APART * max(seed.bounding_radius_m for seed in group.shapes)
    low, high = np.asarray(group.low) + bound, np.asarray(group.high) - bound
    if not (high > low).all():
        return np.zeros((count, 3))  # all in one place: they do not fit
    if not group.round:
        return rng.uniform(low, high, (count, 3))
    turn, out = rng.uniform(0, 2 * np.pi, count), np.sqrt(rng.uniform(size=count))
    inside = np.column_stack([out * np.cos(turn), out * np.sin(turn)])
    middle, half = (low + high)[:2] / 2, (high - low)[:2] / 2
    return np.column_stack(
        [middle + half * inside, rng.uniform(low[2], high[2], count)]
    )


def _touching(
    places: np.ndarray, radii: np.ndarray, owner: np.ndarray, new: np.ndarray
) -> np.ndarray:
    """Which of the new seeds touch one that lies there, or a new one before them."""
    fresh = np.isin(owner, new)
    drawn, lying = np.flatnonzero(fresh), np.flatnonzero(~fresh)
    reach, tree = 2.0 * APART * radii.max(initial=0.0), cKDTree(places[drawn])
    i, j = drawn[tree.query_pairs(reach, output_type="ndarray").T]
    if len(lying):
        near = tree.sparse_distance_matrix(
            cKDTree(places[lying]), reach, output_type="ndarray"
        )
        i = np.concatenate([i, drawn[near["i"]]])
        j = np.concatenate([j, lying[near["j"]]])
    far = np.linalg.norm(places[i] - places[j], axis=1)
    touch = (far < APART * (radii[i] + radii[j])) & (owner[i] != owner[j])
    one, other = owner[i[touch]], owner[j[touch]]
    later = np.where(fresh[j[touch]], np.maximum(one, other), one)
    return np.unique(later)


def check_apart(
    world: World, walls: WallTables, ball: np.ndarray, owner: np.ndarray, allowed: float
) -> None:
    """ValueError where two seeds, or a seed and a wall, overlap by more than `allowed`
    of the smaller ball's radius. ball (m, 4): centres, radii [m]; owner (m,): seeds."""
    at, radii = ball[:, :3], ball[:, 3]
    i, j = cKDTree(at).query_pairs(2.0 * radii.max(), output_type="ndarray").T
    i, j = i[owner[i] != owner[j]], j[owner[i] != owner[j]]
    overlap = radii[i] + radii[j] - np.linalg.norm(at[i] - at[j], axis=1)
    share = overlap / np.minimum(radii[i], radii[j])
    worst, first, other = 0.0, 0, ""
    if len(i):
        k = int(share.argmax())
        one, two = sorted((int(owner[i[k]]), int(owner[j[k]])))
        worst, first, other = float(share[k]), one, f"seed {two}"
    for p, row in enumerate(walls.prim):
        for b in _near(at, radii, int(walls.kind[p]), row):
            share_b = 1.0 - nearest(walls.kind[p], row, *at[b])[3] / radii[b]
            if share_b > worst:
                name = world.walls[walls.wall[p]].name
                worst, first, other = share_b, int(owner[b]), f"wall {name!r}"
    if worst > allowed:
        raise ValueError(
            f"seeds: seed {first} and {other} overlap by {100 * worst:.2g} % of the"
            f" smaller ball's radius at the start; {100 * allowed:.2g} % is allowed"
        )


def _near(at: np.ndarray, radii: np.ndarray, kind: int, row: np.ndarray) -> np.ndarray:
    """Balls that may touch a primitive."""
    if kind == PLANE:
        return np.flatnonzero((at - row[:3]) @ row[3:6] < radii)
    low, high = np.array([extent(kind, row, k) for k in range(3)]).T
    apart = np.maximum(low - at, at - high).max(axis=1)
    return np.flatnonzero(apart < radii)
