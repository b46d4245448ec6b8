"""Figures of the seed–steel rigs and of the posterior as plain Plotly JSON: {"data":
[…], "layout": {…}}."""

from typing import Any

import numpy as np

from benchtwin.calibrate.procedure.joint import Joint
from benchtwin.calibrate.procedure.steel import SteelFit
from benchtwin.report import draw

GAP = 0.03  # between the panels of a posterior, of the figure's width
HIDDEN = {"showticklabels": False, "ticks": ""}


def steel(fit: SteelFit) -> dict:
    """Simulated rows, both curves with their 95 % bands, the bench's mean, and where
    they meet."""
    rig, curve, answer = fit.rig, fit.polynomial, fit.inverse
    x = np.linspace(curve.low, curve.high, 101)
    y, se = curve.mean(x), np.sqrt(curve.variance(x))
    data = [
        draw.band(x, y - 1.96 * se, y + 1.96 * se, draw.BLUE),
        draw.line(x, y, draw.BLUE, f"polynomial of degree {rig.degree}"),
    ]
    if fit.monotone is not None:
        y = fit.monotone.mean(x)
        data.append(draw.line(x, y, draw.GREEN, "monotone curve", dash="dot"))
    label = "simulated (± sd of one run)"
    x, y = fit.rows[rig.parameter], fit.rows[rig.response]
    rows = draw.points(x, y, label, color=draw.BLUE, size=8)
    if rig.sd in fit.rows:
        sds = draw.listed(fit.rows[rig.sd])
        rows["error_y"] = {"type": "data", "color": draw.BLUE, "array": sds}
    ends = [float(min(curve.low, answer.low)), float(max(curve.high, answer.high))]
    mean = f"bench mean {fit.bench.value:.4g} {draw.unit(rig.unit)}, ± 95 %"
    mark: dict[str, Any] = {"color": draw.RED, "size": 11, "symbol": "diamond"}
    at = ([answer.value], [fit.bench.value])
    met = draw.points(*at, "answer, 95 % interval", **mark)
    up, down = answer.high - answer.value, answer.value - answer.low
    reach = {"array": [up], "arrayminus": [down]}
    look = {"type": "data", "symmetric": False, "color": draw.RED, "thickness": 2.5}
    data += [rows, *draw.level(ends, fit.bench.value, 1.96 * fit.bench.sd, mean)]
    data.append(met | {"error_x": look | reach})
    layout = draw.layout(draw.name(rig.parameter), draw.name(rig.response))
    return {"data": data, "layout": layout}


def posterior(joint: Joint, names: list[str], marks: dict[str, float]) -> dict:
    """Every pair of parameters as a density and each alone as a histogram, the reported
    point as a red line or diamond."""
    draws, k = joint.posterior.draws, len(names)
    layout = draw.layout("", "", showlegend=False, height=190 * k + 60, bargap=0)
    del layout["xaxis"], layout["yaxis"], layout["legend"]
    layout["margin"] = layout["margin"] | {"r": 10}
    data = []
    for i, row in enumerate(names):
        for j, column in enumerate(names[: i + 1]):
            n = i * k + j + 1
            if i == j:
                panel = _histogram(draws[row], marks[row])
            else:
                panel = _density(draws, column, row, marks)
            data += [trace | {"xaxis": f"x{n}", "yaxis": f"y{n}"} for trace in panel]
            left = (_title(draw.short(row)) if i else {}) if j == 0 else HIDDEN
            below = _title(draw.short(column)) if i == k - 1 else HIDDEN
            layout[f"xaxis{n}"] = {
                "domain": [j / k + GAP / 2, (j + 1) / k - GAP / 2],
                "anchor": f"y{n}",
                "nticks": 4,
                "range": _ends(draws[column], marks[column]),
                **below,
            }
            layout[f"yaxis{n}"] = {
                "domain": [1 - (i + 1) / k + GAP / 2, 1 - i / k - GAP / 2],
                "anchor": f"x{n}",
                "nticks": 4,
                **({"range": _ends(draws[row], marks[row])} if j != i else HIDDEN),
                **left,
            }
    return {"data": data, "layout": layout}


def _histogram(values, mark: float) -> list[dict]:
    counts, edges = np.histogram(values, bins=30)
    middle = draw.listed((edges[1:] + edges[:-1]) / 2)
    bars: dict[str, Any] = {"type": "bar", "marker": {"color": draw.BLUE}}
    bars |= {"x": middle, "y": draw.listed(counts)}
    return [bars, draw.line([mark] * 2, [0, int(counts.max())], draw.RED, "")]


def _density(draws, column: str, row: str, marks: dict[str, float]) -> list[dict]:
    counts, *edges = np.histogram2d(draws[column], draws[row], bins=30)
    x, y = (draw.listed((e[1:] + e[:-1]) / 2) for e in edges)
    shades = [[0, "#ffffff"], [1, draw.BLUE]]
    map_ = {"type": "heatmap", "x": x, "y": y, "z": draw.rows(counts.T)}
    mark: dict[str, Any] = {"color": draw.RED, "symbol": "diamond", "size": 9}
    point = draw.points([marks[column]], [marks[row]], **mark)
    return [map_ | {"colorscale": shades, "showscale": False}, point]


def _title(text: str) -> dict:
    return {"title": {"text": text, "font": {"size": 11}}}


def _ends(draws, mark: float) -> list[float]:
    """What an axis shows: all draws and the mark, with a little room."""
    low, high = min(float(draws.min()), mark), max(float(draws.max()), mark)
    room = 0.04 * (high - low)
    return [low - room, high + room]
