"""What a blind proof found, as two pictures: how small an effect raises an alarm, and
what was said of what was concealed.

    python benchmarks/proof_pictures.py benchmarks/tables/prove/cases.csv --out docs
    → proof-power.png, proof-names.png

The table is the cases.csv of `benchtwin prove`. Bars and bands are 95 % intervals:
Clopper–Pearson's of shares, the fitted curve's two points by bootstrap."""

import argparse
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.prove.score import GRID, Power, binomial_interval, power_curve

STEPS = (0.0, 3.0, 5.0, 7.0, 10.0, 15.0, math.inf)  # of SNR
KINDS = {
    "clean": "nothing",
    "single": "one effect",
    "separated": "one of two alike, with what separates",
    "confounded": "one of two alike, without it",
    "condition": "a stated condition",
    "compound": "two effects",
    "outside": "what is on no list",
}
SAID = ("right", "class with it", "unknown", "none", "class without it", "wrong")
COLOURS = ("#2e7d4f", "#8cc3a0", "#d9a441", "#c9ced6", "#e58a80", "#b3261e")


def shares(table: pd.DataFrame) -> pd.DataFrame:
    """Of cases in each step of SNR: mean SNR, share of alarms, its interval, n."""
    rows = []
    for low, high in pairwise(STEPS):
        some = table[(table.snr >= low) & (table.snr < high)]
        if n := len(some):
            k = int(some.alarm.sum())
            rows.append((some.snr.mean(), k / n, *binomial_interval(k, n), n))
    return pd.DataFrame(rows, columns=["snr", "share", "low", "high", "n"])


def said_of(case) -> str:
    """How a diagnosis stands to what was concealed; what is on no list is rightly
    unknown."""
    if case.verdict == "unknown":
        return "right" if case.kind == "outside" else "unknown"
    if case.verdict == "name":
        return "right" if case.right else "wrong"
    if case.verdict == "class":
        return "class with it" if case.as_said else "class without it"
    if case.kind == "clean":
        return "right"
    return "none"


def draw_power(found: pd.DataFrame, curve: Power, file: Path) -> None:
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6.2, 3.4))
    axes.plot(GRID, curve.at(GRID), color="#1f5fa8")
    off = np.abs([found.share - found.low, found.high - found.share])
    axes.errorbar(found.snr, found.share, off, fmt="o", color="#1b1f24", capsize=2)
    for b in found.itertuples():
        axes.annotate(str(b.n), (b.snr, b.share), (6, -12), textcoords="offset points")
    for share, at, (low, high) in (
        (0.5, curve.snr50, curve.interval50),
        (0.9, curve.snr90, curve.interval90),
    ):
        axes.plot([low, high], [share, share], color="#1f5fa8", alpha=0.4, linewidth=4)
        axes.annotate(f"{at:.1f}", (at, share), (4, 4), textcoords="offset points")
    axes.set(xscale="log", xlim=(1, 60), ylim=(-0.02, 1.04))
    axes.set(xlabel="signal-to-noise ratio of what was concealed", ylabel="alarms")
    ticks = [1, 2, 4, 8, 16, 32]
    axes.set_xticks(ticks, [str(t) for t in ticks])
    figure.tight_layout()
    figure.savefig(file, dpi=130)


def draw_names(table: pd.DataFrame, file: Path) -> None:
    """A bar a rig and kind of case, divided by what was said of them."""
    from matplotlib import pyplot

    ranks = pd.MultiIndex.from_product([table.rig.unique(), KINDS])
    counts = pd.crosstab([table.rig, table.kind], table.apply(said_of, axis=1))
    counts = counts.reindex(columns=list(SAID), fill_value=0)
    counts = counts.reindex(ranks).dropna()[::-1].astype(int)
    names = [f"{rig}: {KINDS[kind]}" for rig, kind in counts.index]
    figure, axes = pyplot.subplots(figsize=(7.2, 0.6 + 0.22 * len(counts)))
    left = np.zeros(len(counts))
    for name, colour in zip(SAID, COLOURS, strict=True):
        share = (counts[name] / counts.sum(axis=1)).to_numpy()
        axes.barh(names, share, left=left, color=colour, label=name)
        left += share
    for y, n in enumerate(counts.sum(axis=1)):
        axes.annotate(str(n), (1, y), (4, -3), textcoords="offset points", fontsize=8)
    axes.set(xlim=(0, 1.05), xticks=[], ylim=(-0.6, len(counts) - 0.4))
    axes.tick_params(axis="y", labelsize=8, length=0)
    axes.spines[:].set_visible(False)
    figure.legend(
        *axes.get_legend_handles_labels(), loc="upper center", ncols=6, fontsize=8
    )
    figure.tight_layout(rect=(0, 0, 1, 0.95))
    figure.savefig(file, dpi=130)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    told = parser.parse_args()
    import matplotlib

    matplotlib.use("Agg")
    table = pd.read_csv(told.table, keep_default_na=False, na_values={"snr": [""]})
    for column in ("alarm", "right", "as_said"):
        table[column] = table[column].astype(str) == "True"
    single = table[
        (table.kind != "clean") & ~table.concealed.str.contains(" + ", regex=False)
    ]
    rng = np.random.default_rng(1)
    curve = power_curve(single.snr.to_numpy(), single.alarm.to_numpy(), rng)
    draw_power(shares(single), curve, told.out / "proof-power.png")
    draw_names(table, told.out / "proof-names.png")


if __name__ == "__main__":
    main()
