"""Closing the loop: benches with known parameters (loop_truth.py) calibrated by the
whole procedure, answers beside the truth.

python benchmarks/loop.py piles [FIRST LAST] → benchmarks/tables/loop/piles.csv: where
the truth lies in the seed–seed posteriors python benchmarks/loop.py steel [FIRST LAST]
→ benchmarks/tables/loop/steel.csv: seed–steel answers, quick effort

FIRST and LAST are 0 and 19 unless given; without arguments the tables are read again.
Simulations are kept in benchmark-runs/loop/runs. The piles' design is that of a quick
calibration of the first folder and serves all; posteriors are drawn by weighing points
of the prior, which takes a moment where the procedure's chains take 20 s."""

import argparse
import json
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats

from benchtwin.calibrate.procedure import parameters
from benchtwin.calibrate.procedure.bench import bench_of
from benchtwin.calibrate.procedure.calibration import Calibration
from benchtwin.calibrate.procedure.effort import QUICK
from benchtwin.calibrate.procedure.observed import observed
from benchtwin.calibrate.procedure.rigs import PILE, RANGES, STEEL
from benchtwin.calibrate.procedure.seed_runs import simulate_design
from benchtwin.calibrate.procedure.simulated import (
    Prescribed,
    Way,
    calibrate_simulated,
    seed_stage,
    steel_rig,
)
from benchtwin.calibrate.procedure.simulator import campaign
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.posterior import log_posterior
from benchtwin.calibrate.statistics.prior import Prior

RUNS, TABLES = Path("benchmark-runs/loop"), Path("benchmarks/tables/loop")
TOLERANCE = {"restitution": 0.01, "static_friction": 0.01, "rolling_friction": 0.003}
LEVELS = (0.50, 0.80, 0.95)
POINTS = 40_000


def designed(
    simulate,
) -> tuple[pd.DataFrame, Box, dict[str, tuple[float, float]]]:
    """All piles of the quick design, the box of its seed–steel parameters, and what
    these were calibrated to, (value, sd)."""
    way = Way(simulate, QUICK, Prescribed())
    calibrated = Calibration.of("simulated", bench_of(RUNS / "piles-00"), 1, {})
    for name in STEEL:
        calibrated = steel_rig(calibrated, name, way)
    stage = seed_stage(calibrated, PILE, way)
    assert stage.steel is not None  # all three rigs are in the bench
    return simulate_design(stage), stage.steel, stage.steel_found


def posterior(folder: int, piles: pd.DataFrame, steel: Box, found: dict) -> list[dict]:
    """One row a seed–seed parameter: folder, parameter, truth, mean, rank (share of the
    posterior below the truth), sd_ratio (posterior over prior), points (effective
    number)."""
    truth = json.loads((RUNS / f"piles-{folder:02d}.json").read_text(encoding="utf8"))
    readings = bench_of(RUNS / f"piles-{folder:02d}").rigs["pile"]
    seen = observed(piles, readings, Box.of(RANGES), steel, alike=True)
    names, ends = (
        (*RANGES, *steel.names),
        np.array([*RANGES.values(), *zip(steel.low, steel.high)]),
    )
    prior = Prior(Box(names, ends[:, 0], ends[:, 1]), found)
    points = prior.draw(POINTS, np.random.default_rng(folder))
    flat = Prior(prior.box, {})  # the points carry the prior already
    weight = log_posterior(
        points, list(seen.observables), flat, seen.correlation.to_numpy()
    )
    weight = np.exp(weight - weight.max())
    weight /= weight.sum()
    rows = []
    for j, name in enumerate(RANGES):
        x = points[:, j]
        mean = float(weight @ x)
        sd = float(np.sqrt(weight @ (x - mean) ** 2))
        row = {
            "folder": folder,
            "parameter": name,
            "truth": truth[name],
            "mean": mean,
            "rank": float(weight @ (x < truth[name])),
        }
        rows.append(
            row
            | {
                "sd_ratio": sd / float(flat.sd[j]),
                "points": 1 / float(np.sum(weight**2)),
            }
        )
    return rows


def on_steel(folder: int, simulate) -> list[dict]:
    """One row a seed–steel parameter: folder, parameter, truth, value, low, high."""
    truth = json.loads((RUNS / f"steel-{folder:02d}.json").read_text(encoding="utf8"))
    found = parameters(
        calibrate_simulated(
            RUNS / f"steel-{folder:02d}", simulate, effort=QUICK, seed=1
        )
    )
    kept = found[["parameter", "value", "low", "high"]]
    return kept.assign(folder=folder, truth=kept["parameter"].map(truth)).to_dict(
        "records"
    )


def rate(hits: np.ndarray) -> str:
    """k of n with the 95 % interval of the rate (Clopper & Pearson 1934)."""
    k, n = int(hits.sum()), len(hits)
    low = stats.beta.ppf(0.025, k, n - k + 1) if k else 0.0
    high = stats.beta.ppf(0.975, k + 1, n - k) if k < n else 1.0
    return f"{k} of {n} ({100 * low:.0f} to {100 * high:.0f} %)"


def table() -> None:
    if (TABLES / "steel.csv").exists():
        for name, t in pd.read_csv(TABLES / "steel.csv").groupby(
            "parameter", sort=False
        ):
            inside, off = (
                (t["low"] <= t["truth"]) & (t["truth"] <= t["high"]),
                t["value"] - t["truth"],
            )
            near, scatter = (
                rate(abs(off) <= TOLERANCE[name]),
                f"bias {off.mean():+.4f}, sd {off.std():.4f}",
            )
            print(
                f"{name:22} within ±{TOLERANCE[name]}: {near}; 95 % interval:"
                f" {rate(inside)}; {scatter}"
            )
    if (TABLES / "piles.csv").exists():
        for name, t in pd.read_csv(TABLES / "piles.csv").groupby(
            "parameter", sort=False
        ):
            central = [
                f"{level:.0%}: {rate(abs(t['rank'] - 0.5) <= level / 2)}"
                for level in LEVELS
            ]
            print(
                f"{name:22} {'; '.join(central)}; sd left {t['sd_ratio'].median():.2f}"
            )


def main(kind: str, first: int, last: int) -> None:
    TABLES.mkdir(parents=True, exist_ok=True)
    file = TABLES / f"{kind}.csv"
    done = pd.read_csv(file) if file.exists() else pd.DataFrame({"folder": []})
    with campaign(RUNS / "runs", workers=1) as simulate:
        design = designed(simulate) if kind == "piles" else None
        for folder in range(first, last + 1):
            if (
                folder in done["folder"].to_numpy()
                or not (RUNS / f"{kind}-{folder:02d}.json").exists()
            ):
                continue
            rows = posterior(folder, *design) if design else on_steel(folder, simulate)
            done = pd.concat([done, pd.DataFrame(rows)], ignore_index=True)
            done.to_csv(file, index=False, float_format="%.6g")
    table()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("kind", nargs="?", choices=["piles", "steel"])
    parser.add_argument("first", type=int, nargs="?", default=0)
    parser.add_argument("last", type=int, nargs="?", default=19)
    arguments = vars(parser.parse_args())
    main(**arguments) if arguments["kind"] else table()
