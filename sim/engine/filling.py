"""Where seeds start: as placed, or scattered at random."""

import numpy as np
from scipy.spatial import cKDTree

from benchtwin.sim.engine.world import Placed, Scattered, World

APART = 1.01  # bounding radii that are kept free round every seed
DRAWS = 1000  # of as many places as there are seeds, until they are taken for too many


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
    """Draw shapes, places and orientations for a scattered group."""
    turns = rng.normal(size=(max(group.count, 0), 4))
    return Placed(
        shapes=group.shapes,
        material=group.material,
        positions=_random_places(group, rng),
        orientations=turns / np.linalg.norm(turns, axis=1, keepdims=True),
        velocities=np.tile(np.asarray(group.velocity, float), (len(turns), 1)),
        shape_of=rng.integers(0, len(group.shapes), len(turns)),
    )


def _random_places(group: Scattered, rng: np.random.Generator) -> np.ndarray:
    """Centres (count, 3) [m] by random sequential addition: places are drawn evenly,
    and one nearer to an earlier one than two bounding spheres is drawn again."""
    bound = APART * max(seed.bounding_radius_m for seed in group.shapes)
    low, high = np.asarray(group.low) + bound, np.asarray(group.high) - bound
    middle, half = (low + high) / 2, (high - low) / 2
    places = np.zeros((0, 3))
    for _ in range(DRAWS if (half > 0).all() else 0):
        drawn = rng.uniform(low, high, (group.count, 3))
        if group.round:
            across = (drawn - middle) / half
            drawn = drawn[(across[:, :2] ** 2).sum(axis=1) <= 1.0]
        both = np.concatenate([places, drawn])
        near = cKDTree(both).query_pairs(2.0 * bound, output_type="ndarray")
        places = np.delete(both, near.max(axis=1), axis=0)[: group.count]
        if len(places) == group.count > 0:
            return places
    raise ValueError(
        f"seeds: count = {group.count} do not fit between {group.low} and"
        f" {group.high}: {len(places)} lie there at random without touching"
    )
