"""Columns in the tables of other tools."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vision.foreign.source import Rows
from vision.measurement import MeasurementError

LARGEST = 2e18  # of any number: nanoseconds since 1970 are 1.8e18


def heading_row(rows: Rows, *, most: int = 6) -> int:
    """Row of the headings: the last one before the numbers."""
    for k, row in enumerate(rows[: most + 1]):
        if any(isinstance(cell, float) for cell in row):
            return k - 1
    return min(most, len(rows)) - 1


def column(path: Path, rows: Rows, at: int, name: str, first_line: int) -> np.ndarray:
    """One column of numbers; an empty cell is NaN. MeasurementError naming column and line for words.

    rows: those below the headings; first_line: the number of the first of them among the file's lines that are not empty.
    """
    values = np.full(len(rows), np.nan)
    for k, row in enumerate(rows):
        cell = row[at] if at < len(row) else ""
        if isinstance(cell, float):
            values[k] = cell
        elif cell and cell.lower() not in ("nan", "none", "null", "-", "∞", "inf", "-inf"):
            raise MeasurementError(f"{path}: {name} = {cell[:30]!r} in line {first_line + k} is not a number")
    values[~np.isfinite(values)] = np.nan
    if (wrong := np.flatnonzero(np.abs(np.nan_to_num(values)) > LARGEST)).size:
        raise MeasurementError(f"{path}: {name} = {values[wrong[0]]:g} in line {first_line + wrong[0]} cannot be")
    return values


def need(path: Path, headings: Sequence[str], names: Sequence[str]) -> list[int]:
    """Indices of the columns `names` in `headings`; MeasurementError naming those that are missing."""
    if missing := [n for n in names if n not in headings]:
        raise MeasurementError(f"{path}: column {', '.join(missing)} is missing; found {', '.join(headings)[:200]}")
    return [headings.index(n) for n in names]
