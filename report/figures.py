"""Figures of a calibration as plain Plotly JSON, {"data": […], "layout": {…}}:
seed–steel rigs, the posterior, the steps of a publication, recording beside twin."""

import base64
from typing import Any

import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.calibrate.procedure.rigs import PILE
from benchtwin.calibrate.procedure.steel import SteelFit
from benchtwin.calibrate.procedure.surface import SurfaceFit
from benchtwin.calibrate.statistics.surface import response_grid
from benchtwin.report import draw
from benchtwin.report.residuals import binned
from benchtwin.twin.pair import Pair

GAP = 0.03  # between the panels of a posterior, of the figure's width
HIDDEN = {"showticklabels": False, "ticks": ""}


def steel(fit: SteelFit) -> dict:
    """Simulated rows, the surrogate with its 95 % band, and the bench's mean."""
    rig, box = fit.rig, fit.surrogate.box
    x = np.linspace(*box.range(rig.parameter), 101)
    y, variance = fit.surrogate.evaluate(x[:, None])
    band = 1.96 * np.sqrt(variance)
    label = tr("simulated (± sd of one run)")
    at = fit.rows[rig.parameter], fit.rows[rig.response]
    rows = draw.points(*at, label, color=draw.BLUE, size=8)
    if rig.sd in fit.rows:
        sds = draw.listed(fit.rows[rig.sd])
        rows["error_y"] = {"type": "data", "color": draw.BLUE, "array": sds}
    mean = tr("bench mean {:.4g} {}, ± 95 %", fit.bench.value, draw.unit(rig.unit))
    ends = [float(x[0]), float(x[-1])]
    data = [
        draw.band(x, y - band, y + band, draw.BLUE),
        draw.line(x, y, draw.BLUE, tr("surrogate, ± 95 %")),
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


STEPS = 41  # of a map, along either axis


def path(fit: SurfaceFit) -> dict:
    """The path of steepest ascent with the bench's angle drawn in."""
    if fit.path is None:
        raise ValueError(tr("this pile was calibrated without a path"))
    t = fit.path.errors
    runs = draw.line(t["group"], t[PILE.response], draw.BLUE, "simulated")
    runs |= {"mode": "lines+markers", "marker": {"size": 8}}
    ends = [float(t["group"].min()), float(t["group"].max())]
    label = f"bench {fit.bench.value:.4g}°"
    band, bench = draw.level(ends, fit.bench.value, 1.96 * fit.bench.sd, label)
    layout = draw.layout("group", draw.name(PILE.response))
    layout["xaxis"]["dtick"] = 1
    return {"data": [band, runs, bench], "layout": layout}


def _grid(fit: SurfaceFit, across: str, along: str) -> tuple[dict, np.ndarray]:
    """The axes of two factors as plotly takes them, and the response (STEPS, STEPS),
    the other factors at the optimum."""
    at = {n: v for n, v in fit.optimum.point.items() if n not in (across, along)}
    grid = response_grid(fit.surface, across, along, steps=STEPS, at=at)
    named = {"x": across, "y": along}
    axes = {k: draw.listed(sorted(grid[n].unique())) for k, n in named.items()}
    return axes, grid["predicted"].to_numpy().reshape(STEPS, STEPS).T


def contour(fit: SurfaceFit, across: str, along: str) -> dict:
    """The response over two factors as a map, the runs as dots, the bench's angle as a
    heavy line, the optimum as a diamond."""
    axes, z = _grid(fit, across, along)
    drawn = {"type": "contour", "z": draw.rows(z)} | axes
    bar = {"title": {"text": "°"}, "thickness": 12}
    field = {"colorscale": "Viridis", "contours": {"showlabels": True}, "colorbar": bar}
    bench = {"type": "constraint", "operation": "=", "value": fit.bench.value}
    named = f"bench {fit.bench.value:.4g}°"
    line = {"showscale": False, "hoverinfo": "skip", "name": named}
    line |= {"contours": bench, "line": {"color": draw.ORANGE, "width": 4}}
    look: dict[str, Any] = {"color": draw.RED, "size": 12, "symbol": "diamond"}
    look["line"] = {"color": "white", "width": 1}
    x, y = ([fit.optimum.point[n]] for n in (across, along))
    point = draw.points(x, y, "optimum", **look)
    at = fit.design[across], fit.design[along]
    runs = draw.points(*at, "runs", size=4, color="black")
    layout = draw.layout(draw.short(across), draw.short(along), showlegend=False)
    return {"data": [drawn | field, drawn | line, runs, point], "layout": layout}


def residuals(fit: SurfaceFit) -> dict:
    """Studentised residuals over the predictions; beyond ±3 is worth a look."""
    t = fit.residuals
    colors = [draw.RED if o else draw.BLUE for o in t["outlier"]]
    points = draw.points(t["predicted"], t["student_external"], color=colors, size=8)
    points["text"] = [f"run {r}" for r in t["run"]]
    ends = [float(t["predicted"].min()), float(t["predicted"].max())]
    lines = [draw.line(ends, [v] * 2, draw.GREY, "", dash="dash") for v in (-3, 3)]
    layout = draw.layout("predicted (°)", tr("studentised residual"), showlegend=False)
    return {"data": [points, *lines], "layout": layout}


def panels(pairs: list[Pair]) -> list[dict]:
    """What the page shows of each: rig, recording, titles and pictures as data,
    figure's key."""
    return [
        {
            "rig": p.rig,
            "recording": p.recording,
            "key": f"pair-{p.rig}",
            "pictures": [
                (title, base64.b64encode(png).decode())
                for title, png in zip(
                    (f"recorded: {p.recording}", tr("the twin")),
                    p.pictures,
                    strict=True,
                )
                if png
            ],
        }
        for p in pairs
    ]


def side_by_side(p: Pair) -> dict:
    """Both curves above, twin minus recording below. Plain Plotly JSON."""
    x, bench = binned(p.x, p.bench)
    _, twin = binned(p.x, p.twin)
    _, off = binned(p.x, p.twin - p.bench)
    data = [
        draw.line(x, bench, "#1b1f24", "recorded"),
        draw.line(x, twin, draw.ORANGE, "twin", dash="dash"),
        draw.line(x, off, draw.BLUE, "") | {"yaxis": "y2"},
    ]
    layout = draw.layout(tr(p.x_name), tr(p.y_name)) | {"height": 460}
    layout["yaxis"] |= {"domain": [0.42, 1.0]}
    layout["yaxis2"] = {"title": {"text": "difference"}, "domain": [0.0, 0.3]}
    layout["xaxis"] |= {"anchor": "y2"}
    return {"data": data, "layout": layout}
