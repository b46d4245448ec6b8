"""Figures of a publication's steps as plain Plotly JSON: path, response surfaces,
residuals."""

from typing import Any

import numpy as np

from benchtwin.calibrate.procedure.rigs import PILE
from benchtwin.calibrate.procedure.surface import SurfaceFit
from benchtwin.calibrate.statistics.surface import response_grid
from benchtwin.report import draw

STEPS = 41  # of a map, along either axis


def path(fit: SurfaceFit) -> dict:
    """The path of steepest ascent with the bench's angle drawn in."""
    if fit.path is None:
        raise ValueError("this pile was calibrated without a path")
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
    layout = draw.layout("predicted (°)", "studentised residual", showlegend=False)
    return {"data": [points, *lines], "layout": layout}
