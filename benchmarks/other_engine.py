"""Benches made by LAMMPS: calibrated on heap and draw-down with our engine, then two
systems predicted that were not calibrated on, a lifted cylinder's heap and a rotating
drum, and LAMMPS run on both.

    python benchmarks/other_engine.py STORE [--benches 20] [--workers 2]
        [--maker lammps|benchtwin] [--shared-law] [--parameters-only]
        → benchmarks/tables/other_engine.csv, of LAMMPS' benches with our own law

Each bench has seed–seed parameters drawn over the ranges in which a calibration looks
and one recording each of RECORDED; seed on plate is known, ROUGH. The surfaces through
our own runs at POINTS points of these ranges serve all benches. Their posteriors are
those of `calibrate`, without further runs about the bench's readings; each is handed to
`predict` with DRAWS draws and PACKINGS packings. Prints how many of the 95 % intervals
hold: parameters, and what one LAMMPS run of either system shows. STORE keeps finished
runs. Controls: benches that our own engine made, and our engine with the law that
LAMMPS has too."""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
from loop_truth import SLAB
from other_system import LOT, SYSTEMS
from scipy.stats import qmc

from benchtwin.calibrate.prediction.predict import Kept, predict
from benchtwin.calibrate.procedure.bench import RigReadings
from benchtwin.calibrate.procedure.observed import joined, observed
from benchtwin.calibrate.procedure.rigs import BESIDE, PILE, RANGES
from benchtwin.calibrate.procedure.simulator import Run, Simulator, campaign
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.posterior import Posterior, on_grid
from benchtwin.calibrate.statistics.prior import Prior
from benchtwin.twin.engine import LAMMPS, OURS, Engine

TABLE = Path("benchmarks/tables/other_engine.csv")
BOX = Box.of(RANGES)
SEED, POINTS, DRAWS, PACKINGS, CELLS, KEPT = 2033, 32, 12, 4, 41, 400
# of seed on a plate on which a heap stays
ROUGH = {"restitution": 0.5, "static_friction": 0.6, "rolling_friction": 0.06}
# what a bench has, and the columns that are read or weighed of it, the main one first
RECORDED: dict[str, tuple[dict, tuple[str, ...]]] = {
    "pile": (SLAB, ("repose_angle_deg", "centroid_angle_deg", "filled_mass_g")),
    "drawdown": (
        {"box_mm": [90.0, 24.0, 80.0], "fill_height_mm": 55.0, "slab": True},
        (
            *("shear_angle_deg", "shear_centroid_deg", "heap_angle_deg"),
            *("heap_centroid_deg", "flow_time_s", "filled_mass_g", "retained_mass_g"),
        ),
    ),
}
# the rig's folder, its section, and the quantities that are predicted
PREDICTED: dict[str, tuple[str, dict, tuple[str, ...]]] = {
    "cylinder": (
        "pile",
        SYSTEMS["cylinder"] | {"cylinder_mm": [50, 100], "fill_height_mm": 60},
        ("repose_angle_deg", "centroid_angle_deg"),
    ),
    "drum": ("drum", SYSTEMS["drum"] | {"film_s": 3.0}, ("flowing_angle_deg",)),
}


def truth(bench: int) -> dict[str, float]:
    """A bench's parameters, uniform over the ranges."""
    rng = np.random.default_rng([SEED, bench])
    return {n: float(f"{rng.uniform(*ends):.4f}") for n, ends in RANGES.items()}


def described(rig: str) -> tuple[str, dict]:
    """The rig's folder, and its sections of a recording.toml."""
    if rig in RECORDED:
        return rig, {rig: RECORDED[rig][0], "seed": LOT}
    folder, section, _ = PREDICTED[rig]
    return folder, {folder: section, "seed": LOT}


def known(table: pd.DataFrame) -> pd.DataFrame:
    """What the simulations themselves know, by the names of readings; a draw-down that
    jammed, or a run that came to nothing, has none."""
    there = table["status"].eq("done")
    if "true_jammed" in table:
        there &= ~(table["true_jammed"] > 0)
    told = table.filter(regex="^true_").where(there)
    return told.rename(columns=lambda c: c.removeprefix("true_")).astype(float)


def design(simulate: Simulator) -> dict[str, pd.DataFrame]:
    """Rig → our runs at points over the ranges: parameters, and what is known."""
    sobol = qmc.Sobol(len(RANGES), rng=np.random.default_rng(SEED)).random(POINTS)
    at = [dict(zip(RANGES, map(float, row))) for row in BOX.natural(2 * sobol - 1)]
    found = {}
    for rig in RECORDED:
        folder, description = described(rig)
        runs = [Run(folder, v, (SEED, k), description) for k, v in enumerate(at)]
        found[rig] = pd.concat([pd.DataFrame(at), known(simulate(runs))], axis=1)
    return found


def made(simulate: Simulator, benches: int, rigs, first: int) -> dict:
    """Rig → a row a bench: what its maker shows of it; first: of its seed numbers."""
    found = {}
    for n, rig in enumerate(rigs):
        folder, description = described(rig)
        runs = [
            Run(folder, truth(k), (SEED, first + k, n), description)
            for k in range(benches)
        ]
        found[rig] = known(simulate(runs))
    return found


