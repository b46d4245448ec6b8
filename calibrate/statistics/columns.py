"""Checked numeric columns of tables; errors name the column."""

from collections.abc import Sequence

import numpy as np
import pandas as pd


def numbers(table: pd.DataFrame, columns: Sequence[str]) -> np.ndarray:
    """The columns as floats, (n, len(columns)); ValueError names a column that is
    missing, not numeric or not finite."""
    missing = [c for c in columns if c not in table.columns]
    if missing:
        raise ValueError("; ".join(_missing(table, c) for c in missing))
    out = np.empty((len(table), len(columns)))
    for j, column in enumerate(columns):
        try:
            out[:, j] = pd.to_numeric(table[column])
        except (ValueError, TypeError) as error:
            raise ValueError(f"column {column}: not a number ({error})") from None
        bad = np.flatnonzero(~np.isfinite(out[:, j]))
        if bad.size:
            raise ValueError(
                f"column {column}: row {bad[0] + 1} is empty or not finite"
            )
    return out


def _missing(table: pd.DataFrame, column: str) -> str:
    """What to say of a missing column: often only its unit is wrong or left out."""
    stem = column.rsplit("_", 1)[0]
    near = [
        str(c)
        for c in table.columns
        if column != stem and (c == stem or str(c).rsplit("_", 1)[0] == stem)
    ]
    if near:
        hint = f"; {near[0]} has another unit or none"
    else:
        hint = f"; there are {', '.join(map(str, table.columns))}"
    return f"column {column} is missing{hint}"
