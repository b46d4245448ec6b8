"""Figures of the pile as plain Plotly JSON: path, response surfaces, the sheet of solutions, residuals."""

import numpy as np

from calibrate.procedure.pile import PileFit
from calibrate.procedure.rigs import PILE_RESPONSE
from calibrate.statistics.assessment import response_grid
from report import draw

CAMERA = {"eye": {"x": -1.75, "y": -1.85, "z": 1.05}, "center": {"x": 0, "y": 0, "z": -0.2}}  # titles of the axes in view
FACE_ON = {"eye": {"x": 1.5, "y": 1.5, "z": 1.3}, "center": {"x": 0, "y": 0, "z": -0.2}}  # what lies across the box, seen flat

def path(fit: PileFit) -> dict:
    """The path of steepest ascent with the bench's angle drawn in."""
    if fit.path is None:
        raise ValueError("this pile was calibrated without a path")
    t = fit.path.errors
    runs = {
        "type": "scatter",
        "mode": "lines+markers",
        "x": draw.listed(t["group"]),
        "y": draw.listed(t[PILE_RESPONSE]),
        "name": "simulated",
        "line": {"color": draw.BLUE},
        "marker": {"size": 8},
    }
    ends = [float(t["group"].min()), float(t["group"].max())]
    bench = draw.line(ends, [fit.bench.value] * 2, draw.ORANGE, f"bench {fit.bench.value:.4g}°")
    reach = 1.96 * fit.bench.sd
    band = draw.band(np.array(ends), np.full(2, fit.bench.value - reach), np.full(2, fit.bench.value + reach), draw.ORANGE)
    layout = draw.layout("group", draw.name(PILE_RESPONSE))
    layout["xaxis"]["dtick"] = 1
    return {"data": [band, runs, bench], "layout": layout}


def surface(fit: PileFit, across: str, along: str) -> dict:
    """The response over two factors, the others at the optimum: a surface to turn, with the bench's plane in it."""
    at = {n: v for n, v in fit.optimum.point.items() if n not in (across, along)}
    grid = response_grid(fit.surface, across, along, steps=25, at=at)
    z = grid["predicted"].to_numpy().reshape(25, 25).T
    x, y = (draw.listed(sorted(grid[n].unique())) for n in (across, along))
    runs = fit.design
    data = [
        {
            "type": "surface",
            "x": x,
            "y": y,
            "z": draw.rows(z),
            "colorscale": "Viridis",
            "opacity": 0.9,
            "showscale": False,
            "contours": {"z": {"show": True, "color": "white", "width": 1}},
        },
        {
            "type": "surface",
            "x": x,
            "y": y,
            "z": draw.rows(np.full_like(z, fit.bench.value)),
            "opacity": 0.35,
            "showscale": False,
            "colorscale": [[0, draw.ORANGE], [1, draw.ORANGE]],
            "hoverinfo": "skip",
        },
        {
            "type": "scatter3d",
            "mode": "markers",
            "x": draw.listed(runs[across]),
            "y": draw.listed(runs[along]),
            "z": draw.listed(runs[PILE_RESPONSE]),
            "marker": {"size": 3, "color": "black"},
            "name": "runs",
        },
    ]
    scene = {
        "xaxis": {"title": {"text": draw.short(across)}},
        "yaxis": {"title": {"text": draw.short(along)}},
        "zaxis": {"title": {"text": "°"}},
        "camera": CAMERA,
    }
    return {
        "data": data,
        "layout": {"scene": scene, "margin": {"l": 0, "r": 0, "t": 10, "b": 0}, "showlegend": False, "height": 380},
    }


def contour(fit: PileFit, across: str, along: str) -> dict:
    """The same response as a map (what paper shows), the bench's angle as a heavy line, the optimum as a diamond."""
    at = {n: v for n, v in fit.optimum.point.items() if n not in (across, along)}
    grid = response_grid(fit.surface, across, along, steps=41, at=at)
    z = draw.rows(grid["predicted"].to_numpy().reshape(41, 41).T)
    x, y = (draw.listed(sorted(grid[n].unique())) for n in (across, along))
    line = {
        "type": "contour",
        "x": x,
        "y": y,
        "z": z,
        "showscale": False,
        "hoverinfo": "skip",
        "name": f"bench {fit.bench.value:.4g}°",
        "contours": {"type": "constraint", "operation": "=", "value": fit.bench.value},
        "line": {"color": draw.ORANGE, "width": 4},
    }
    field = {
        "type": "contour",
        "x": x,
        "y": y,
        "z": z,
        "colorscale": "Viridis",
        "contours": {"showlabels": True},
        "colorbar": {"title": {"text": "°"}, "thickness": 12},
    }
    point = {
        "type": "scatter",
        "mode": "markers",
        "x": [fit.optimum.point[across]],
        "y": [fit.optimum.point[along]],
        "marker": {"color": draw.RED, "size": 12, "symbol": "diamond", "line": {"color": "white", "width": 1}},
        "name": "reported",
    }
    layout = draw.layout(draw.short(across), draw.short(along)) | {"showlegend": False}
    return {"data": [field, line, point], "layout": layout}


def sheet(fit: PileFit) -> dict | None:
    """All points that give the bench's angle; None where there is no such set of three factors."""
    if len(fit.box.names) != 3 or not len(fit.sheet.table):
        return None
    t, (a, b, c) = fit.sheet.table, fit.box.names
    points = {
        "type": "scatter3d",
        "mode": "markers",
        "x": draw.listed(t[a]),
        "y": draw.listed(t[b]),
        "z": draw.listed(t[c]),
        "marker": {
            "size": 3,
            "color": draw.listed(t["se"]),
            "colorscale": "Viridis",
            "colorbar": {"title": {"text": "± °"}, "thickness": 12},
        },
    }
    o = fit.optimum.point
    here = {
        "type": "scatter3d",
        "mode": "markers",
        "x": [o[a]],
        "y": [o[b]],
        "z": [o[c]],
        "marker": {"size": 7, "color": draw.RED, "symbol": "diamond"},
    }
    axes = {
        f"{k}axis": {"title": {"text": draw.short(n)}, "range": [float(lo), float(hi)]}
        for k, n, lo, hi in zip("xyz", fit.box.names, fit.box.low, fit.box.high)
    }
    return {
        "data": [points, here],
        "layout": {"scene": axes | {"camera": FACE_ON}, "margin": {"l": 0, "r": 0, "t": 10, "b": 0}, "showlegend": False, "height": 420},
    }


def residuals(fit: PileFit) -> dict:
    """Studentised residuals over the predictions; beyond ±3 is worth a look."""
    t = fit.residuals
    points = {
        "type": "scatter",
        "mode": "markers",
        "x": draw.listed(t["predicted"]),
        "y": draw.listed(t["student_external"]),
        "marker": {"color": [draw.RED if o else draw.BLUE for o in t["outlier"]], "size": 8},
        "text": [f"run {r}" for r in t["run"]],
    }
    ends = [float(t["predicted"].min()), float(t["predicted"].max())]
    lines = [draw.line(ends, [v] * 2, draw.GREY, "", dash="dash") for v in (-3, 3)]
    return {"data": [points, *lines], "layout": draw.layout("predicted (°)", "studentised residual") | {"showlegend": False}}
