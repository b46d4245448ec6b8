"""What draw-downs and beds tell beside heaps: intervals of the seed–seed parameters of
benches of known parameters, with heaps alone and with each further rig.

    python benchmarks/beside_piles.py STORE [--points 24] [--rigs pile,drawdown,bed]
        [--box LARGE|SMALL]

Simulated at `points` Sobol points of the ranges in which a calibration looks, and
REPEATS times at TRUE, which stand for a bench's recordings. STORE keeps finished runs.
Prints, for each rig, how far single runs scatter and what the parameters do; the 95 %
intervals of TRUE; and how often and how wide they are of drawn benches: each point of
the design in turn is a bench of one recording of each rig, left out of the surfaces.
"""

import argparse
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import qmc

from benchtwin.calibrate.procedure.bench import RigReadings
from benchtwin.calibrate.procedure.observed import (
    PileObservables,
    joined,
    observed,
)
from benchtwin.calibrate.procedure.rigs import BESIDE, PILE, RANGES
from benchtwin.calibrate.procedure.simulator import Run, campaign
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.posterior import on_grid
from benchtwin.calibrate.statistics.prior import Prior

BOX = Box.of(RANGES)
TRUE = dict(zip(RANGES, (0.55, 0.55, 0.05), strict=True))
REPEATS, SEED, CELLS, AT_TRUE = 5, 11, 41, 100
# the box of docs/drawdown.md between panes that rub; a slice out of a larger, deep one
BOXES: dict[str, dict] = {
    "SMALL": {"pane_friction": 0.34},
    "LARGE": {
        "box_mm": [165.0, 30.0, 140.0],
        "fill_height_mm": 90.0,
        "tray_mm": 200.0,
        "slab": True,
    },
}
HEAP = PILE.simulated({}, 30.0, 60.0)[0]
# columns that a bench reads or weighs: all draws of a rig's design know them
COLUMNS = {
    "pile": ("repose_angle_deg", "centroid_angle_deg", "filled_mass_g"),
    "drawdown": (
        *("shear_angle_deg", "shear_centroid_deg", "heap_angle_deg"),
        *("heap_centroid_deg", "flow_time_s", "filled_mass_g", "retained_mass_g"),
    ),
    "bed": ("bed_rebound_mm",),
}


def runs(rig: str, points: int, box: str) -> list[Run]:
    """The design's runs and the bench's, in this order."""
    sobol = qmc.Sobol(len(RANGES), rng=np.random.default_rng(7)).random(32)[:points]
    design = [dict(zip(RANGES, map(float, row))) for row in BOX.natural(2 * sobol - 1)]
    numbered = [*enumerate(design), *((AT_TRUE + k, TRUE) for k in range(REPEATS))]
    description = {rig: {"pile": HEAP, "drawdown": BOXES[box]}.get(rig, {})}
    return [Run(rig, at, (SEED, k), description) for k, at in numbered]


def table_of(rig: str, points: int, box: str, store: Path) -> pd.DataFrame:
    """A row a run that could be measured: its parameters, and what the simulation knows
    of it. A draw-down that jammed is none."""
    asked = runs(rig, points, box)
    with campaign(store, workers=1) as simulate:
        told = simulate(asked)
    values = pd.DataFrame([run.values for run in asked])
    known = told.filter(regex="^true_").rename(
        columns=lambda c: c.removeprefix("true_")
    )
    at = [run.rng[1] for run in asked]
    table = pd.concat([values, known], axis=1).assign(rig=rig, k=at)
    there = told["status"].eq("done").to_numpy()
    if "jammed" in table:
        there &= ~(table["jammed"] > 0).to_numpy()
    return table[there]


