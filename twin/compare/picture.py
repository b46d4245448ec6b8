"""The differences as one page that opens without a network: a panel a quantity, a point
a row with its 95 % interval."""

from html import escape

import pandas as pd
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from benchtwin.twin.compare.differences import QUANTITIES

BLUE, GREY, RED = "#1f5fa8", "#9ca3af", "#b3261e"
PAGE = """\
<!doctype html><html lang="en"><meta charset="utf-8"><title>Two engines</title>
<style>body{{font:16px/1.5 system-ui,sans-serif;\
max-width:70rem;margin:2rem auto;padding:0 1rem}}
table{{border-collapse:collapse;font-size:.85rem}}\
td,th{{padding:.15rem .6rem;text-align:right;border-bottom:1px solid #ddd}}</style>
<h1>Our engine and LAMMPS on the same piles</h1><p>{verdict}.</p><p>{said}</p>{figure}
<p>LAMMPS − ours. Grey: a pair of piles of one packing; blue: their mean with its \
95 % interval; red: the interval leaves out 0.</p>
{table}</html>
"""


def page(table: pd.DataFrame, runs: pd.DataFrame, verdict: str, said: list[str]) -> str:
    """HTML with everything in it. said: sentences on how it was computed."""
    drawn = figure(table, runs).to_html(full_html=False, include_plotlyjs=True)
    shown = table.to_html(index=False, float_format=lambda v: f"{v:.3g}", border=0)
    sentences = "<br>".join(escape(line) for line in said)
    said_first = verdict[0].upper() + verdict[1:]
    return PAGE.format(
        verdict=escape(said_first), said=sentences, figure=drawn, table=shown
    )


def figure(table: pd.DataFrame, runs: pd.DataFrame) -> go.Figure:
    """Grey: every pair of piles; blue: the mean, red where its interval leaves out
    0."""
    drawn = make_subplots(
        rows=1, cols=len(QUANTITIES), subplot_titles=list(QUANTITIES.values())
    )
    for k, quantity in enumerate(QUANTITIES, start=1):
        wide = runs.pivot_table(
            index=["row", "packing"], columns="engine", values=quantity, dropna=False
        )
        pairs = wide.reindex(columns=["benchtwin", "lammps"]).dropna().reset_index()
        apart = (pairs["lammps"] - pairs["benchtwin"]).tolist()
        told = [
            f"row {r}, packing {p}"
            for r, p in zip(pairs["row"], pairs["packing"], strict=True)
        ]
        grey = go.Scatter(
            x=pairs["row"].astype(str).tolist(),
            y=apart,
            mode="markers",
            marker={"color": GREY, "size": 6},
            text=told,
        )
        drawn.add_trace(grey, row=1, col=k)
        lines = table[table["quantity"] == quantity]
        reach = ((lines["high"] - lines["low"]) / 2).fillna(0.0).tolist()
        colours = [RED if parts else BLUE for parts in lines["parts"]]
        mean = go.Scatter(
            x=lines["row"].tolist(),
            y=lines["difference"].tolist(),
            mode="markers",
            text=lines["parameters"].tolist(),
            marker={"color": colours, "size": 9},
            error_y={"type": "data", "array": reach, "color": BLUE},
        )
        drawn.add_trace(mean, row=1, col=k)
        drawn.add_hline(y=0, line_width=1, row=1, col=k)
    drawn.update_xaxes(type="category", title_text="row")
    drawn.update_yaxes(title_text="LAMMPS − ours", row=1, col=1)
    drawn.update_annotations(font_size=13)
    margin = {"l": 60, "r": 10, "t": 40, "b": 50}
    drawn.update_layout(
        template="plotly_white", showlegend=False, height=420, margin=margin
    )
    return drawn
