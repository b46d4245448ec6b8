"""Figures of the seed–steel rigs and of the posterior as plain Plotly JSON: {"data":
[…], "layout": {…}}."""

from typing import Any

import numpy as np
import pandas as pd

from benchtwin.calibrate.procedure.steel import SteelFit
from benchtwin.report import draw

GAP = 0.03  # between the panels of a posterior, of the figure's width
HIDDEN = {"showticklabels": False, "ticks": ""}


def steel(fit: SteelFit) -> dict:
    """Simulated rows, the surrogate with its 95 % band, and the bench's mean."""
    rig, box = fit.rig, fit.surrogate.box
    x = np.linspace(*box.range(rig.parameter), 101)
    y, variance = fit.surrogate.evaluate(x[:, None])
    band = 1.96 * np.sqrt(variance)
    label = "simulated (± sd of one run)"
    at = fit.rows[rig.parameter], fit.rows[rig.response]
    rows = draw.points(*at, label, color=draw.BLUE, size=8)
    if rig.sd in fit.rows:
        sds = draw.listed(fit.rows[rig.sd])
        rows["error_y"] = {"type": "data", "color": draw.BLUE, "array": sds}
    mean = f"bench mean {fit.bench.value:.4g} {draw.unit(rig.unit)}, ± 95 %"
    ends = [float(x[0]), float(x[-1])]
    data = [
        draw.band(x, y - band, y + band, draw.BLUE),
        draw.line(x, y, draw.BLUE, "surrogate, ± 95 %"),
        rows,
        *draw.level(ends, fit.bench.value, 1.96 * fit.bench.sd, mean),
    ]
    layout = draw.layout(draw.name(rig.parameter), draw.name(rig.response))
    return {"data": data, "layout": layout}


def posterior(draws: pd.DataFrame, table: pd.DataFrame) -> dict:
    """Every pair of the table's parameters as a density and each alone as a histogram.
    Red: lines at the median and the ends of the interval, a diamond at the most
    probable set."""
    names, k = list(table["parameter"]), len(table)
    told = table.set_index("parameter")
    layout = draw.layout("", "", showlegend=False, height=190 * k + 60, bargap=0)
    del layout["xaxis"], layout["yaxis"], layout["legend"]
    layout["margin"] = layout["margin"] | {"r": 10}
    data = []
    for i, row in enumerate(names):
        for j, column in enumerate(names[: i + 1]):
            n = i * k + j + 1
            if i == j:
                panel = _histogram(draws[row], told.loc[row])
            else:
                panel = _density(draws, column, row, told["most_probable_set"])
            data += [trace | {"xaxis": f"x{n}", "yaxis": f"y{n}"} for trace in panel]
            left = (_title(draw.short(row)) if i else {}) if j == 0 else HIDDEN
            below = _title(draw.short(column)) if i == k - 1 else HIDDEN
            layout[f"xaxis{n}"] = {
                "domain": [j / k + GAP / 2, (j + 1) / k - GAP / 2],
                "anchor": f"y{n}",
                "nticks": 4,
                "range": _ends(draws[column]),
                **below,
            }
            layout[f"yaxis{n}"] = {
                "domain": [1 - (i + 1) / k + GAP / 2, 1 - i / k - GAP / 2],
                "anchor": f"x{n}",
                "nticks": 4,
                **({"range": _ends(draws[row])} if j != i else HIDDEN),
                **left,
            }
    return {"data": data, "layout": layout}


def _histogram(values: pd.Series, told: pd.Series) -> list[dict]:
    counts, edges = np.histogram(values, bins=30)
    middle = draw.listed((edges[1:] + edges[:-1]) / 2)
    bars: dict[str, Any] = {"type": "bar", "marker": {"color": draw.BLUE}}
    bars |= {"x": middle, "y": draw.listed(counts)}
    lines = [("value", "solid"), ("low", "dot"), ("high", "dot")]
    top = int(counts.max())
    return [
        bars,
        *(draw.line([told[k]] * 2, [0, top], draw.RED, "", dash=d) for k, d in lines),
    ]


def _density(
    draws: pd.DataFrame, column: str, row: str, marks: pd.Series
) -> list[dict]:
    counts, *edges = np.histogram2d(draws[column], draws[row], bins=30)
    x, y = (draw.listed((e[1:] + e[:-1]) / 2) for e in edges)
    shades = [[0, "#ffffff"], [1, draw.BLUE]]
    map_ = {"type": "heatmap", "x": x, "y": y, "z": draw.rows(counts.T)}
    mark: dict[str, Any] = {"color": draw.RED, "symbol": "diamond", "size": 9}
    point = draw.points([marks[column]], [marks[row]], **mark)
    return [map_ | {"colorscale": shades, "showscale": False}, point]


def _title(text: str) -> dict:
    return {"title": {"text": text, "font": {"size": 11}}}


def _ends(draws: pd.Series) -> list[float]:
    """What an axis shows: all draws, with a little room."""
    low, high = float(draws.min()), float(draws.max())
    room = 0.04 * (high - low)
    return [low - room, high + room]
