"""Simulated collapses of plain beads and of others, which hold liquid or have another
friction: which of the two do simulated heaps make likelier, and how strong a pull do
they give?

    python benchmarks/liquid_or_friction.py [BENCHES]       default 12

Each bench, last frames only: four plain heaps and four others in the channel of
samples/damp-heaps, at drawn frictions, gate and strength. Forty heaps are simulated
once for all benches; some five seconds a heap on one core. What was simulated is kept
in benchmark-runs/."""

import argparse
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.bench.whole_file import write_whole
from benchtwin.rigs.pile.heap_twin import (
    FIRST,
    OF_SEEDS,
    RUNS,
    Added,
    Rig,
    added_to,
    odds_over_friction,
    posterior,
    responding,
)
from benchtwin.rigs.pile.read import read_piles
from benchtwin.rigs.pile.simulated_heaps import UNKNOWNS, heap_job, heap_of, shape_of
from benchtwin.sim.engine.step import Stopped
from benchtwin.twin.bench_folder import Observed

SAMPLE = Path("samples/damp-heaps")
STORE = Path("benchmark-runs/liquid-or-friction")
HEAPS = 4


def hidden(number: int, added: Added) -> tuple[str, np.ndarray, np.ndarray]:
    """What is hidden, and draws (k,) in [0, 1] of plain beads and of others."""
    rng = np.random.default_rng([88, number])
    plain = np.append(rng.uniform(size=len(UNKNOWNS)), 0.0)
    others = plain.copy()
    if number % 2:
        others[-1] = rng.uniform(0.3, 0.9)
        return "liquid", plain, others
    at = [[*UNKNOWNS].index(name) for name in OF_SEEDS]
    # once and a half to three times as much of both
    low, high = np.array([UNKNOWNS[name] for name in OF_SEEDS]).T
    plain[at] = rng.uniform(0.1, 0.6, len(at))
    others[at] = plain[at] + np.log(rng.uniform(1.5, 3.0, len(at))) / np.log(high / low)
    return "friction", plain, others


def bench(number: int, rig: Rig, added: Added) -> dict:
    """One bench, and what is found."""
    what, plain, others = hidden(number, added)
    told, seen = rig.recordings[0].description, []
    for k in range(2 * HEAPS):
        draw, packing = (plain, others)[k % 2], FIRST + RUNS + 100 * number + k
        job = heap_job(told, added.settings(draw), added.seed_mm, packing)
        heap = replace(heap_of(job), recording=f"{k}", collapse=None)
        pile = heap.description["pile"] | {"plain": k % 2 == 0}
        seen.append(replace(heap, description=heap.description | {"pile": pile}))
    own = replace(rig, recordings=tuple(seen))
    angles = [shape_of([s]).angle_deg for s in seen]
    low, high = np.quantile(posterior([own], added)[:, -1], [0.025, 0.975])
    return {
        "hidden": what,
        "plain_deg": round(float(np.mean(angles[::2])), 1),
        "others_deg": round(float(np.mean(angles[1::2])), 1),
        "ln odds of liquid": round(float(np.log(odds_over_friction([own], added))), 1),
        "pull": round(float(others[-1] * added.most), 2),
        "low": round(float(low * added.most), 2),
        "high": round(float(high * added.most), 2),
    }


def kept(number: int, rig: Rig, added: Added) -> dict:
    """The same from its file, where it was run before."""
    if not (file := STORE / f"{number}.json").is_file():
        try:
            row = bench(number, rig, added)
        except (ValueError, Stopped) as error:  # too flat for a flank, or too soft
            row = {"hidden": "refused", "why": str(error).split("\n")[0]}
        STORE.mkdir(parents=True, exist_ok=True)
        write_whole(file, json.dumps(row))
    return json.loads(file.read_text())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("benches", type=int, nargs="?", default=12)
    benches = parser.parse_args().benches
    seen = tuple(read_piles(Observed.under(SAMPLE).with_rigs()))
    added = added_to(list(seen), "cohesion")
    rig = responding(seen, added, STORE / "heaps", print)
    rows = []
    for number in range(benches):
        rows.append(kept(number, rig, added))
        print(rows[-1], flush=True)
    table = pd.DataFrame(rows)
    print(table.to_string(index=False))
    right = (table["ln odds of liquid"] > 0) == (table.hidden == "liquid")
    print(f"the hidden one is the likelier in {right.sum()} of {len(table)}; ", end="")
    wet = table[table.hidden == "liquid"]
    print(f"its pull within 95 % in {wet.pull.between(wet.low, wet.high).sum()}")
