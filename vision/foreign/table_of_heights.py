"""Tables of heights that somebody read off: of rebounds beside the height of each drop,
or of successive bounces by their number.

A table is told by its headings: "Drop height (m)", "Return height 1 (m)", "Bounce
number", "Rücksprunghöhe / cm". Several columns of rebounds are repeats."""

import re

import numpy as np
import pandas as pd

from benchtwin.vision.foreign.contents import Contents
from benchtwin.vision.foreign.source import (
    LENGTH,
    Rows,
    Source,
    column,
    heading_and_unit,
)
from benchtwin.vision.foreign.table_of_places import Heading
from benchtwin.vision.measurement import require

TOOL = "table of heights"
DROP, BOUNCE, REBOUND = "height_mm", "bounce", "rebound_height_mm"
_HIGH = r"(heights?|höhe|hoehe|hauteur|altura|altezza)"
_NUMBER = r"\W*(\d+|trial \d+|run \d+|versuch \d+)?"
KINDS = {
    DROP: rf"((drop|release|initial|start|fall|abwurf)\W*{_HIGH}){_NUMBER}",
    REBOUND: rf"((return|rebound|bounce|rück\w*|sprung|aufprall)\W*{_HIGH}){_NUMBER}",
    BOUNCE: r"(bounce|impact|aufprall|sprung)s?(\W*(number|no|nr|nummer|n|#))?\W*",
}


def recognises(source: Source) -> bool:
    """Whether a file is of this kind."""
    return not source.is_packed and any(map(_columns, source.heads))


def read(source: Source) -> Contents:
    """A row of readings.csv for each height; MeasurementError where one has no
    unit."""
    rows = next(rows for rows in source.sheets.values() if _columns(rows))
    columns = _columns(rows)
    values = {}
    for k, told in enumerate(columns):
        if told.holds:
            name = str(rows[0][k])
            require(
                told.holds == BOUNCE or told.unit in LENGTH,
                f"{source.path}: {name} has no unit; write it into the heading,"
                f" such as {name} (mm)",
            )
            values[k] = column(source.path, rows[1:], k, name, 2)
    table = pd.DataFrame(_stacked(columns, values)).dropna(subset=[REBOUND])
    require(not table.empty, f"{source.path}: no height of a rebound in it")
    return Contents(TOOL, readings=table)


def _stacked(columns: list[Heading], values: dict[int, np.ndarray]) -> list[dict]:
    """Rows of readings.csv: each row of the table once for each column of rebounds,
    successive bounces column by column."""
    high = [k for k, c in enumerate(columns) if c.holds == REBOUND]
    beside = {c.holds: k for k, c in enumerate(columns) if c.holds in (DROP, BOUNCE)}
    count = len(values[high[0]])
    order = [(i, k) for i in range(count) for k in high]
    if BOUNCE in beside:
        order.sort(key=lambda place: place[1])
    mm = [LENGTH.get(c.unit, 1.0) for c in columns]
    return [
        {name: mm[b] * values[b][i] for name, b in beside.items()}
        | {REBOUND: mm[k] * values[k][i]}
        for i, k in order
    ]


def _columns(rows: Rows) -> list[Heading]:
    """What the columns of a table hold; [] where it is none of heights."""
    if len(rows) < 2 or not any(isinstance(cell, float) for cell in rows[1]):
        return []
    found = [_column(cell) for cell in rows[0]]
    held = [c.holds for c in found]
    once = held.count(DROP) <= 1 and held.count(BOUNCE) <= 1
    return found if REBOUND in held and once else []


def _column(cell: object) -> Heading:
    name, unit = heading_and_unit(cell)
    holds = next((k for k, words in KINDS.items() if re.fullmatch(words, name)), "")
    return Heading(holds, unit)