def calibrated(runs: dict[str, pd.DataFrame], bench: dict[str, pd.Series]) -> Posterior:
    """The posterior of a bench's recordings, by surfaces through our runs."""
    parts = []
    for rig, (_, columns) in RECORDED.items():
        there = [c for c in columns if np.isfinite(bench[rig].get(c, np.nan))]
        if columns[0] not in there:
            continue
        read = {c: np.array([bench[rig][c]]) for c in there}
        readings = RigReadings(
            rig=rig,
            response=columns[0],
            values=read.pop(columns[0]),
            reading_sd=np.zeros(1),
            further=read,
        )
        told = PILE if rig == PILE.name else BESIDE[rig]
        usable = runs[rig][runs[rig][columns[0]].notna()]
        parts.append(observed(usable, readings, BOX, None, alike=True, rig=told))
    observables, correlation = joined(tuple(parts))
    return on_grid(
        list(observables),
        Prior.uniform(BOX),
        rng=np.random.default_rng(SEED),
        cells=CELLS,
        correlation=correlation.to_numpy(),
    )


def parameters(bench: int, posterior: Posterior) -> list[dict]:
    """A row a parameter: its 95 % interval, and what is true."""
    ends = posterior.draws.quantile([0.025, 0.975]).set_axis(["low", "high"])
    return [
        {"quantity": name, **ends[name], "seen": true}
        for name, true in truth(bench).items()
    ]


def predicted(
    bench: int, posterior: Posterior, lammps: dict[str, pd.DataFrame], ours: Simulator
) -> list[dict]:
    """A row a quantity of the systems that were not calibrated on: its 95 % interval,
    and what LAMMPS shows."""
    draws = posterior.draws.sample(KEPT, random_state=SEED, replace=True)
    draws = draws.assign(**ROUGH).reset_index(drop=True)
    kept = Kept(draws, posterior.mode | ROUGH, {}, "", ())
    rows = []
    for rig, (*_, quantities) in PREDICTED.items():
        found = predict(
            rig,
            kept,
            described(rig)[1],
            ours,
            draws=DRAWS,
            packings=PACKINGS,
            seed=SEED + bench,
        )
        for name in quantities:
            p, half = found.of[name], found.of[name].half_width(1)
            ends = {"low": p.mean - half, "high": p.mean + half}
            seen = lammps[rig].loc[bench, name]
            rows.append({"quantity": f"{rig}: {name}", **ends, "seen": seen})
    return rows


def summed(table: pd.DataFrame) -> pd.DataFrame:
    """Of each quantity: how many intervals there are, hold, and how wide they are; the
    mean and sd of what was seen less the interval's middle, in sds of the interval."""
    low, high, seen = table["low"], table["high"], table["seen"]
    off = (seen - (low + high) / 2) / ((high - low) / (2 * 1.96))
    told = table.assign(holds=(low <= seen) & (seen <= high), width=high - low, z=off)
    by = told[seen.notna()].groupby("quantity", sort=False)
    return pd.DataFrame(
        {
            "benches": by.size(),
            "hold": by["holds"].sum(),
            "width": by["width"].median(),
            "z mean": by["z"].mean(),
            "z sd": by["z"].std(),
        }
    )


def main(asked: argparse.Namespace) -> None:
    """Simulate, calibrate, predict, compare; a bench is written as soon as it is
    there."""

    def say(text: str) -> None:
        print(text, flush=True)

    rigs = tuple(RECORDED) if asked.parameters_only else (*RECORDED, *PREDICTED)
    law = "shared" if asked.shared_law else "ours"
    common = {"base": ROUGH, "workers": asked.workers}
    own = Engine(shared_law=asked.shared_law)
    with campaign(asked.store / law, engine=own, **common) as ours:
        runs = design(ours)
        if asked.maker == LAMMPS:
            store, engine = asked.store / LAMMPS, Engine(LAMMPS)
            with campaign(store, engine=engine, say=say, **common) as theirs:
                benches = made(theirs, asked.benches, rigs, 1000)
        else:
            benches = made(ours, asked.benches, rigs, 3000)
        rows: list[dict] = []
        for k in range(asked.benches):
            seen = {rig: benches[rig].loc[k] for rig in RECORDED}
            if not all(
                np.isfinite(seen[r].get(c[0])) for r, (_, c) in RECORDED.items()
            ):
                say(f"bench {k}: a recording came to nothing")
                continue
            posterior = calibrated(runs, seen)
            found = parameters(k, posterior)
            if not asked.parameters_only:
                found += predicted(k, posterior, benches, ours)
            rows += [{"bench": k, **row} for row in found]
            table = pd.DataFrame(rows)
            if asked.maker == LAMMPS and law == "ours" and not asked.parameters_only:
                table.to_csv(TABLE, index=False, float_format="%.5g")
    say(summed(table).round(2).to_string())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("store", type=Path)
    parser.add_argument("--benches", type=int, default=20)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--maker", choices=(LAMMPS, OURS), default=LAMMPS)
    parser.add_argument("--shared-law", action="store_true")
    parser.add_argument("--parameters-only", action="store_true")
    main(parser.parse_args())
