"""Tables as text, and names of columns in words."""

import math
import re

import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.report.draw import NAMES

HEADINGS = {
    "sum_of_squares": "sum of squares",
    "mean_square": "mean square",
    "f": "F",
    "by_formula": "K by Eqs. 9–10",
    "as_paper": "δᵢ + Σδᵢⱼ",
    "df": "df",
    "se": "std. error",
    "sd_ratio": "sd left",
    "variance_left": "variance left",
    "variance_left_after": "variance left, all picks so far",
    "box_fraction": "share of range",
}
SAID = {
    "rebound_height_mm": "rebound height",
    "slide_angle_deg": "sliding angle",
    "run_out_mm": "run-out",
    "repose_angle_deg": "angle of repose",
    "centroid_angle_deg": "centroid angle",
    "filled_mass_g": "filled mass",
    "retained_mass_g": "retained mass",
}
PERCENT = {"sd_ratio", "variance_left", "variance_left_after", "box_fraction"}
PERCENT |= {"relative_error"}


def sentence(text: str) -> str:
    """`capitalised`, with column names as words."""
    return capitalised(words(text))


def capitalised(text: str) -> str:
    """A capital first letter and a full stop."""
    text = text.strip()
    return (
        text[:1].upper()
        + text[1:]
        + ("" if text.endswith((".", "?", "。", "？")) else tr("."))
    )


def words(text: str) -> str:
    """The text with names of columns, and of no part of a longer name, in words.

    >>> words("seed_restitution at its limit")
    'restitution seed–seed at its limit'
    """
    keys = "|".join(sorted(NAMES, key=len, reverse=True))
    return re.sub(
        rf"(?<![\w.])({keys})(?!\w)",
        lambda found: SAID.get(found[1]) or NAMES[found[1]].replace(", ", " "),
        text,
    )


def cells(table: pd.DataFrame) -> dict:
    """A table as headings and rows of text."""
    columns, rows = table.columns, table.itertuples(index=False, name=None)
    return {
        "heads": [tr(HEADINGS.get(c, str(c).replace("_", " "))) for c in columns],
        "rows": [[_cell(v, c) for c, v in zip(columns, row)] for row in rows],
        "numeric": [bool(pd.api.types.is_numeric_dtype(table[c])) for c in columns],
    }


def _cell(value, column: str) -> str:
    if isinstance(value, bool) or type(value).__name__ == "bool":
        return tr("yes") if value else tr("no")
    if isinstance(value, float) or type(value).__name__.startswith("float"):
        if not math.isfinite(value):
            return "–"
        if column in PERCENT:
            return f"{100 * value:.1f} %"
        if column == "p":
            return "<0.0001" if value < 1e-4 else f"{value:.4f}"
        return f"{value:.4g}".replace("-", "−")
    return "" if value is None else words(tr(str(value)))
