"""Compares printed values with recomputed ones: does a published number follow from its
table?"""

import re

import pandas as pd

# of the last printed digit: 0.125 printed as 0.12 or as 0.13 is the same rounding
SLACK = 0.02


def follows(printed: str, recomputed: float) -> bool:
    """Whether `recomputed` rounds to what is printed.

    printed: as in print, so that its digits show: "14.40", "4.45E-003", "-10.23",
    "<0.01", ">0.05". Raises ValueError where the text is no number.

    >>> follows("0.07", 0.0656), follows("1", 7), follows("<0.01", 0.0294)
    (True, False, False)
    """
    text = printed.strip().replace("−", "-").replace(" ", "")
    bound = text[:1] if text[:1] in "<>" else ""
    match = re.fullmatch(r"([-+]?\d*\.?(\d*))(?:[eE]([-+]?\d+))?", text[len(bound) :])
    if not match or not re.search(r"\d", match[1]):
        raise ValueError(f"printed value {printed!r} is not a number")
    value = float(text[len(bound) :])
    unit = 10.0 ** (int(match[3] or 0) - len(match[2]))
    if bound:
        return recomputed < value if bound == "<" else recomputed > value
    return abs(recomputed - value) <= (0.5 + SLACK) * unit


def compare(printed: dict[str, str], recomputed: dict[str, float]) -> pd.DataFrame:
    """One row a printed value: item, printed, recomputed, follows. Raises ValueError
    for an item that was not recomputed."""
    unknown = [item for item in printed if item not in recomputed]
    if unknown:
        raise ValueError(
            f"printed values that nothing was recomputed for: {', '.join(unknown)}"
        )
    rows = [
        (item, text, float(recomputed[item]), follows(text, recomputed[item]))
        for item, text in printed.items()
    ]
    return pd.DataFrame(rows, columns=["item", "printed", "recomputed", "follows"])


def flatten(table: pd.DataFrame, key: str) -> dict[str, float]:
    """A recomputed table as {"<row> <column>": value}, the row named by column `key`:
    what `compare` takes."""
    return {
        f"{row[key]} {c}": row[c]
        for _, row in table.iterrows()
        for c in table.columns
        if c != key
    }
