"""Twins of heaps in bench folders of plain seeds and of others ([pile] plain): how far
off are heaps that were left out, without and with an effect, beside what repeats
differ by? And do predictions of plain heaps hold, calibrated by the others?

    python benchmarks/heap_twins.py EFFECT BENCH [BENCH ...]

Some minutes a bench; simulated heaps, and pictures of outlines, are kept in
benchmark-runs/, and heaps there are not run again. The last columns: share of 95 %
intervals (angle, heights of the surface) that hold a plain heap, given the other plain
ones; and given those of the bench before."""

import argparse
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from benchtwin.diagnose.rerun import Resimulation
from benchtwin.rigs.pile.heap_twin import (
    Rig,
    added_to,
    is_plain,
    posterior,
    responding,
    shows,
)
from benchtwin.rigs.pile.read import SeenPile, read_piles
from benchtwin.rigs.pile.resimulation import resimulate
from benchtwin.twin.bench_folder import Observed

STORE = Path("benchmark-runs/heap-twins")


def held(heap: SeenPile, rig: Rig, plain: list[SeenPile], told: Rig, added) -> list:
    """Whether what one more heap of plain seeds, of this rig, shows lies in its 95 %,
    given the heaps `plain` of the rig `told`."""
    draws = posterior([replace(told, recordings=tuple(plain))], added)
    draws, rng, found = rig.place(draws, heap), np.random.default_rng(1), []
    for seen, response in zip(shows(heap), rig.responses, strict=True):
        if response is None or not np.isfinite(seen):
            continue
        mean, variance = response.at(draws)
        sd = np.sqrt(variance + response.packing_sd**2)
        low, high = np.quantile(rng.normal(mean, sd), [0.025, 0.975])
        found.append(bool(low <= seen <= high))
    return found


def drawn(again: Resimulation, file: Path) -> None:
    """The mean outline of one kind of heaps that were left out, and its twins'."""
    plt.rcParams["font.size"] = 8
    figure, axes = plt.subplots(figsize=(7, 3.8), layout="constrained")
    styles = dict(zip(again.figure["points"], ("k.", "C1--", "C0-"), strict=True))
    for name, (x, y) in again.figure["points"].items():
        axes.plot(x, y, styles[name], label=name)
    axes.set(xlabel=again.figure["x"], ylabel=again.figure["y"])
    axes.legend()
    figure.savefig(file, dpi=110)


def twin_of(bench: Path, effect: str, before: tuple | None) -> tuple[dict, tuple]:
    """One row of the table, and (plain heaps, rig, effect) for the next."""
    read = read_piles(Observed.under(bench).with_rigs())
    seen = [s for s in read if not s.trouble]
    plain = [s for s in seen if is_plain(s)]
    names = tuple(s.recording for s in seen)
    named = {"modelled": (effect,), "names": (effect,)}
    asked = SimpleNamespace(recordings=names, **named)
    again = resimulate(asked, seen, STORE, False, print)
    added = added_to(seen, effect)
    rig = responding(tuple(seen), added, STORE / "heaps", print)
    own = [
        ok
        for k, heap in enumerate(plain)
        for ok in held(heap, rig, [*plain[:k], *plain[k + 1 :]], rig, added)
    ]
    other = []
    if before is not None:
        other = [ok for heap in plain for ok in held(heap, rig, *before)]
    off_before, off_after, *_ = again.total()
    drawn(again, STORE / f"{bench.name}.png")
    row = {
        "bench": bench.name,
        "off without": round(off_before, 4),
        "off with": round(off_after, 4),
        "repeats": round(again.repeats, 4),
        "change": again.change,
        "notes": "; ".join(again.notes),
        "own": f"{sum(own)} of {len(own)}",
        "other": f"{sum(other)} of {len(other)}",
    }
    return row, (plain, rig, added)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("effect")
    parser.add_argument("benches", type=Path, nargs="+")
    told = parser.parse_args()
    before, rows = None, []
    for bench in told.benches:
        row, before = twin_of(bench, told.effect, before)
        rows.append(row)
        print(row, flush=True)
    print(pd.DataFrame(rows).to_string(index=False))
