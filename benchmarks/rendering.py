"""What pictures cost: a 12-megapixel photo of 3,500 seeds, a drop's and a slide's frame, and which part of it takes how long.

    python benchmarks/rendering.py [REPEATS]      default 3

The scenes are placed by hand (a cone of seeds, a falling seed, a plate that tilts) and shared with the tests of pictures.
"""

import argparse
import time
from collections import defaultdict
from contextlib import contextmanager
from functools import wraps

import cv2
import numpy as np

from sim.motion import Motion, Part
from sim.picture import Camera, Look, context, exposure, film, photo, renderer_name
from sim.seed import Seed
from sim.seed.surface import Mesh

SOYBEAN = Seed.from_dimensions(8.72e-3, 6.84e-3, 5.98e-3)
PITCH_M = 6.6e-3  # of the lattice that the heap is cut from


def slab(low_m, high_m) -> Mesh:
    """A cuboid between two corners."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4)]
    faces += [(1, 5, 7), (1, 7, 3)]
    out = (2.0 * corners - 1.0) / np.sqrt(3.0)
    return Mesh(np.where(corners == 0, low_m, high_m).astype(float), np.array(faces), out)


def still(positions_m, orientations, *, shapes=(SOYBEAN,), shape_of=None, parts=()) -> Motion:
    """One moment, nothing moving."""
    positions = np.asarray(positions_m, dtype=float).reshape(1, -1, 3)
    who = np.zeros(positions.shape[1], int) if shape_of is None else np.asarray(shape_of)
    rest = np.zeros_like(positions)
    turns = np.asarray(orientations, dtype=float).reshape(1, -1, 4)
    return Motion(np.zeros(1), tuple(shapes), who, positions, turns, rest, rest, tuple(parts))


def heap(seeds: int = 3500, angle_deg: float = 30.0, rng: np.random.Generator | None = None) -> Motion:
    """The `seeds` lowest places under a cone's surface, on a plate as wide as it takes; columns shifted: no steps."""
    rng = rng or np.random.default_rng(1)
    reach = np.arange(-30, 31) * PITCH_M
    x, y, z = np.meshgrid(reach, reach, np.arange(0, 30) * 0.85 * PITCH_M + 3.4e-3, indexing="ij")
    z[:, :, 1:] += rng.uniform(0.0, 0.85 * PITCH_M, z.shape[:2])[:, :, None]
    x, y, z = x.ravel(), y.ravel(), z.ravel()
    under = z + np.tan(np.radians(angle_deg)) * np.hypot(x, y)  # height of the cone that just holds it
    chosen = np.argsort(under, kind="stable")[:seeds]
    places = np.c_[x, y, z][chosen] + rng.uniform(-0.8e-3, 0.8e-3, (seeds, 3)) * [1, 1, 0.3]
    turns = rng.standard_normal((seeds, 4))
    half = float(np.abs(places[:, :2]).max()) + 0.02
    plate = Part("plate", slab((-half, -half, -0.005), (half, half, 0.0)))
    return still(places, turns / np.linalg.norm(turns, axis=1, keepdims=True), parts=(plate,))


def drop(frames: int = 40, fps: float = 1000.0, start_s: float = 0.15, spin_rad_s: float = 20.0) -> Motion:
    """A seed that falls from 310 mm on to a plate, turning as it goes."""
    time_s = start_s + np.arange(frames) / fps
    place, speed, spin = np.zeros((frames, 1, 3)), np.zeros((frames, 1, 3)), np.zeros((frames, 1, 3))
    place[:, 0, 2] = 0.31 + 3e-3 - 0.5 * 9.81 * time_s**2
    speed[:, 0, 2], spin[:, 0, 1] = -9.81 * time_s, spin_rad_s
    turns = np.zeros((frames, 1, 4))
    turns[:, 0, 0], turns[:, 0, 2] = np.cos(spin_rad_s * time_s / 2), np.sin(spin_rad_s * time_s / 2)
    plate = Part("plate", slab((-0.1, -0.1, -0.01), (0.1, 0.1, 0.0)))
    return Motion(time_s, (SOYBEAN,), np.zeros(1, int), place, turns, speed, spin, (plate,))


