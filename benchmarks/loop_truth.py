"""Bench folders whose parameters are known: our own rigs, parameters drawn at random,
kept apart from what calibrates them.

python benchmarks/loop_truth.py piles [FIRST LAST] → benchmark-runs/loop/piles-00 …:
seed–seed parameters differ; photos of piles python benchmarks/loop_truth.py steel
[FIRST LAST] → benchmark-runs/loop/steel-00 …: drop, slide and roll, filmed

FIRST and LAST are 0 and 19 unless given. Each has its truth beside it. The same command
goes on where it was stopped."""

import argparse
import json
import shutil
from pathlib import Path

import numpy as np

from benchtwin.twin import Parameters
from benchtwin.twin.job import Job

OUT = Path("benchmark-runs/loop")
STEEL = {
    "restitution": (0.45, 0.65),
    "static_friction": (0.30, 0.50),
    "rolling_friction": (0.01, 0.03),
}
SEEDS = {
    "seed_restitution": (0.45, 0.70),
    "seed_static_friction": (0.20, 0.70),
    "seed_rolling_friction": (0.01, 0.06),
}
FIRST = {
    "restitution": 0.4858,
    "static_friction": 0.3780,
    "rolling_friction": 0.0193,
    "seed_restitution": 0.5426,
    "seed_static_friction": 0.3775,
    "seed_rolling_friction": 0.0495,
}
SLAB = {
    "box_mm": [60, 20, 200],
    "gate_mm": [20, 200],
    "plate_mm": [180, 20],
    "fill_height_mm": 45,
    "gate_speed_mm_s": 200,
    "slab": True,
}
PILES = {"drop": 10, "slide": 4, "roll": 10, "pile": 3}
RUNS = {"piles": PILES, "steel": {"drop": 8, "slide": 2, "roll": 4}}
FILMED = {
    "piles": ("pile",),
    "steel": ("drop", "slide", "roll"),
}  # the other recordings are tracks
SEED = 2026


def truth(kind: str, folder: int) -> dict[str, float]:
    """Parameters of one bench: FIRST, of which piles draw the seed–seed ones and steel
    the seed–steel ones, uniform."""
    if (kind, folder) == ("piles", 0):
        return FIRST
    rng = np.random.default_rng([SEED, folder])
    drawn = {"piles": SEEDS, "steel": STEEL}[kind]
    return FIRST | {
        name: float(f"{rng.uniform(*ends):.4f}") for name, ends in drawn.items()
    }


def jobs(kind: str, folder: int) -> dict[str, Job]:
    """The recordings of one bench by name: FILMED ones rendered, the others as tracks.
    The piles' benches have the tracks of the first one, as their seed–steel parameters
    are the same."""
    of = truth(kind, folder)
    on_steel = FIRST | {name: of[name] for name in STEEL}
    onset = float(np.floor(np.degrees(np.arctan(of["static_friction"])) - 1.0))
    slide = {"slide": {"start_deg": onset}}
    sections: dict[str, dict] = {
        "drop": {"camera": {"fps": 500.0}},
        "slide": slide,
        "pile": {"pile": SLAB},
    }
    made = {}
    for rig, n in RUNS[kind].items():
        for k in range(n):
            section = (
                {"roll": {"direction": ("+x", "-x")[k % 2]}}
                if rig == "roll"
                else sections[rig]
            )
            own = folder if kind == "steel" or rig == "pile" else 0
            values = Parameters(**(of if rig == "pile" else on_steel))
            made[f"{rig}-{k + 1:02d}"] = Job(
                rig, values, section, (SEED, own, k), rendered=rig in FILMED[kind]
            )
    return made


def main(kind: str, first: int, last: int) -> None:
    for folder in range(first, last + 1):
        bench = OUT / f"{kind}-{folder:02d}"
        for name, job in jobs(kind, folder).items():
            known = OUT / "piles-00" / name
            if (
                kind == "piles"
                and job.rig != "pile"
                and known.exists()
                and not (bench / name).exists()
            ):
                shutil.copytree(known, bench / name)
            job.run(bench / name, threads=1)
        (OUT / f"{kind}-{folder:02d}.json").write_text(
            json.dumps(truth(kind, folder)), encoding="utf8"
        )
        print(bench, truth(kind, folder), flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("kind", nargs="?", choices=["piles", "steel"])
    parser.add_argument("first", type=int, nargs="?", default=0)
    parser.add_argument("last", type=int, nargs="?", default=19)
    arguments = vars(parser.parse_args())
    main(**arguments) if arguments["kind"] else parser.print_help()
