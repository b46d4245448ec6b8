"""Are the probabilities of verdicts true? Stated against true, rig by rig.

    python benchmarks/reliability.py TABLE.csv [TABLE.csv ...] --out PICTURE.png
    → the picture, and the same numbers as rows of a table

A table has one line a bench: rig, p_verdict (stated probability of exactly the verdict)
and as_said (whether the verdict is true), as `benchtwin prove` writes them in
cases.csv.
Intervals are Clopper–Pearson's of 95 %; the true share of a bin lies within them where
the stated probabilities are true."""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.prove.score import EDGES, binomial_interval


def bins_of(table: pd.DataFrame) -> pd.DataFrame:
    """Of each bin that has benches: n, mean stated probability, true share and its
    95 % interval."""
    rows = []
    for _, own in table.groupby(pd.cut(table.p_verdict, EDGES), observed=True):
        right, n = int(own.as_said.sum()), len(own)
        ends = binomial_interval(right, n)
        rows.append((n, own.p_verdict.mean(), right / n, *ends))
    return pd.DataFrame(rows, columns=["n", "stated", "true", "low95", "high95"])


def draw(found: dict[str, pd.DataFrame], out: Path) -> None:
    """One panel a rig: true share over stated probability, with the diagonal."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, panels = pyplot.subplots(
        1, len(found), figsize=(3.1 * len(found), 3.3), sharey=True, squeeze=False
    )
    for axes, (rig, bins) in zip(panels[0], found.items(), strict=True):
        axes.plot([0, 1], [0, 1], ":", color="#6b7280", linewidth=1)
        off = np.abs([bins.true - bins.low95, bins.high95 - bins.true])
        axes.errorbar(bins.stated, bins.true, off, fmt="o", color="#1f5fa8", capsize=2)
        for b in bins.itertuples():
            axes.annotate(
                str(b.n), (b.stated, b.true), (5, -11), textcoords="offset points"
            )
        axes.set(title=rig, xlim=(0.2, 1.02), ylim=(0, 1.02), xlabel="stated")
    panels[0][0].set_ylabel("true")
    figure.tight_layout()
    figure.savefig(out, dpi=130)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tables", type=Path, nargs="+")
    parser.add_argument("--out", type=Path)
    told = parser.parse_args()
    table = pd.concat([pd.read_csv(path) for path in told.tables])
    table = table[table.p_verdict.notna()].astype({"as_said": bool})
    parts = {"all": table} | {str(rig): own for rig, own in table.groupby("rig")}
    found = {rig: bins_of(own) for rig, own in parts.items()}
    for rig, bins in found.items():
        for b in bins.itertuples():
            print(
                f"| {rig} | {b.n} | {b.stated:.2f} | {b.true:.2f}"
                f" ({b.low95:.2f}–{b.high95:.2f}) |"
            )
    if told.out:
        draw(found, told.out)


if __name__ == "__main__":
    main()
