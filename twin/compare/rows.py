"""Rows of contact parameters to compare engines at: from a CSV whose columns are
parameters' names, or the paper's optimum."""

import math
from collections.abc import Mapping, Sequence
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


Row = dict[str, Any]


def rows_of(
    rows: str | Path | Sequence[Mapping[str, float]] | None,
) -> tuple[list[Row], list[str]]:
    """Values by name, a dict a row, and the columns of a file that are no parameters;
    [{}] (the defaults) without any. ValueError for what cannot be used."""
    if isinstance(rows, str | Path):
        return read_rows(Path(rows))
    return [_checked(row) for row in rows or ()] or [{}], []


def _checked(row: Mapping[str, float]) -> Row:
    """A row of parameters; ValueError for a name or a number that is none."""
    if wrong := [name for name in row if name not in PARAMETERS]:
        there = ", ".join(PARAMETERS)
        raise ValueError(f"rows: no parameter {wrong[0]!r}; there are {there}")
    numbers: Row = {name: float(value) for name, value in row.items()}
    Parameters(**numbers)  # so that it is refused now
    return numbers


def read_rows(file: Path) -> tuple[list[Row], list[str]]:
    """The rows of a CSV, and its columns that are no parameters. ValueError names a
    file, row and column that cannot be used."""
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
        row: Row = {str(name): _number(value) for name, value in values.items()}
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


def label(row: Row) -> str:
    """A row in a word or two: only what it states."""
    short = {name: "".join(word[0] for word in name.split("_")) for name in PARAMETERS}
    return (
        ", ".join(f"{short[name]} {value:g}" for name, value in row.items())
        or "the paper's optimum"
    )
