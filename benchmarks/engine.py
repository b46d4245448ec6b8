"""The engine's speed beside LAMMPS: one table, measured in turns, so that what else the
machine does falls on both.

    python benchmarks/engine.py [--small] [--rounds 5]

Same settled bed, contact law, step and number of contacts; 1 and 2 cores. Then what
does not need LAMMPS: how the cost grows from 500 to 50,000 seeds, memory, a one-seed
drop, cold and warm start."""

import argparse
import os
import subprocess
import sys
import tempfile
import time
import tracemalloc
from dataclasses import replace
from statistics import median

import engine_lammps as lammps
import numpy as np
from lammps_here import installed

from benchtwin.sim.engine import step
from benchtwin.sim.engine.walls import Plane
from benchtwin.sim.engine.world import Placed, Scattered, World
from benchtwin.sim.material import (
    Q235,
    SOYBEAN,
    SOYBEAN_Q235,
    SOYBEAN_SOYBEAN,
    Contact,
    Material,
)
from benchtwin.sim.seed import Seed

DROP = """
import time
begin = time.perf_counter()
import numpy as np
from benchtwin.sim.engine import step
from benchtwin.sim.engine.walls import Plane
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.material import Q235, SOYBEAN, SOYBEAN_Q235, SOYBEAN_SOYBEAN
from benchtwin.sim.seed import Seed
seed = Seed.from_dimensions(8.72e-3, 6.84e-3, 5.98e-3)
world = World(
    (Placed((seed,), SOYBEAN, [[0, 0, 0.31]]),),
    (Plane("plate", Q235),),
    (SOYBEAN_Q235, SOYBEAN_SOYBEAN),
)
state = step.init(world, np.random.default_rng(0))
ready = time.perf_counter()
state = step.run(world, state, 0.6)
print(ready - begin, time.perf_counter() - ready, state.step)
"""


def world_of(bed: lammps.Bed, law: lammps.ContactLaw) -> World:
    """The bed as a world: type C rolling as LAMMPS's sds, walls of the seeds'
    material."""
    material = Material(
        "soft", 1250.0, law.young_pa / (2 * (1 + law.poisson)), law.poisson
    )
    contact = Contact(
        ("soft", "soft"), law.restitution, law.friction, 2.0 * law.rolling, "type_c"
    )
    (w, d), n = bed.box_m, len(bed.mass_kg)
    walls = (
        Plane("floor", material),
        Plane("left", material, (0, 0, 0), (1, 0, 0)),
        Plane("right", material, (w, 0, 0), (-1, 0, 0)),
        Plane("front", material, (0, 0, 0), (0, 1, 0)),
        Plane("back", material, (0, d, 0), (0, -1, 0)),
    )
    if bed.clumps:
        from scipy.spatial.transform import Rotation

        seed = Seed.from_dimensions(8.72e-3, 6.84e-3, 5.98e-3)
        balls = bed.centres_m.reshape(n, -1, 3)
        middle = balls.mean(axis=1)
        own = seed.centres_m - seed.centres_m.mean(axis=0)
        turns = [
            Rotation.align_vectors(b - m, own)[0]
            for b, m in zip(balls, middle, strict=True)
        ]
        centres = middle - np.array(
            [t.apply(seed.centres_m.mean(axis=0)) for t in turns]
        )
        q = np.array([t.as_quat()[[3, 0, 1, 2]] for t in turns])
        placed = Placed((seed,), material, centres, q)
    else:
        one = Seed.from_spheres(np.zeros((1, 3)), np.array([1e-3]))
        radii, first, size = np.unique(
            bed.radii_m, return_index=True, return_inverse=True
        )
        shapes = tuple(
            replace(
                one,
                radii_m=np.array([r]),
                mass_kg=m,
                inertia_kg_m2=np.full(3, 0.4 * m * r * r),
            )
            for r, m in zip(radii, bed.mass_kg[first], strict=True)
        )
        placed = Placed(shapes, material, bed.centres_m, shape_of=size)
    return World((placed,), walls, (contact,), time_step_s=law.step_s)


def contacts_of(bed: lammps.Bed, state) -> float:
    """Contacts a ball by the rule that LAMMPS's bed is counted with."""
    order = np.argsort(state.ball_id)
    seeds = state.ids[state.owner[order]]
    return lammps.contacts_per_ball(
        replace(
            bed,
            centres_m=state.ball[order, :3],
            radii_m=state.ball[order, 3],
            seed=seeds,
        )
    )


