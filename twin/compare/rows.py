"""Rows of contact parameters to compare engines at: from a CSV whose columns are
parameters' names, or the paper's optimum."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from benchtwin.twin.bench_folder import read_numbers
from benchtwin.twin.parameters import Parameters

PARAMETERS = (
    "restitution",
    "static_friction",
    "rolling_friction",
    "seed_restitution",
    "seed_static_friction",
    "seed_rolling_friction",
)


LIMITS = (0.0, 5.0)  # of any of them

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
    if not file.is_file():
        raise ValueError(f"{file}: no such file")
    table = read_numbers(file, {}, dict.fromkeys(PARAMETERS, LIMITS))
    if table.empty:
        raise ValueError(f"{file}: no row, or no column of {', '.join(PARAMETERS)}")
    rows: list[Row] = [
        {str(name): float(value) for name, value in row.items()}
        for row in table.to_dict("records")
    ]
    for number, row in enumerate(rows, start=2):
        try:
            Parameters(**row)
        except ValueError as error:
            raise ValueError(
                f"{file}, row {number} (the heading is row 1): {error}"
            ) from None
    heading = pd.read_csv(file, nrows=0, sep=None, engine="python", comment="#")
    return rows, [str(name) for name in heading if name not in table]


def label(row: Row) -> str:
    """A row in a word or two: only what it states."""
    short = {name: "".join(word[0] for word in name.split("_")) for name in PARAMETERS}
    return (
        ", ".join(f"{short[name]} {value:g}" for name, value in row.items())
        or "the paper's optimum"
    )
