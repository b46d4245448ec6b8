"""Motions placed by hand for the tests of pictures: a cone of seeds, a falling seed,
seeds on a plate that tilts."""

import numpy as np

from benchtwin.sim.motion import Motion, Part
from benchtwin.sim.seed import Seed
from benchtwin.sim.seed.surface import Mesh

SOYBEAN = Seed.from_dimensions(8.72e-3, 6.84e-3, 5.98e-3)
PITCH_M = 6.6e-3  # of the lattice that the heap is cut from


def slab(low_m, high_m) -> Mesh:
    """A cuboid between two corners."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    faces = [
        (0, 1, 3),
        (0, 3, 2),
        (4, 6, 7),
        (4, 7, 5),
        (0, 4, 5),
        (0, 5, 1),
        (2, 3, 7),
        (2, 7, 6),
        (0, 2, 6),
        (0, 6, 4),
    ]
    faces += [(1, 5, 7), (1, 7, 3)]
    out = (2.0 * corners - 1.0) / np.sqrt(3.0)
    return Mesh(
        np.where(corners == 0, low_m, high_m).astype(float), np.array(faces), out
    )


def still(
    positions_m, orientations, *, shapes=(SOYBEAN,), shape_of=None, parts=()
) -> Motion:
    """One moment, nothing moving."""
    positions = np.asarray(positions_m, dtype=float).reshape(1, -1, 3)
    who = (
        np.zeros(positions.shape[1], int) if shape_of is None else np.asarray(shape_of)
    )
    rest = np.zeros_like(positions)
    turns = np.asarray(orientations, dtype=float).reshape(1, -1, 4)
    return Motion(
        np.zeros(1), tuple(shapes), who, positions, turns, rest, rest, tuple(parts)
    )


def heap(
    seeds: int = 3500, angle_deg: float = 30.0, rng: np.random.Generator | None = None
) -> Motion:
    """The `seeds` lowest places under a cone's surface, on a plate as wide as it takes;
    columns shifted: no steps."""
    rng = rng or np.random.default_rng(1)
    reach = np.arange(-30, 31) * PITCH_M
    x, y, z = np.meshgrid(
        reach, reach, np.arange(0, 30) * 0.85 * PITCH_M + 3.4e-3, indexing="ij"
    )
    z[:, :, 1:] += rng.uniform(0.0, 0.85 * PITCH_M, z.shape[:2])[:, :, None]
    x, y, z = x.ravel(), y.ravel(), z.ravel()
    under = z + np.tan(np.radians(angle_deg)) * np.hypot(
        x, y
    )  # height of the cone that just holds it
    chosen = np.argsort(under, kind="stable")[:seeds]
    places = np.c_[x, y, z][chosen] + rng.uniform(-0.8e-3, 0.8e-3, (seeds, 3)) * [
        1,
        1,
        0.3,
    ]
    turns = rng.standard_normal((seeds, 4))
    half = float(np.abs(places[:, :2]).max()) + 0.02
    plate = Part("plate", slab((-half, -half, -0.005), (half, half, 0.0)))
    return still(
        places, turns / np.linalg.norm(turns, axis=1, keepdims=True), parts=(plate,)
    )


def drop(
    frames: int = 40,
    fps: float = 1000.0,
    start_s: float = 0.15,
    spin_rad_s: float = 20.0,
) -> Motion:
    """A seed that falls from 310 mm on to a plate, turning as it goes."""
    time_s = start_s + np.arange(frames) / fps
    place, speed, spin = (
        np.zeros((frames, 1, 3)),
        np.zeros((frames, 1, 3)),
        np.zeros((frames, 1, 3)),
    )
    place[:, 0, 2] = 0.31 + 3e-3 - 0.5 * 9.81 * time_s**2
    speed[:, 0, 2], spin[:, 0, 1] = -9.81 * time_s, spin_rad_s
    turns = np.zeros((frames, 1, 4))
    turns[:, 0, 0], turns[:, 0, 2] = (
        np.cos(spin_rad_s * time_s / 2),
        np.sin(spin_rad_s * time_s / 2),
    )
    plate = Part("plate", slab((-0.1, -0.1, -0.01), (0.1, 0.1, 0.0)))
    return Motion(
        time_s, (SOYBEAN,), np.zeros(1, int), place, turns, speed, spin, (plate,)
    )


def slide(frames: int = 20, fps: float = 50.0, rate_deg_s: float = 10.0) -> Motion:
    """Four seeds at rest on a plate that tilts about its left edge, its right end
    rising."""
    time_s = np.arange(frames) / fps
    tilt = np.radians(10.0 + rate_deg_s * time_s)
    turn = np.zeros((frames, 4))
    turn[:, 0], turn[:, 2] = np.cos(tilt / 2), -np.sin(tilt / 2)
    along, up = (
        np.c_[np.cos(tilt), 0 * tilt, np.sin(tilt)],
        np.c_[-np.sin(tilt), 0 * tilt, np.cos(tilt)],
    )
    seat = 0.15 + 3.5e-3 * np.array([-1, -1, 1, 1])
    depth = 3.5e-3 * np.array([-1, 1, -1, 1])[:, None] * [0.0, 1.0, 0.0]
    places = seat[None, :, None] * along[:, None] + 3e-3 * up[:, None] + depth
    speed = np.gradient(places, time_s, axis=0)
    spin = np.zeros_like(places)
    spin[:, :, 1] = -np.radians(rate_deg_s)
    plate = Part(
        "plate",
        slab((0.0, -0.05, -0.008), (0.2, 0.05, 0.0)),
        poses=np.c_[np.zeros((frames, 3)), turn],
    )
    turns = np.repeat(turn[:, None], 4, axis=1)
    return Motion(
        time_s, (SOYBEAN,), np.zeros(4, int), places, turns, speed, spin, (plate,)
    )
