"""The report's figures as plain Plotly JSON: power curves, confusion, reliability,
calibration."""

import math
from itertools import pairwise

import numpy as np
from benchtwin.prove.intervals import GRID, Power, binomial_interval, reliability
from benchtwin.prove.judge import Judged
from benchtwin.prove.plan import CLEAN, RIG_SHARES
from benchtwin.prove.score import confusion, power

COLOURS = {
    "all": "#1b1f24",
    "drop": "#1f5fa8",
    "slide": "#d9730d",
    "roll": "#2e7d4f",
    "pile": "#b3261e",
}
BINS = (0.0, 2.5, 4.0, 5.5, 7.5, 12.0, 20.0, math.inf)
ODDS = (
    0.05,
    0.25,
    0.5,
    0.75,
    0.9,
    0.97,
    0.99,
    0.997,
)  # ticks of the reliability diagram, on a scale of ln p/(1 − p)
THEORY = {0.5: 3.53, 0.9: 4.81}


def power_figure(judged: list[Judged], rng: np.random.Generator) -> dict:
    """Share of alarms against SNR: fitted curves, shares by bins with their intervals,
    and the theory's two points."""
    traces = []
    for rig, colour in COLOURS.items():
        some = [j for j in judged if rig in ("all", j.key.rig)]
        curve: Power = power(some, rng)
        if math.isfinite(curve.snr50):
            line = {"color": colour, "width": 3 if rig == "all" else 1.5}
            traces.append(
                {
                    "type": "scatter",
                    "mode": "lines",
                    "name": rig,
                    "x": _listed(GRID),
                    "y": _listed(curve.at(GRID)),
                    "line": line,
                }
            )
    cross = {"symbol": "x", "color": "#6b7280", "size": 11}
    theory = {
        "type": "scatter",
        "mode": "markers",
        "name": "limit by theory",
        "x": list(THEORY.values()),
        "y": list(THEORY),
        "marker": cross,
    }
    share = {
        "title": {"text": "share of alarms"},
        "range": [-0.02, 1.02],
        "tickformat": ".0%",
    }
    snr = {"title": {"text": "SNR of the concealed effect"}, "type": "log"}
    layout = _layout(xaxis=snr, yaxis=share)
    return {"data": [*traces, _binned(judged), theory], "layout": layout}


def _binned(judged: list[Judged]) -> dict:
    rows = []
    concealed = [j for j in judged if j.key.kind != CLEAN and len(j.key.effects) == 1]
    for low, high in pairwise(BINS):
        some = [j for j in concealed if low <= j.key.snr < high]
        if some:
            k = sum(j.alarm for j in some)
            share, (a, b) = k / len(some), binomial_interval(k, len(some))
            middle = float(
                np.exp(np.mean([math.log(max(j.key.snr, 0.3)) for j in some]))
            )
            rows.append((middle, share, b - share, share - a, f"{k} of {len(some)}"))
    x, y, up, down, labels = list(zip(*rows)) or [()] * 5
    bars = {
        "type": "data",
        "symmetric": False,
        "array": _listed(up),
        "arrayminus": _listed(down),
    }
    return {
        "type": "scatter",
        "mode": "markers",
        "name": "all, binned (95 %)",
        "x": _listed(x),
        "y": _listed(y),
        "error_y": bars,
        "text": list(labels),
        "marker": {"color": COLOURS["all"], "size": 8},
    }


def confusion_figure(judged: list[Judged]) -> dict:
    """Confusion matrix: concealed effects (rows), diagnoses (columns), as shares of
    each row with the counts written in."""
    rows, columns, counts = confusion(judged)
    share = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    text = [[str(n) if n else "" for n in row] for row in counts.tolist()]
    heat = {
        "type": "heatmap",
        "x": columns,
        "y": rows,
        "z": [_listed(r) for r in share],
        "text": text,
        "texttemplate": "%{text}",
        "colorscale": [[0, "#ffffff"], [1, "#1f5fa8"]],
        "showscale": False,
        "zmin": 0,
        "zmax": 1,
        "xgap": 1,
        "ygap": 1,
    }
    xaxis = {"tickangle": -50, "automargin": True}
    layout = _layout(xaxis=xaxis, yaxis={"autorange": "reversed", "automargin": True})
    return {"data": [heat], "layout": layout | {"height": 180 + 22 * len(rows)}}


