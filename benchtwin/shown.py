"""How results show themselves in a notebook and as a page: small tables, and intervals
as figures."""

import math
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from typing import Protocol

import pandas as pd
from plotly.graph_objects import Figure
from plotly.subplots import make_subplots
from rich.table import Table

from benchtwin.bench.language import tr
from benchtwin.bench.terminal import Terminal
from benchtwin.bench.whole_file import write_whole
from benchtwin.report.draw import BLUE, ORANGE, RED

MOST_ROWS = 60  # of a table in a notebook; the tables themselves hold all
PAGE = """\
<!doctype html><html lang="en"><meta charset="utf-8"><title>benchtwin</title>
<style>body{{font:16px/1.5 system-ui,sans-serif;max-width:70rem;margin:2rem auto}}
body{{padding:0 1rem}}table{{border-collapse:collapse;font-size:.85rem}}
td,th{{padding:.15rem .6rem;text-align:left;border-bottom:1px solid #ddd}}</style>
{figure}{table}</html>
"""
COLOURS = {"good": BLUE, "doubtful": ORANGE, "failed": RED}


def html(title: str, table: pd.DataFrame, notes: Iterable[str] = ()) -> str:
    """A heading, a table and lines under it; everything is escaped, since names and
    reasons come from files."""
    rows = table.head(MOST_ROWS).to_html(index=False, border=0, na_rep="–")
    lines = list(notes)
    if len(table) > MOST_ROWS:
        lines = [tr("and {} rows more", len(table) - MOST_ROWS), *lines]
    under = "".join(f"<p>{escape(line)}</p>" for line in lines)
    return f"<p><b>{escape(title)}</b></p>{rows}{under}"


def in_terminal(table: pd.DataFrame, console: Terminal) -> None:
    """Print a table of texts."""
    shown = Table(box=None, pad_edge=False)
    for heading in table.columns:
        shown.add_column(tr(str(heading)))
    for row in table.astype(str).to_numpy():
        shown.add_row(*row)
    console.print(shown)


class Shown(Protocol):
    """What shows itself as a figure and as a table."""

    def plot(self) -> Figure:
        """The figure."""

    def _repr_html_(self) -> str: ...


def write_page(found: Shown, file: Path) -> None:
    """Write figure and table as one page that opens without a network."""
    look = {"displayModeBar": False}
    figure = found.plot().to_html(look, full_html=False, include_plotlyjs=True)
    write_whole(file, PAGE.format(figure=figure, table=found._repr_html_()))


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