def seen_of(rig: str, table: pd.DataFrame, at: int = AT_TRUE) -> PileObservables:
    """What a bench's runs of a rig say, by surfaces through the others: those at TRUE,
    or the one at point `at` of the design."""
    own = table[table["rig"] == rig]
    bench = own[own["k"] >= AT_TRUE] if at == AT_TRUE else own[own["k"] == at]
    design = own.drop(bench.index) if at != AT_TRUE else own[own["k"] < AT_TRUE]
    there = [c for c in COLUMNS[rig] if c in own and bench[c].notna().any()]
    read = {c: bench[c].dropna().to_numpy(float) for c in there}
    response, *further = there
    readings = RigReadings(
        rig=rig,
        response=response,
        values=read[response],
        reading_sd=np.zeros(read[response].size),
        further={c: read[c] for c in further},
    )
    told = PILE if rig == PILE.name else BESIDE[rig]
    return observed(design, readings, BOX, None, alike=True, rig=told)


def effects(rig: str, seen: PileObservables) -> str:
    """Scatter of one run, and each parameter's main effect over half its range, in
    that scatter."""
    lines = []
    for o in seen.observables:
        s = o.surrogate
        main = s.coefficients[1 : 1 + len(RANGES)] / s.noise_sd  # type: ignore[attr-defined]
        shown = "  ".join(f"{v:+6.1f}" for v in main)
        lines.append(f"  {o.name:32s} {s.noise_sd:7.3f}  {shown}")  # type: ignore[attr-defined]
    return "\n".join(lines)


def intervals(
    seen: dict[str, PileObservables], true: Mapping[str, float]
) -> pd.DataFrame:
    """95 % intervals of the parameters from these rigs together."""
    observables, correlation = joined(tuple(seen.values()))
    rng, several = np.random.default_rng(1), len(observables) > 1
    posterior = on_grid(
        list(observables),
        Prior.uniform(BOX),
        rng=rng,
        cells=CELLS,
        correlation=correlation.to_numpy() if several else None,
    )
    found = posterior.draws.quantile([0.5, 0.025, 0.975]).T
    found.columns = ["median", "low", "high"]
    found["width"] = found["high"] - found["low"]
    found["true"] = pd.Series(true)
    return found


def drawn(table: pd.DataFrame, rigs: list[str]) -> pd.DataFrame:
    """Of benches of one recording a rig, drawn over the ranges: how many there are, how
    many intervals hold, and their median width; a row a parameter."""
    found = []
    points = table[table["k"] < AT_TRUE].groupby("k")
    for at, rows in points:
        if set(rigs) <= set(rows["rig"]):
            seen = {rig: seen_of(rig, table, int(at)) for rig in rigs}
            found.append(intervals(seen, rows.iloc[0][list(RANGES)]))
    both = pd.concat(found)
    both["holds"] = (both["low"] <= both["true"]) & (both["true"] <= both["high"])
    by = both.groupby(level=0, sort=False)
    columns = {"benches": by.size(), "hold": by["holds"].sum()}
    return pd.DataFrame(columns | {"width": by["width"].median()})


def report(table: pd.DataFrame, rigs: list[str]) -> None:
    """Print what each rig shows, and the intervals of heaps with every rig more."""
    seen = {rig: seen_of(rig, table) for rig in rigs}
    print(f"of one run: scatter; effect of {', '.join(RANGES)} in it")
    for rig, one in seen.items():
        print(effects(rig, one))
    further = [rig for rig in rigs if rig != PILE.name]
    sets = {PILE.name: [PILE.name]}
    sets |= {f"{PILE.name} and {rig}": [PILE.name, rig] for rig in further}
    sets |= {"all": rigs} if len(further) > 1 else {}
    for name, some in sets.items():
        print(f"{name}: {REPEATS} of each")
        print(intervals({rig: seen[rig] for rig in some}, TRUE).round(4).to_string())
        print(f"{name}: drawn benches with 1 of each")
        print(drawn(table, some).round(4).to_string())


def main() -> None:
    """Simulate and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("store", type=Path)
    parser.add_argument("--points", type=int, default=24)
    parser.add_argument("--rigs", default="pile,drawdown,bed")
    parser.add_argument("--box", choices=tuple(BOXES), default="LARGE")
    asked = parser.parse_args()
    rigs = asked.rigs.split(",")
    tables = [table_of(r, asked.points, asked.box, asked.store) for r in rigs]
    report(pd.concat(tables, ignore_index=True), rigs)


if __name__ == "__main__":
    main()
