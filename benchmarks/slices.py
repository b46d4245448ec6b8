"""Calibrations of whole piles by slices of them: do their intervals hold the truth as
those by whole piles do?

    python benchmarks/slices.py [BENCHES]      default 3 → benchmarks/tables/slices.csv

Each bench has four piles from a box of BOX with steel sides, made by the twin with
seed–seed parameters drawn at random, and drops, slides and rolls of one lot. It is
calibrated with `--quick` twice: by the slice that a calibration takes by default, and
with `--whole-pile`. Kept in benchmark-runs/slices: the same command goes on where it
was stopped."""

import argparse
import json
from pathlib import Path

import pandas as pd
from loop_truth import SEEDS, jobs, truth

from benchtwin import calibrate
from benchtwin.twin import Parameters
from benchtwin.twin.job import Job

OUT, TABLE = Path("benchmark-runs/slices"), Path("benchmarks/tables/slices.csv")
BOX = {
    "box_mm": [80, 70, 200],
    "gate_mm": [70, 200],
    "plate_mm": [200, 110],
    "fill_height_mm": 50,
    "gate_speed_mm_s": 100,
}
PILES, SEED = 4, 2041


def make(bench: Path, number: int) -> dict[str, float]:
    """All recordings of a bench that are not there, as tracks and true angles; its
    parameters."""
    of = truth("piles", number)
    made = {name: job for name, job in jobs("piles", 0).items() if job.rig != "pile"}
    made |= {
        f"pile-{k + 1:02d}": Job(
            "pile", Parameters(**of), {"pile": BOX}, (SEED, number, k), rendered=False
        )
        for k in range(PILES)
    }
    for name, job in made.items():
        if not (bench / name).exists():
            job.run(bench / name, threads=1)
    return of


def calibrated(number: int, *, whole: bool) -> pd.DataFrame:
    """A row a seed–seed parameter: truth, interval, whether it holds."""
    folder = OUT / f"{number:02d}"
    of, out = make(folder / "bench", number), folder / ("whole" if whole else "slices")
    if not (out / "result.json").is_file():
        calibrate(folder / "bench", out=out, quick=True, whole_pile=whole, workers=1)
    found = json.loads((out / "result.json").read_text())["parameters"]
    rows = [
        (
            number,
            "whole" if whole else "slices",
            name,
            of[name],
            *(found[name][k] for k in ("value", "low", "high")),
        )
        for name in SEEDS
    ]
    table = pd.DataFrame(
        rows, columns=["bench", "by", "parameter", "truth", "value", "low", "high"]
    )
    return table.assign(holds=table["truth"].between(table["low"], table["high"]))


def main(benches: int) -> None:
    parts = []
    for number in range(1, benches + 1):
        for whole in (False, True):
            parts.append(calibrated(number, whole=whole))
            print(parts[-1].to_string(index=False), flush=True)
            pd.concat(parts).to_csv(TABLE, index=False, float_format="%.4g")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("benches", type=int, nargs="?", default=3)
    main(parser.parse_args().benches)
