"""Columns in the tables of other tools: headings, units and numbers."""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vision.foreign.source import Rows
from vision.measurement import MeasurementError

LARGEST = 2e18  # of any number: nanoseconds since 1970 are 1.8e18
LENGTH = {  # → millimetres
    "mm": 1.0, "millimeter": 1.0, "millimetre": 1.0, "cm": 10.0, "centimeter": 10.0, "centimetre": 10.0, "dm": 100.0, "m": 1000.0,
    "meter": 1000.0, "metre": 1000.0, "meters": 1000.0, "metres": 1000.0, "µm": 1e-3, "μm": 1e-3, "um": 1e-3, "micron": 1e-3,
    "microns": 1e-3, "nm": 1e-6, "in": 25.4, "inch": 25.4, "inches": 25.4, "ft": 304.8, "feet": 304.8, "yd": 914.4,
}  # fmt: skip
PIXELS = ("px", "pixel", "pixels", "pix")
TIME = {  # → seconds
    "s": 1.0, "sec": 1.0, "secs": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "msec": 1e-3, "millisecond": 1e-3,
    "milliseconds": 1e-3, "µs": 1e-6, "μs": 1e-6, "us": 1e-6, "ns": 1e-9, "nanoseconds": 1e-9, "min": 60.0, "minute": 60.0,
    "minutes": 60.0, "h": 3600.0, "hour": 3600.0,
}  # fmt: skip
FRAMES = ("frame", "frames", "slice", "slices")
_IN_BRACKETS = re.compile(r"(.*?)[\s_]*[\(\[]\s*([^()\[\]]*?)\s*[\)\]]\s*")


def name_and_unit(heading: object) -> tuple[str, str]:
    """A column's name and the unit in brackets behind it, both in small letters: "Time (s)" → ("time", "s")."""
    text = str(heading).strip().strip('"').lower()
    found = _IN_BRACKETS.fullmatch(text)
    return (found[1].strip(), found[2]) if found else (text, "")


def heading_row(rows: Rows) -> int:
    """Row of the headings: the last one before the numbers."""
    numbers = (k for k, row in enumerate(rows[:7]) if any(isinstance(cell, float) for cell in row))
    return next(numbers, min(6, len(rows))) - 1


def column(path: Path, rows: Rows, at: int, name: str, first_line: int) -> np.ndarray:
    """One column of numbers, NaN for an empty cell; MeasurementError naming column and line for words. first_line: of `rows`."""
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
        found = ", ".join(headings)[:200]
        raise MeasurementError(f"{path}: column {', '.join(missing)} is missing; found {found}")
    return [headings.index(n) for n in names]
