"""The soybean paper's tables beside ours as one picture, from the CSV files that
paper.py wrote.

python benchmarks/paper_picture.py      → docs/paper-tables.png
"""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd

ROOT = Path(__file__).parent.parent
TWIN, PICTURE = (
    ROOT / "samples" / "soybean-paper" / "twin",
    ROOT / "docs" / "paper-tables.png",
)
PAPER, OURS, PLAIN = "#444444", "#d0611a", "#4a7fb5"


def panel(
    axis,
    table: pd.DataFrame,
    x: str,
    unit: str,
    labels: tuple[str, str],
    theory: tuple[str, str] | None = None,
) -> None:
    """Paper with its sd, twin with its sd, and a closed form where there is one."""
    if theory:
        axis.plot(
            table[x], table[theory[0]], color=PLAIN, lw=1, ls="--", label=theory[1]
        )
    paper_sd = table.get(f"paper_sd_{unit}")
    axis.errorbar(
        table[x],
        table[f"paper_{unit}"],
        yerr=paper_sd,
        fmt="s",
        color=PAPER,
        ms=5,
        capsize=2,
        label="paper (EDEM)",
    )
    axis.errorbar(
        table[x],
        table[f"twin_{unit}"],
        yerr=table[f"twin_sd_{unit}"],
        fmt="o",
        color=OURS,
        ms=5,
        capsize=2,
        label="benchtwin",
    )
    for column, said in (
        ("top_mm", "benchtwin, the seed's upper side"),
        ("seen_deg", "benchtwin, slid 5 mm"),
    ):
        if column in table:
            axis.plot(
                table[x], table[column], "^", color=OURS, mfc="none", ms=6, label=said
            )
    axis.set(xlabel=labels[0], ylabel=labels[1])
    axis.legend(frameon=False, fontsize=8)


def main() -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    figure = plt.figure(figsize=(14, 9), layout="constrained")
    above, below = figure.subfigures(
        2, 1, squeeze=False
    ).ravel()  # apart: the choices' long names narrow one row only
    axes = np.array([above.subplots(1, 3), below.subplots(1, 3)])
    read = {path.stem: pd.read_csv(path) for path in TWIN.glob("*.csv")}
    panel(
        axes[0, 0],
        read["table02"],
        "restitution",
        "mm",
        ("restitution, seed on steel", "rebound height [mm]"),
        ("e2_h1_mm", "e² H1"),
    )
    panel(
        axes[0, 1],
        read["table04"],
        "static_friction",
        "deg",
        ("static friction, seed on steel", "sliding angle [°]"),
        ("atan_deg", "atan μ"),
    )
    panel(
        axes[0, 2],
        read["table06"],
        "rolling_friction",
        "mm",
        ("rolling friction, seed on steel", "run-out [mm]"),
        ("energy_mm", "energy, Eq. (3)"),
    )
    seven = read["table07"].assign(row=np.arange(1, 7))
    panel(
        axes[1, 0], seven, "row", "deg", ("Table 7, group", "angle of repose [°], ± sd")
    )
    nine = read["table09"]
    axes[1, 1].errorbar(
        nine["paper_deg"],
        nine["twin_deg"],
        yerr=nine["twin_sd_deg"] / np.sqrt(nine["runs"]),
        fmt="o",
        color=OURS,
        capsize=2,
    )
    span = [
        min(nine["paper_deg"].min(), nine["twin_deg"].min()) - 0.5,
        max(nine["paper_deg"].max(), nine["twin_deg"].max()) + 0.5,
    ]
    axes[1, 1].plot(span, span, color=PLAIN, lw=1, ls="--", label="equal")
    axes[1, 1].set(
        xlabel="Table 9, paper [°]", ylabel="benchtwin [°], mean ± se over packings"
    )
    axes[1, 1].legend(frameon=False, fontsize=8)
    choices = read["choices_pile"].iloc[1:][::-1]
    axes[1, 2].barh(
        choices["choice"],
        choices["change_deg"],
        xerr=choices["change_se_deg"],
        color=OURS,
        ecolor=PAPER,
        height=0.6,
    )
    axes[1, 2].axvline(0, color=PAPER, lw=0.8)
    axes[1, 2].set(xlabel="change of the angle [°], ± se", title="choices left open")
    axes[1, 2].tick_params(axis="y", labelsize=6)
    for axis, title in zip(
        axes.flat,
        (
            "Table 2: rebound",
            "Table 4: sliding",
            "Table 6: rolling",
            "Table 7: steepest ascent",
            "Table 9: Box–Behnken",
        ),
    ):
        axis.set_title(title)
    figure.savefig(PICTURE, dpi=110)


if __name__ == "__main__":
    argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    ).parse_args()
    main()
