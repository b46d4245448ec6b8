"""How often does a diagnosis alarm on real recordings in which nothing is missing?

    python benchmarks/null_benches.py slide FOLDER [FOLDER ...] --benches 100
    → one line a bench; a table of them where --out names a file

Each bench is a few recordings drawn at random from all that the folders hold. p is to
be uniform, alarms as rare as they claim, and nothing named. Folders of slides:
DAIRLab/contact-nets' cube as it comes to rest, and any other recordings of which is
known that they hold nothing. Nothing of the recordings is kept."""

import argparse
import time
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats

from benchtwin.bench.rigs import RIGS
from benchtwin.infer.alarm import ALARM_P

LEAST, MOST = 5, 10  # recordings of a bench


def one_bench(rig: str, drawn: list, seed: int) -> dict:
    """What a diagnosis says of some recordings."""
    begun = time.process_time()
    with np.errstate(all="ignore"):
        found = RIGS[rig].part("diagnose")(drawn, np.random.default_rng(seed))
    said = found.names if found.alarm else ()
    return {
        "seed": seed,
        "recordings": len(drawn),
        "p": found.p_global,
        "verdict": found.verdict,
        "names": " ".join(said),
        "matters": found.matters,
        "cpu_s": time.process_time() - begun,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("rig", choices=RIGS)
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--benches", type=int, default=100)
    parser.add_argument("--rng", type=int, default=1)
    parser.add_argument("--out", type=Path)
    told = parser.parse_args()
    pool = [s for f in told.folders for s in RIGS[told.rig].part("read")(f)]
    pool = [s for s in pool if not s.trouble]
    rows = []
    for seed in range(told.rng, told.rng + told.benches):
        rng = np.random.default_rng(seed)
        own = rng.choice(len(pool), rng.integers(LEAST, MOST + 1), replace=False)
        rows.append(one_bench(told.rig, [pool[k] for k in own], seed))
        print(
            *(f"{k} {v:.3g}" if k == "p" else f"{k} {v}" for k, v in rows[-1].items())
        )
    table = pd.DataFrame(rows)
    if told.out:
        table.to_csv(told.out, index=False, float_format="%.4g")
    alarms = int((table.p < ALARM_P).sum())
    named = int((table.verdict == "name").sum())
    uniform = stats.kstest(table.p, "uniform").pvalue
    print(f"{len(pool)} recordings, {len(table)} benches: {alarms} alarms,")
    print(f"{named} with a name; p uniform: {uniform:.2g} (Kolmogorov–Smirnov)")
    print(f"seconds: {table.cpu_s.median():.1f}, 95 % {table.cpu_s.quantile(0.95):.1f}")


if __name__ == "__main__":
    main()