def reliability_figure(judged: list[Judged]) -> dict:
    """Share of right verdicts with 95 % bounds against their mean stated probability,
    by bins."""
    bins = reliability(judged)
    x, y = [_logit(b.mean_p) for b in bins], [_logit(b.share) for b in bins]
    up = [_logit(b.bounds[1]) - v for b, v in zip(bins, y)]
    down = [v - _logit(b.bounds[0]) for b, v in zip(bins, y)]
    bars = {
        "type": "data",
        "symmetric": False,
        "array": _listed(up),
        "arrayminus": _listed(down),
    }
    colours = [COLOURS["roll" if b.holds else "pile"] for b in bins]  # green and red
    found = {
        "type": "scatter",
        "mode": "markers+text",
        "name": "right, 95 %",
        "x": _listed(x),
        "y": _listed(y),
        "error_y": bars,
        "text": [f"{b.k} of {b.n}" for b in bins],
        "textposition": "bottom right",
        "marker": {"color": colours, "size": 10},
    }
    ends = [_logit(0.0), _logit(1.0)]
    line = {
        "type": "scatter",
        "mode": "lines",
        "name": "as said",
        "x": ends,
        "y": ends,
        "line": {"color": "#6b7280", "dash": "dot"},
    }
    ticks = {
        "tickvals": [_logit(p) for p in ODDS],
        "ticktext": [f"{100 * p:g} %" for p in ODDS],
        "range": ends,
    }
    axes = {
        f"{axis}axis": {"title": {"text": title}, **ticks}
        for axis, title in (("x", "said"), ("y", "share right"))
    }
    return {"data": [line, found], "layout": _layout(**axes)}


def _logit(p: float) -> float:
    p = min(max(p, 0.02), 0.9985)
    return math.log(p / (1 - p))


def calibration_figure(judged: list[Judged]) -> dict:
    """(SNR, stated / true, interval / true) of every right name, by rig: 1 is right,
    bars are 95 % intervals."""
    traces = []
    for rig in RIG_SHARES:
        points = [point for j in judged if j.key.rig == rig for point in j.stated]
        x, y = [p[0] for p in points], [p[1] for p in points]
        up, down = [p[2][1] - p[1] for p in points], [p[1] - p[2][0] for p in points]
        bars = {
            "type": "data",
            "symmetric": False,
            "array": _listed(up),
            "arrayminus": _listed(down),
            "thickness": 1,
        }
        traces.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": rig,
                "x": _listed(x),
                "y": _listed(y),
                "error_y": bars,
                "marker": {"color": COLOURS[rig], "size": 6},
            }
        )
    dotted = {"color": "#6b7280", "dash": "dot"}
    line = {
        "type": "scatter",
        "mode": "lines",
        "x": [2, 60],
        "y": [1, 1],
        "line": dotted,
        "showlegend": False,
    }
    axes = {
        "xaxis": {"title": {"text": "SNR"}, "type": "log"},
        "yaxis": {"title": {"text": "stated / true"}, "range": [0, 2]},
    }
    return {"data": [*traces, line], "layout": _layout(**axes)}


def _layout(**axes) -> dict:
    return {
        "margin": {"l": 60, "r": 15, "t": 10, "b": 50},
        "height": 420,
        "legend": {"orientation": "h", "y": -0.25},
        **axes,
    }


def _listed(values) -> list[float]:
    return [float(f"{v:.5g}") for v in values]
