"""Detects the column separator and the decimal mark of a text table."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

_WITH_POINT = re.compile(r"\s*[+-]?\d*\.\d+(?:[eE][+-]?\d+)?\s*")
_WITH_COMMA = re.compile(r"\s*[+-]?\d*,\d+(?:[eE][+-]?\d+)?\s*")
# 1.234,5: thousands and decimals
_WITH_BOTH = re.compile(r"\s*[+-]?(?:\d+[.']\d+,\d+|\d+[,']\d+\.\d+)\s*")


@dataclass(frozen=True)
class Separators:
    """column: tab, semicolon or comma, " " for white space; decimal: point or comma, ""
    where it is ambiguous."""

    column: str
    decimal: str


def separators(heading: str, lines: Sequence[str]) -> Separators:
    """The separator in `heading`, and the decimal mark in the `lines` below it."""
    column = next((c for c in ("\t", ";", ",") if c in heading), " ")
    if column == ",":
        return Separators(",", ".")
    cells = [
        cell.strip('"')
        for line in lines
        for cell in (line.split() if column == " " else line.split(column))
    ]
    point, comma = (
        any(kind.fullmatch(cell) for cell in cells)
        for kind in (_WITH_POINT, _WITH_COMMA)
    )
    if (point and comma) or any(_WITH_BOTH.fullmatch(cell) for cell in cells):
        return Separators(column, "")
    return Separators(column, "," if comma else ".")
