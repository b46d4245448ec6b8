"""Time and memory of beds of 10³ to 10⁶ balls in our engine and in LAMMPS: when to
change over.

    python benchmarks/engine_growth.py [COUNT ...]

writes benchmarks/tables/engine_growth.csv and docs/engine-growth.png.

Same settled bed of spheres, contact law and step for both (see engine_lammps.py), on
one core and on two. A bed of up to 20,000 balls has settled itself; larger ones are
copies of that one, side by side. Memory: the largest that the processes of a run hold
together, less what Python and the imports take before there is a bed, as the operating
system counts it."""

import argparse
import json
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path

import engine
import engine_lammps as lammps
import numpy as np
import pandas as pd
import psutil

from benchtwin.sim.engine import step

COUNTS = (1_000, 5_000, 20_000, 160_000, 1_000_000)
LAW = lammps.SOFT_SOYBEAN
LARGEST_SETTLED = 20_000
TABLE, PICTURE = (
    Path("benchmarks/tables/engine_growth.csv"),
    Path("docs/engine-growth.png"),
)


def bed_of(count: int) -> lammps.Bed:
    """A settled bed of `count` balls; above LARGEST_SETTLED, `count` must be a multiple
    of it."""
    rng = np.random.default_rng(2026)
    one = lammps.loose_spheres(rng, min(count, LARGEST_SETTLED))
    one = lammps.settled("spheres", one, LAW)
    copies = count // len(one.radii_m)
    along = max(k for k in range(1, copies + 1) if copies % k == 0 and k * k <= copies)
    shift = [
        (i * one.box_m[0], j * one.box_m[1], 0.0)
        for i in range(copies // along)
        for j in range(along)
    ]
    return replace(
        one,
        centres_m=np.vstack([one.centres_m + s for s in shift]),
        radii_m=np.tile(one.radii_m, copies),
        seed=np.arange(count),
        mass_kg=np.tile(one.mass_kg, copies),
        box_m=one.box_m * (copies // along, along),
        velocity_m_s=np.tile(one.velocity_m_s, (copies, 1)),
    )


def measure(code: str, count: int, cores: int) -> dict:
    """One run in this process: ns of wall time a ball and step, contacts a ball."""
    bed, steps = bed_of(count), max(20, 2_000_000 // count)
    print("ready", flush=True)
    if code == "LAMMPS":
        found = lammps.run(bed, LAW, steps, ranks=cores, warm_up=20)
        return {
            "ns_a_ball_step": 1e9 / found.particle_steps_per_s,
            "contacts": found.contacts_per_ball,
        }
    world = engine.world_of(bed, LAW)
    state = step.init(world, np.random.default_rng(0), allowed_overlap=0.1)
    state = step.run(world, state, steps=20, threads=cores)
    begin = time.perf_counter()
    state = step.run(world, state, steps=steps, threads=cores)
    return {
        "ns_a_ball_step": 1e9 * (time.perf_counter() - begin) / steps / count,
        "contacts": engine.contacts_of(bed, state),
    }


def apart(code: str, count: int, cores: int) -> dict:
    """The same in a process of its own, with the memory that it and its own processes
    take."""
    command = [sys.executable, __file__, "--one", code, str(count), str(cores)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    family, most, before = psutil.Process(process.pid), [0], [0]

    def watch() -> None:
        while process.poll() is None:
            try:
                held = sum(
                    p.memory_info().rss
                    for p in (family, *family.children(recursive=True))
                )
            except psutil.NoSuchProcess:
                continue
            most[0] = max(most[0], held)
            time.sleep(0.02)

    watcher = threading.Thread(target=watch)
    watcher.start()
    lines = []
    assert process.stdout is not None  # a pipe was asked for
    for line in process.stdout:
        lines.append(line)
        if line.strip() == "ready":
            before[0], most[0] = family.memory_info().rss, 0
    watcher.join()
    if process.wait():
        raise SystemExit(f"{code}, {count} balls: stopped")
    of = {"engine": code, "balls": count, "cores": cores}
    return of | json.loads(lines[-1]) | {"memory_mb": max(most[0] - before[0], 0) / 1e6}


def draw(table: pd.DataFrame) -> None:
    """Time of a step and memory against the number of balls."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (left, right) = pyplot.subplots(
        1, 2, figsize=(9, 3.6), layout="constrained"
    )
    for (code, cores), rows in table.groupby(["engine", "cores"]):
        style = {
            "color": "C0" if code == "benchtwin" else "C1",
            "ls": "-" if cores == 2 else "--",
            "marker": "o",
            "ms": 4,
        }
        label = f"{code}, {cores} core{'s' if cores > 1 else ''}"
        left.loglog(
            rows["balls"],
            rows["ns_a_ball_step"] * rows["balls"] * 1e-9,
            label=label,
            **style,
        )
        right.loglog(rows["balls"], rows["memory_mb"], label=label, **style)
    left.set(xlabel="balls", ylabel="one step [s]")
    right.set(xlabel="balls", ylabel="memory [MB]")
    left.legend(fontsize=8)
    figure.savefig(PICTURE, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("counts", nargs="*", type=int, default=COUNTS)
    parser.add_argument("--one", nargs=3, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.one:
        code, count, cores = asked.one
        print(json.dumps(measure(code, int(count), int(cores))))
        return
    rows = []
    for count in asked.counts:
        bed_of(count)  # settled before anything is timed
        for cores in (1, 2):
            for code in ("benchtwin", "LAMMPS"):
                rows.append(apart(code, count, cores))
                print(rows[-1], flush=True)
                table = pd.DataFrame(rows)
                table.to_csv(TABLE, index=False, float_format="%.4g")
    draw(table)


if __name__ == "__main__":
    main()
