"""Rows of contact parameters to compare engines at: from a CSV whose columns are
parameters' names, or the paper's optimum."""

import math
from pathlib import Path
from typing import Any

import pandas as pd

from benchtwin.twin.parameters import Parameters

PARAMETERS = (
    "restitution",
    "static_friction",
    "rolling_friction",
    "seed_restitution",
    "seed_static_friction",
    "seed_rolling_friction",
)


def read_rows(file: Path | None) -> tuple[list[dict[str, Any]], list[str]]:
    """Values by name, a dict a row, and the columns that are no parameters; [{}] (the
    defaults) without a file.

    ValueError names a file, row and column that cannot be used.
    """
    if file is None:
        return [{}], []
    try:
        table = pd.read_csv(file, dtype=str, keep_default_na=False)
    except OSError as error:
        raise ValueError(f"{file}: {error.strerror or error}") from error
    except ValueError as error:  # pandas' own errors of reading, UnicodeDecodeError
        raise ValueError(f"{file}: cannot be read as a table: {error}") from error
    used = [name for name in table.columns if name in PARAMETERS]
    if not used or table.empty:
        raise ValueError(
            f"{file}: no row, or no column of {', '.join(PARAMETERS)}; it has"
            f" {', '.join(map(str, table.columns))}"
        )
    rows = []
    for number, values in enumerate(table[used].to_dict("records"), start=2):
        row: dict[str, Any] = {
            str(name): _number(value) for name, value in values.items()
        }
        wrong = [
            f"{name} = {values[name]!r}: a number is needed in every row"
            for name in used
            if row[name] is None
        ]
        try:
            if not wrong:
                Parameters(**row)
        except ValueError as error:
            wrong.append(str(error))
        if wrong:
            raise ValueError(f"{file}, row {number} (the heading is row 1): {wrong[0]}")
        rows.append(row)
    return rows, [str(name) for name in table.columns if name not in used]


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def label(row: dict[str, Any]) -> str:
    """A row in a word or two: only what it states."""
    short = {name: "".join(word[0] for word in name.split("_")) for name in PARAMETERS}
    return (
        ", ".join(f"{short[name]} {value:g}" for name, value in row.items())
        or "the paper's optimum"
    )
