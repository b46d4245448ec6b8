"""Rows of contact parameters to compare engines at: from a CSV whose columns are parameters' names, or the paper's optimum."""

from pathlib import Path
from typing import Any

import pandas as pd

from twin.parameters import Parameters

PARAMETERS = (
    "restitution", "static_friction", "rolling_friction", "seed_restitution", "seed_static_friction", "seed_rolling_friction",
)  # fmt: skip


def read_rows(file: Path | None) -> tuple[list[dict[str, Any]], list[str]]:
    """Values by name, a dict a row, and the columns that are no parameters; [{}] (the defaults) without a file.

    ValueError names a file, line and column that cannot be used.
    """
    if file is None:
        return [{}], []
    try:
        table = pd.read_csv(file)
    except OSError as error:
        raise ValueError(f"{file}: {error.strerror or error}") from error
    except ValueError as error:  # pandas' own errors of reading, UnicodeDecodeError
        raise ValueError(f"{file}: cannot be read as a table: {error}") from error
    used = [name for name in table.columns if name in PARAMETERS]
    if not used or table.empty:
        raise ValueError(f"{file}: no row, or no column of {', '.join(PARAMETERS)}; it has {', '.join(map(str, table.columns))}")
    rows = []
    for line, values in enumerate(table[used].to_dict("records"), start=2):
        for name, value in values.items():
            if not isinstance(value, int | float) or not value == value:
                raise ValueError(f"{file}, line {line}: {name} = {value}: a number is needed in every line")
        row = {name: float(value) for name, value in values.items()}
        try:
            Parameters(**row)
        except ValueError as error:
            raise ValueError(f"{file}, line {line}: {error}") from error
        rows.append(row)
    return rows, [str(name) for name in table.columns if name not in used]


def label(row: dict[str, Any]) -> str:
    """A row in a word or two: only what it states."""
    short = {name: "".join(word[0] for word in name.split("_")) for name in PARAMETERS}
    return ", ".join(f"{short[name]} {value:g}" for name, value in row.items()) or "the paper's optimum"
