"""Figures of the seed–steel rigs and of the posterior as plain Plotly JSON: {"data": […], "layout": {…}}."""

import numpy as np

from calibrate.procedure.joint import Joint
from calibrate.procedure.steel import SteelFit
from report import draw


def steel(fit: SteelFit) -> dict:
    """Simulated rows, both curves with their 95 % bands, the bench's mean, and where they meet."""
    rig, curve = fit.rig, fit.polynomial
    x = np.linspace(curve.low, curve.high, 101)
    y, se = curve.mean(x), np.sqrt(curve.variance(x))
    data = [
        draw.band(x, y - 1.96 * se, y + 1.96 * se, draw.BLUE),
        draw.line(x, y, draw.BLUE, f"polynomial of degree {rig.degree}"),
    ]
    if fit.monotone is not None:
        data.append(draw.line(x, fit.monotone.mean(x), draw.GREEN, "monotone curve", dash="dot"))
    error = {"array": draw.listed(fit.rows[rig.sd])} if rig.sd in fit.rows else None
    rows = {
        "type": "scatter",
        "mode": "markers",
        "x": draw.listed(fit.rows[rig.parameter]),
        "y": draw.listed(fit.rows[rig.response]),
        "marker": {"color": draw.BLUE, "size": 8},
        "name": "simulated (± sd of one run)",
    }
    data.append(rows | ({"error_y": {"type": "data", "color": draw.BLUE, **error}} if error else {}))
    reach, ends = 1.96 * fit.bench.sd, [float(min(x[0], fit.inverse.low)), float(max(x[-1], fit.inverse.high))]
    data += [
        draw.band(np.array(ends), np.full(2, fit.bench.value - reach), np.full(2, fit.bench.value + reach), draw.ORANGE),
        draw.line(ends, [fit.bench.value] * 2, draw.ORANGE, f"bench mean {fit.bench.value:.4g} {draw.unit(rig.unit)}, ± 95 %"),
        {
            "type": "scatter",
            "mode": "markers",
            "x": [fit.inverse.value],
            "y": [fit.bench.value],
            "name": "answer, 95 % interval",
            "marker": {"color": draw.RED, "size": 11, "symbol": "diamond"},
            "error_x": {
                "type": "data",
                "symmetric": False,
                "color": draw.RED,
                "thickness": 2.5,
                "array": [fit.inverse.high - fit.inverse.value],
                "arrayminus": [fit.inverse.value - fit.inverse.low],
            },
        },
    ]
    return {"data": data, "layout": draw.layout(draw.name(rig.parameter), draw.name(rig.response))}


def posterior(joint: Joint, names: list[str], marks: dict[str, float]) -> dict:
    """Every pair of parameters as a density and each alone as a histogram, the reported point as a red line or diamond."""
    draws, k = joint.posterior.draws, len(names)
    data, layout = [], {"margin": {"l": 60, "r": 10, "t": 10, "b": 50}, "showlegend": False, "height": 190 * k + 60, "bargap": 0}
    for i, row in enumerate(names):
        for j, column in enumerate(names[: i + 1]):
            n = i * k + j + 1
            axis = {"x": f"x{n}", "y": f"y{n}"}
            if i == j:
                counts, edges = np.histogram(draws[row], bins=30)
                data += [
                    {
                        "type": "bar",
                        "x": draw.listed((edges[1:] + edges[:-1]) / 2),
                        "y": draw.listed(counts),
                        "marker": {"color": draw.BLUE},
                        **_axes(axis),
                    },
                    {
                        "type": "scatter",
                        "mode": "lines",
                        "x": [marks[row]] * 2,
                        "y": [0, int(counts.max())],
                        "line": {"color": draw.RED},
                        **_axes(axis),
                    },
                ]
            else:
                counts, ex, ey = np.histogram2d(draws[column], draws[row], bins=30)
                data += [
                    {
                        "type": "heatmap",
                        "x": draw.listed((ex[1:] + ex[:-1]) / 2),
                        "y": draw.listed((ey[1:] + ey[:-1]) / 2),
                        "z": draw.rows(counts.T),
                        "colorscale": [[0, "#ffffff"], [1, draw.BLUE]],
                        "showscale": False,
                        **_axes(axis),
                    },
                    {
                        "type": "scatter",
                        "mode": "markers",
                        "x": [marks[column]],
                        "y": [marks[row]],
                        "marker": {"color": draw.RED, "symbol": "diamond", "size": 9},
                        **_axes(axis),
                    },
                ]
            gap, x_ends, y_ends = 0.03, _ends(draws[column], marks[column]), _ends(draws[row], marks[row])
            layout[f"xaxis{n}"] = {
                "domain": [j / k + gap / 2, (j + 1) / k - gap / 2],
                "anchor": f"y{n}",
                "nticks": 4,
                "range": x_ends,
                **({"title": {"text": draw.short(column), "font": {"size": 11}}} if i == k - 1 else {"showticklabels": False, "ticks": ""}),
            }
            layout[f"yaxis{n}"] = {
                "domain": [1 - (i + 1) / k + gap / 2, 1 - i / k - gap / 2],
                "anchor": f"x{n}",
                "nticks": 4,
                **({"range": y_ends} if j != i else {}),
                **({"title": {"text": draw.short(row), "font": {"size": 11}}} if j == 0 and i else {}),
                **({"showticklabels": False, "ticks": ""} if j or i == j else {}),
            }
    return {"data": data, "layout": layout}


def _ends(draws, mark: float) -> list[float]:
    """What an axis shows: all draws and the mark, with a little room."""
    low, high = min(float(draws.min()), mark), max(float(draws.max()), mark)
    room = 0.04 * (high - low)
    return [low - room, high + room]


def _axes(axis: dict) -> dict:
    return {"xaxis": axis["x"], "yaxis": axis["y"]}
