"""How results show themselves in a notebook: small tables, and intervals as figures."""

import math
from collections.abc import Iterable, Sequence
from html import escape

import pandas as pd
from plotly.graph_objects import Figure
from plotly.subplots import make_subplots

from benchtwin.report.draw import BLUE, ORANGE, RED

MOST_ROWS = 60  # of a table in a notebook; the tables themselves hold all
COLOURS = {"good": BLUE, "doubtful": ORANGE, "failed": RED}


def html(title: str, table: pd.DataFrame, notes: Iterable[str] = ()) -> str:
    """A heading, a table and lines under it; everything is escaped, since names and
    reasons come from files."""
    rows = table.head(MOST_ROWS).to_html(index=False, border=0, na_rep="–")
    lines = list(notes)
    if len(table) > MOST_ROWS:
        lines = [f"and {len(table) - MOST_ROWS} rows more", *lines]
    under = "".join(f"<p>{escape(line)}</p>" for line in lines)
    return f"<p><b>{escape(title)}</b></p>{rows}{under}"


def panels(
    titles: Sequence[str], across: int = 2
) -> tuple[Figure, list[dict[str, int]]]:
    """A figure with a panel for each title, and where each stands for plotly."""
    columns = max(1, min(across, len(titles)))
    rows = max(1, math.ceil(len(titles) / columns))
    figure = make_subplots(
        rows, columns, subplot_titles=[escape(title) for title in titles]
    )
    figure.update_layout(
        height=90 + 230 * rows,
        margin={"l": 60, "r": 15, "t": 40, "b": 40},
        showlegend=False,
        template="plotly_white",
    )
    places = [
        {"row": 1 + k // columns, "col": 1 + k % columns} for k in range(len(titles))
    ]
    return figure, places
