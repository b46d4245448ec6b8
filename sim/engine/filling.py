"""Where seeds start: as placed, or scattered on a shaken grid; overlapping ones are
refused."""

import numpy as np

from benchtwin.sim.engine.world import Placed, Scattered, World

# grid pitch over the largest seed's bounding diameter; half of the rest is the shake
SLACK = 1.02


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
    low, high = np.asarray(group.low, float), np.asarray(group.high, float)
    bound = max(seed.bounding_radius_m for seed in group.shapes)
    pitch = 2.0 * bound * SLACK
    per_side = np.floor((high - low) / pitch + 1e-9).astype(int)
    if (per_side < 1).any() or group.count < 1 or group.count > per_side.prod():
        room = int(per_side.clip(0).prod())
        raise ValueError(
            f"seeds: count = {group.count} do not fit between {group.low} and"
            f" {group.high}: 1 to {room} do without touching"
        )
    grid = np.stack(np.unravel_index(np.arange(group.count), per_side[::-1]), axis=1)[
        :, ::-1
    ]  # x fastest, z slowest
    spare = (high - low - per_side * pitch) / 2.0
    centres = low + spare + (grid + 0.5) * pitch
    centres[:, 2] -= spare[2]  # layers from the bottom up
    shake = rng.uniform(-0.5, 0.5, (group.count, 3)) * (pitch - 2.0 * bound)
    turns = rng.normal(size=(group.count, 4))
    return Placed(
        shapes=group.shapes,
        material=group.material,
        positions=centres + shake,
        orientations=turns / np.linalg.norm(turns, axis=1, keepdims=True),
        velocities=np.tile(np.asarray(group.velocity, float), (group.count, 1)),
        shape_of=rng.integers(0, len(group.shapes), group.count),
    )