def slide(frames: int = 20, fps: float = 50.0, rate_deg_s: float = 10.0) -> Motion:
    """Four seeds at rest on a plate that tilts about its left edge, its right end rising."""
    time_s = np.arange(frames) / fps
    tilt = np.radians(10.0 + rate_deg_s * time_s)
    turn = np.zeros((frames, 4))
    turn[:, 0], turn[:, 2] = np.cos(tilt / 2), -np.sin(tilt / 2)
    along, up = np.c_[np.cos(tilt), 0 * tilt, np.sin(tilt)], np.c_[-np.sin(tilt), 0 * tilt, np.cos(tilt)]
    seat = 0.15 + 3.5e-3 * np.array([-1, -1, 1, 1])
    depth = 3.5e-3 * np.array([-1, 1, -1, 1])[:, None] * [0.0, 1.0, 0.0]
    places = seat[None, :, None] * along[:, None] + 3e-3 * up[:, None] + depth
    speed = np.gradient(places, time_s, axis=0)
    spin = np.zeros_like(places)
    spin[:, :, 1] = -np.radians(rate_deg_s)
    plate = Part("plate", slab((0.0, -0.05, -0.008), (0.2, 0.05, 0.0)), poses=np.c_[np.zeros((frames, 3)), turn])
    turns = np.repeat(turn[:, None], 4, axis=1)
    return Motion(time_s, (SOYBEAN,), np.zeros(4, int), places, turns, speed, spin, (plate,))


PHOTO = Camera(4000, 3000, mm_per_px=0.085, target_m=(0.0, 0.0, 0.08))
DROP = Camera(1280, 800, mm_per_px=0.25, target_m=(0.0, 0.0, 0.09), exposure_s=2e-5)
SLIDE = Camera(1280, 800, mm_per_px=0.25, target_m=(0.12, 0.0, 0.06), exposure_s=1e-3)
FILMED = Look(grey=True, noise=2.0)


@contextmanager
def timed(spent: dict[str, float]):
    """Adds up the seconds spent in each part of a picture's making, while inside."""
    from OpenGL import GL

    parts = [
        (context.Context, "draw", "draw"), (GL, "glReadPixels", "read back"), (exposure.cv2, "resize", "average"),
        (exposure.cv2, "remap", "distort"), (exposure, "undistort", "distort"), (exposure, "_digitise", "noise, rounding"),
    ]  # fmt: skip
    kept = [(owner, name, getattr(owner, name)) for owner, name, _ in parts]
    for (owner, name, function), (_, _, part) in zip(kept, parts):
        setattr(owner, name, _timer(function, part, spent))
    try:
        yield
    finally:
        for owner, name, function in kept:
            setattr(owner, name, function)
    spent["draw"] -= spent["read back"]  # drawing ends by reading back


def _timer(function, part: str, spent: dict[str, float]):
    @wraps(function)
    def run(*args, **options):
        start = time.perf_counter()
        try:
            return function(*args, **options)
        finally:
            spent[part] += time.perf_counter() - start

    return run


def cost(work, pictures: int, repeats: int) -> tuple[float, float, dict[str, float]]:
    """Least wall and CPU seconds a picture over `repeats`, and the share of each part in the quickest."""
    best: tuple[float, float, dict[str, float]] = (np.inf, np.inf, {})
    for _ in range(repeats):
        spent: dict[str, float] = defaultdict(float)
        wall, cpu = time.perf_counter(), time.process_time()
        with timed(spent):
            work()
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        if wall < best[0] * pictures:
            best = (wall / pictures, min(best[1], cpu / pictures), {k: v / wall for k, v in spent.items()})
    return best


def main(repeats: int) -> None:
    print(f"{renderer_name()}, {cv2.getNumberOfCPUs()} cores")
    rng, pile = np.random.default_rng(0), heap()
    bent = Camera(4000, 3000, mm_per_px=0.085, target_m=(0.0, 0.0, 0.08), distortion=-0.02)
    falling, tilting = drop(), slide()
    rows = [
        ("photo of 3,500 seeds, 12 Mpx", lambda: photo(pile, PHOTO), 1),
        ("  the same, one sample row and column a pixel", lambda: photo(pile, PHOTO, fine=1), 1),
        ("  the same, distorted and noisy", lambda: photo(pile, bent, Look(noise=2.0), rng=rng), 1),
        ("drop, a frame of 1280 × 800", lambda: list(film(falling, DROP, Look(grey=True))), falling.frames),
        ("  the same, noisy", lambda: list(film(falling, DROP, FILMED, rng=rng)), falling.frames),
        ("slide, a frame of 1280 × 800", lambda: list(film(tilting, SLIDE, FILMED, rng=rng)), tilting.frames),
    ]
    print(f"{'':46s} {'wall':>9s} {'CPU':>9s}   share of the wall time")
    for name, work, pictures in rows:
        wall, cpu, shares = cost(work, pictures, repeats)
        parts = ", ".join(f"{k} {100 * v:.0f} %" for k, v in sorted(shares.items(), key=lambda item: -item[1]))
        unit, factor = ("s", 1.0) if wall > 0.5 else ("ms", 1e3)
        print(f"{name:46s} {factor * wall:6.2f} {unit:2s} {factor * cpu:6.2f} {unit:2s}   {parts}", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("repeats", type=int, nargs="?", default=3)
    main(parser.parse_args().repeats)
