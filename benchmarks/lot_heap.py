"""A heap of a measured lot against heaps of its typical seed alone and of ellipsoids of
its sizes, repeated over packings.

python benchmarks/lot_heap.py FOLDER [--lot samples/seed-lot/lot] [--packings 6]
[--thickness-mm 5.98]

Reduced piles (a slab 18 mm deep) at the paper's optimum; one thread. Packing k of every
kind of seed has the same random numbers. Rows are appended to FOLDER/heaps.csv and are
not run again; the summary is printed at the end."""

import argparse
import os
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import pandas as pd

from benchtwin.bench.keys import Air, Seed
from benchtwin.sim.rigs.bench import no_watch
from benchtwin.sim.rigs.engine import Ours
from benchtwin.sim.rigs.heap import fill, run_heap
from benchtwin.sim.rigs.pile import Pile, vessel
from benchtwin.twin.lot import other_seeds
from benchtwin.twin.parameters import Parameters, bench

SLAB = Pile(
    box_m=(0.105, 0.018, 0.2), gate_m=(0.018, 0.2), plate_m=(0.2, 0.018), slab=True
)
ANGLE = "centroid_angle_deg"


def one(section: dict, packing: int) -> dict[str, float]:
    """Truth of one simulated heap of the seeds in `section` ([seed] of a
    bench.toml)."""
    described = bench(Parameters(), "pile", Seed(**section), Air())
    rng, tall = np.random.default_rng(packing), vessel(SLAB, described)
    filled = fill(tall, described, rng, Ours(1), no_watch)
    return run_heap(
        tall, described, rng, fps=20.0, watch=no_watch, engine=Ours(1), filled=filled
    ).truth


def summary(table: pd.DataFrame) -> str:
    """Mean with standard error a kind, and what each differs by from the lot, with its
    95 % interval."""
    found = {kind: part[ANGLE].to_numpy() for kind, part in table.groupby("seeds")}
    lines = [
        f"{kind:13s} {len(a)} packings: {a.mean():.2f} ±"
        f" {a.std(ddof=1) / len(a) ** 0.5:.2f} deg, spread {a.std(ddof=1):.2f}"
        for kind, a in found.items()
    ]
    for kind, a in found.items():
        if kind != "lot":
            sd = np.sqrt(
                a.var(ddof=1) / len(a) + found["lot"].var(ddof=1) / len(found["lot"])
            )
            lines.append(
                f"{kind} less lot: {a.mean() - found['lot'].mean():+.2f} ±"
                f" {1.96 * sd:.2f} deg (95 %)"
            )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--lot", type=Path, required=True)
    parser.add_argument("--packings", type=int, default=6)
    parser.add_argument("--thickness-mm", type=float, default=5.98)
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    file = arguments.folder / "heaps.csv"
    rows = pd.read_csv(file).to_dict("records") if file.exists() else []
    section = {
        "lot": str(arguments.lot.resolve()),
        "thickness_mm": arguments.thickness_mm,
    }
    kinds = {"lot": section} | other_seeds(section)
    for packing in range(arguments.packings):
        for kind, seeds in kinds.items():
            if any(row["seeds"] == kind and row["packing"] == packing for row in rows):
                continue
            rows.append({"seeds": kind, "packing": packing} | one(seeds, packing))
            pd.DataFrame(rows).to_csv(file, index=False)
            print(kind, packing, f"{rows[-1][ANGLE]:.2f}", flush=True)
    print(summary(pd.DataFrame(rows)))


if __name__ == "__main__":
    main()
