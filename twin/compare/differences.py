"""Differences between two engines, paired by packing, with 95 % intervals (Student's
t)."""

import numpy as np
import pandas as pd
from scipy import stats

QUANTITIES = {
    "repose_angle_deg": "angle of repose (°)",
    "centroid_angle_deg": "centroid's angle (°)",
    "crest_mm": "crest's height (mm)",
    "filled_mass_g": "mass filled in (g)",
    "retained_mass_g": "mass left (g)",
}
ALL = "all rows"
COLUMNS = [
    "row",
    "parameters",
    "quantity",
    "pairs",
    "ours",
    "lammps",
    "difference",
    "low",
    "high",
    "parts",
]


def differences(runs: pd.DataFrame) -> pd.DataFrame:
    """A line a row and quantity, then a line a quantity of all rows together.

    runs: row, parameters, packing, engine ("benchtwin", "lammps") and a column a
    quantity; one without a partner is left out. difference: mean of LAMMPS − ours over
    packings; low, high: its 95 % interval, NaN of fewer than two pairs; parts: whether
    that leaves out 0. All rows: packings are what repeats, so each counts once, by its
    mean over the rows that have it."""
    lines = []
    for quantity in QUANTITIES:
        wide = paired(runs, quantity)
        lines += [
            _line(str(row), parameters, quantity, pairs)
            for (row, parameters), pairs in wide.groupby(
                ["row", "parameters"], sort=True
            )
        ]
        if wide["row"].nunique() > 1:
            means = wide.groupby("packing")[["benchtwin", "lammps"]].mean()
            lines.append(_line(ALL, "", quantity, means))
    return pd.DataFrame(lines, columns=COLUMNS)


def paired(runs: pd.DataFrame, quantity: str) -> pd.DataFrame:
    """A line a pair of piles of one packing: row, parameters, packing, benchtwin,
    lammps."""
    wide = runs.pivot_table(
        index=["row", "parameters", "packing"],
        columns="engine",
        values=quantity,
        dropna=False,
    )
    return wide.reindex(columns=["benchtwin", "lammps"]).dropna().reset_index()


def _line(row: str, parameters: str, quantity: str, pairs: pd.DataFrame) -> tuple:
    apart = (pairs["lammps"] - pairs["benchtwin"]).to_numpy(float)
    n, mean = len(apart), float(apart.mean())
    if n > 1:
        half = float(stats.t.ppf(0.975, n - 1) * apart.std(ddof=1) / np.sqrt(n))
    else:
        half = float("nan")
    # False of a single pair, which tells nothing of scatter
    parts = bool(abs(mean) > half)
    return (
        row,
        parameters,
        quantity,
        n,
        pairs["benchtwin"].mean(),
        pairs["lammps"].mean(),
        mean,
        mean - half,
        mean + half,
        parts,
    )


def verdict(table: pd.DataFrame) -> str:
    """Where the engines part, and how often chance alone would make them seem to."""
    known = table[table["low"].notna()]
    if known.empty:
        return "a single packing tells nothing of scatter: give --packings 2 or more"
    single = known[known["row"] != ALL]
    by_row = single[single["parts"]]
    where = (
        ", ".join(
            f"row {r.row}: {QUANTITIES[r.quantity]} {r.difference:+.2g}"
            for r in by_row.itertuples()
        )
        or "nowhere"
    )
    chance = (
        f"{len(by_row)} of {len(single)} intervals leave out 0, by chance alone"
        f" {0.05 * len(single):.1g} would"
    )
    of_all = known[(known["row"] == ALL) & known["parts"]]
    text = f"the engines part: {where} ({chance})"
    if len(known) > len(single):
        together = (
            ", ".join(
                f"{QUANTITIES[r.quantity]} {r.difference:+.2g}"
                for r in of_all.itertuples()
            )
            or "nowhere"
        )
        text += f"; all rows together: {together}"
    return text
