"""The report's figures as plain Plotly JSON: power curves, confusion, reliability,
calibration."""

import math
from itertools import pairwise

import numpy as np
from scipy.special import ndtri

from benchtwin.prove.intervals import FALSE_ALARM, GRID, binomial_interval, reliability
from benchtwin.prove.judge import Judged
from benchtwin.prove.plan import CLEAN
from benchtwin.prove.rigs import RIGS
from benchtwin.prove.score import confusion, power

BLACK, GREY, RIGHT, WRONG = "#1b1f24", "#6b7280", "#2e7d4f", "#b3261e"
COLOURS = {"all": BLACK} | {name: rig.colour for name, rig in RIGS.items()}
BINS = (0.0, 2.5, 4.0, 5.5, 7.5, 12.0, 20.0, math.inf)
# ticks of the reliability diagram, on a scale of ln p/(1 − p)
ODDS = (0.05, 0.25, 0.5, 0.75, 0.9, 0.97, 0.99, 0.997)
# SNR at these powers of a two-sided test of a known law among EFFECTS others
EFFECTS = 12
LEAST_SNR = float(ndtri(1 - FALSE_ALARM / EFFECTS / 2))
THEORY = {p: LEAST_SNR + float(ndtri(p)) for p in (0.5, 0.9)}


def power_figure(judged: list[Judged], rng: np.random.Generator) -> dict:
    """Share of alarms against SNR: fitted curves, shares by bins with their intervals,
    and the theory's two points."""
    traces = []
    for rig, colour in COLOURS.items():
        curve = power([j for j in judged if rig in ("all", j.key.rig)], rng)
        if math.isfinite(curve.snr50):
            line = {"color": colour, "width": 3 if rig == "all" else 1.5}
            traces.append(_trace(rig, GRID, curve.at(GRID), "lines", line=line))
    cross = {"symbol": "x", "color": GREY, "size": 11}
    theory = _trace("limit by theory", THEORY.values(), THEORY, marker=cross)
    share = _axis("share of alarms", range=[-0.02, 1.02], tickformat=".0%")
    snr = _axis("SNR of the concealed effect", type="log")
    layout = _layout(xaxis=snr, yaxis=share)
    return {"data": [*traces, _binned(judged), theory], "layout": layout}


def _binned(judged: list[Judged]) -> dict:
    rows = []
    concealed = [j for j in judged if j.key.kind != CLEAN and len(j.key.effects) == 1]
    for low, high in pairwise(BINS):
        some = [j for j in concealed if low <= j.key.snr < high]
        if some:
            k = sum(j.alarm for j in some)
            logs = [math.log(max(j.key.snr, 0.3)) for j in some]
            ends = binomial_interval(k, len(some))
            counted = f"{k} of {len(some)}"
            rows.append((math.exp(np.mean(logs)), k / len(some), ends, counted))
    x, y, ends, said = list(zip(*rows)) or [()] * 4
    marker = {"color": BLACK, "size": 8}
    return _trace("all, binned (95 %)", x, y, ends=ends, text=said, marker=marker)


def confusion_figure(judged: list[Judged]) -> dict:
    """Confusion matrix: concealed effects (rows), diagnoses (columns), as shares of
    each row with the counts written in."""
    rows, columns, counts = confusion(judged)
    share = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    heat = {
        "type": "heatmap",
        **{"x": columns, "y": rows, "z": [_listed(r) for r in share]},
        "text": [[str(n) if n else "" for n in row] for row in counts.tolist()],
        "texttemplate": "%{text}",
        "colorscale": [[0, "#ffffff"], [1, "#1f5fa8"]],
        "showscale": False,
        **{"zmin": 0, "zmax": 1, "xgap": 1, "ygap": 1},
    }
    xaxis = {"tickangle": -50, "automargin": True}
    layout = _layout(xaxis=xaxis, yaxis={"autorange": "reversed", "automargin": True})
    return {"data": [heat], "layout": layout | {"height": 180 + 22 * len(rows)}}


def reliability_figure(judged: list[Judged]) -> dict:
    """Share of right verdicts with 95 % bounds against their mean stated probability,
    by bins."""
    bins = reliability(judged)
    found = _trace(
        "right, 95 %",
        [_logit(b.mean_p) for b in bins],
        [_logit(b.share) for b in bins],
        "markers+text",
        ends=[tuple(map(_logit, b.bounds)) for b in bins],
        text=[f"{b.k} of {b.n}" for b in bins],
        textposition="bottom right",
        marker={"color": [RIGHT if b.holds else WRONG for b in bins], "size": 10},
    )
    ends = [_logit(0.0), _logit(1.0)]
    line = _trace("as said", ends, ends, "lines", line={"color": GREY, "dash": "dot"})
    ticks = {
        "tickvals": [_logit(p) for p in ODDS],
        "ticktext": [f"{100 * p:g} %" for p in ODDS],
        "range": ends,
    }
    axes = {"xaxis": _axis("said", **ticks), "yaxis": _axis("share right", **ticks)}
    return {"data": [line, found], "layout": _layout(**axes)}


def _logit(p: float) -> float:
    p = min(max(p, 0.02), 0.9985)
    return math.log(p / (1 - p))


def calibration_figure(judged: list[Judged]) -> dict:
    """(SNR, stated / true, interval / true) of every right name, by rig: 1 is right,
    bars are 95 % intervals."""
    traces = []
    for rig in RIGS:
        points = [point for j in judged if j.key.rig == rig for point in j.stated]
        x, y, ends = list(zip(*points)) or [()] * 3
        marker = {"color": COLOURS[rig], "size": 6}
        traces.append(_trace(rig, x, y, ends=ends, thickness=1, marker=marker))
    dotted = {"color": GREY, "dash": "dot"}
    line = _trace("", [2, 60], [1, 1], "lines", line=dotted, showlegend=False)
    axes = {"xaxis": _axis("SNR", type="log")}
    axes["yaxis"] = _axis("stated / true", range=[0, 2])
    layout = _layout(**axes)
    return {"data": [*traces, line], "layout": layout}


def _trace(
    name: str, x, y, mode: str = "markers", *, ends=None, thickness: float = 2, **look
) -> dict:
    """Points or a line; ends: (low, high) of each point's bar."""
    drawn = {"type": "scatter", "mode": mode, "name": name} | look
    if ends is not None:
        drawn["error_y"] = {
            "type": "data",
            "symmetric": False,
            "array": _listed(high - v for v, (_, high) in zip(y, ends)),
            "arrayminus": _listed(v - low for v, (low, _) in zip(y, ends)),
            "thickness": thickness,
        }
    return drawn | {"x": _listed(x), "y": _listed(y)}


def _axis(title: str, **more) -> dict:
    return {"title": {"text": title}, **more}


def _layout(**axes) -> dict:
    return {
        "margin": {"l": 60, "r": 15, "t": 10, "b": 50},
        "height": 420,
        "legend": {"orientation": "h", "y": -0.25},
        **axes,
    }


def _listed(values) -> list[float]:
    return [float(f"{v:.5g}") for v in values]