def beside_lammps(name: str, bed: lammps.Bed, steps: int, rounds: int) -> list[str]:
    law = lammps.SOFT_SOYBEAN
    world = world_of(bed, law)
    settled = step.run(
        world,
        step.init(world, np.random.default_rng(0), allowed_overlap=0.1),
        steps=200,
        threads=2,
    )
    rows = []
    for cores in (1, 2):
        ours, theirs, contacts = [], [], (np.nan, np.nan)
        for _ in range(rounds):
            begin = time.perf_counter()
            end = step.run(world, settled, steps=steps, threads=cores)
            ours.append(len(bed.radii_m) * steps / (time.perf_counter() - begin))
            if installed():
                timing = lammps.run(bed, law, steps, ranks=cores, warm_up=200)
                theirs.append(timing.particle_steps_per_s)
                contacts = (contacts_of(bed, end), timing.contacts_per_ball)
        ratio = (
            median(a / b for a, b in zip(ours, theirs, strict=True))
            if theirs
            else np.nan
        )
        rows.append(
            f"{name:28}{cores:6}{median(ours) / 1e6:14.2f}"
            f"{median(theirs or [np.nan]) / 1e6:10.2f}{ratio:8.2f}"
            f"{contacts[0]:12.3f}{contacts[1]:9.3f}"
        )
    return rows


def growth(counts: list[int]) -> list[str]:
    """Cost a ball and step of beds of spheres, all equally high, 30 seeds: only the
    floor grows."""
    seed, soft = (
        Seed.from_spheres(np.zeros((1, 3)), np.array([3e-3])),
        SOYBEAN.softened(1e7),
    )
    rows, costs = [], []
    for count in counts:
        side = np.sqrt(count / 10) * 6.2e-3
        walls = (
            Plane("floor", Q235),
            *(
                Plane(f"side{k}", Q235, p, n)
                for k, (p, n) in enumerate(
                    [
                        ((0, 0, 0), (1, 0, 0)),
                        ((side, 0, 0), (-1, 0, 0)),
                        ((0, 0, 0), (0, 1, 0)),
                        ((0, side, 0), (0, -1, 0)),
                    ]
                )
            ),
        )
        group = Scattered((seed,), soft, count, (0, 0, 0), (side, side, 0.12))
        world = World((group,), walls, (SOYBEAN_Q235, SOYBEAN_SOYBEAN))
        tracemalloc.start()
        state = step.run(
            world, step.init(world, np.random.default_rng(0)), 0.25, threads=2
        )
        begin, steps = (
            time.thread_time(),
            max(20, 1_000_000 // count),
        )  # processor time: one thread, and others run beside it
        end = step.run(world, state, steps=steps)
        cost = 1e9 * (time.thread_time() - begin) / steps / count
        _, peak = (b / count for b in tracemalloc.get_traced_memory())
        tracemalloc.stop()
        costs.append(cost)
        window = (
            48 * end.block_window[-1] + 4 * len(end.pair_i)
        ) / count  # with `View.pair_quiet`
        held = [v.nbytes for v in vars(end).values() if isinstance(v, np.ndarray)]
        rows.append(
            f"{count:8} spheres {cost:8.1f} ns a sphere-step,"
            f" {sum(held) / count + window:6.0f} bytes (peak {peak:.0f})"
        )
    slope = np.polyfit(np.log(counts), np.log(np.array(costs) * counts), 1)[0]
    return [*rows, f"cost ∝ count^{slope:.3f}"]


def start(folder: str) -> tuple[float, float, int]:
    """Seconds from nothing to ready, seconds of a 0.6 s drop, its steps; kernels kept
    in `folder`."""
    done = subprocess.run(
        [sys.executable, "-c", DROP],
        env={**os.environ, "NUMBA_CACHE_DIR": folder},
        capture_output=True,
        text=True,
        check=True,
    )
    ready, ran, steps = done.stdout.split()
    return float(ready), float(ran), int(steps)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--small",
        action="store_true",
        help="a tenth of the seeds: a minute instead of ten",
    )
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--steps", type=int, default=300)
    arguments = parser.parse_args()
    share, rng = 10 if arguments.small else 1, np.random.default_rng(2026)
    loose = {
        "spheres": lammps.loose_spheres(rng, 20_000 // share),
        "clumps": lammps.loose_clumps(rng, 4_000 // share),
    }
    print(
        f"{'settled bed':28}{'cores':>6}{'M ball-steps/s':>14}{'LAMMPS':>10}"
        f"{'ratio':>8}{'contacts':>12}{'LAMMPS':>9}"
    )
    for name, bed in loose.items():
        if installed():
            bed = lammps.settled(name, bed, lammps.SOFT_SOYBEAN)
        for row in beside_lammps(
            f"{len(bed.mass_kg)} {name}", bed, arguments.steps, arguments.rounds
        ):
            print(row, flush=True)
    print()
    for row in growth([500, 2000, 8000, 50_000 // share]):
        print(row, flush=True)
    with tempfile.TemporaryDirectory() as folder:
        cold = start(folder)
        warm = start(folder)
    print(f"\ncold start {cold[0]:.1f} s, warm start {warm[0]:.2f} s")
    print(
        f"drop of one five-ball seed: {warm[2] / warm[1] / 1e6:.2f} M steps/s, 0.6 s in"
        f" {warm[1]:.2f} s"
    )


if __name__ == "__main__":
    main()
