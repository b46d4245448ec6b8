"""Figures of a diagnosis: residuals of baseline and model for every recording, and the
recordings. Plain Plotly JSON."""

from html import escape

import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.diagnose.words import AXES
from benchtwin.infer.finding import Curve
from benchtwin.infer.follow import Follow
from benchtwin.report import draw

BINS = 150  # points a curve: noise averages out, a page stays small
TWINS = {
    "recorded": {"color": "#1b1f24", "size": 9, "symbol": "circle-open"},
    "old twin": {"color": draw.ORANGE, "size": 6},
    "new twin": {"color": draw.BLUE, "size": 6},
}
FEW = 12  # points a curve: dots, not a line
SHADES = (
    *("#1f5fa8", "#5b8ec9", "#2e7d4f", "#7fae93"),
    *("#8a4b00", "#c48f4d", "#6b3fa0", "#a58bc4"),
)


def before_and_after(curves: list[Curve], model: str) -> dict:
    """Two panels above each other on one scale: residuals of the baseline, and with
    `model` ("" where there is none)."""
    panels = [(tr("the twin as it was"), "left_by_baseline", "y")]
    if model:
        panels.append((tr("with {}", model), "left_by_model", "y2"))
    data, reach = [], 0.0
    for _, which, axis in panels:
        for k, curve in enumerate(curves):
            x, y = binned(curve.along, getattr(curve, which))
            reach = max(reach, float(np.nanmax(np.abs(y))) if len(y) else 0.0)
            drawn = _line(x, y, SHADES[k % len(SHADES)], curve.recording)
            data.append(drawn | {"yaxis": axis})
    titles = [title for title, *_ in panels]
    return {"data": data, "layout": _layout(curves[0], titles, 1.08 * reach or 1.0)}


def recorded(curves: list[Curve]) -> dict:
    """What was seen, one line a recording."""
    data = [
        _line(*binned(c.along, c.seen), SHADES[k % len(SHADES)], c.recording)
        for k, c in enumerate(curves)
    ]
    y = f"{curves[0].quantity} ({curves[0].unit})"
    layout = draw.layout(_axis(curves[0]), y) | {"showlegend": False}
    return {"data": data, "layout": layout}


def followed(follow: Follow, level: float) -> dict:
    """Each recording's own value over the condition that it follows, with its sd, and
    the curve; level: mean value."""
    names = list(follow.at)
    x, seen = [follow.at[n] for n in names], [follow.seen[n] for n in names]
    own = draw.points(x, [level + value for value, _ in seen], color=draw.BLUE, size=7)
    errors = {"type": "data", "array": draw.listed(sd for _, sd in seen)}
    at = np.array([p.at for p in follow.curve])
    value, low, high = (
        np.array([level + getattr(p.size, part) for p in follow.curve])
        for part in ("value", "low95", "high95")
    )
    data = [
        draw.band(at, low, high, draw.ORANGE),
        draw.line(at, value, draw.ORANGE, ""),
        own | {"hovertext": names, "error_y": errors, "showlegend": False},
    ]
    layout = draw.layout(follow.condition, draw.name(follow.parameter).split(",")[0])
    layout["height"] = 280
    if follow.levels:
        places = list(range(len(follow.levels)))
        layout["xaxis"] |= {"tickvals": places, "ticktext": list(follow.levels)}
    return {"data": data, "layout": layout}


def points(figure: dict) -> dict:
    """Recorded, old and new twin as points over one axis
    (`diagnose.rerun.Again.figure`)."""
    data = []
    for name, (x, y) in figure["points"].items():
        look = TWINS.get(name, {"color": draw.GREEN, "size": 6})
        drawn = draw.line(x, y, draw.GREY, name)
        data.append(drawn | {"mode": "markers", "marker": look})
    data.sort(key=lambda trace: trace["name"] == "recorded")  # open circles on top
    return {"data": data, "layout": draw.layout(figure["x"], figure["y"])}


def binned(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Means in BINS equal bins of x, empty bins left out; x itself where there are
    fewer points."""
    if len(x) <= BINS:
        order = np.argsort(x, kind="stable")
        return x[order], y[order]
    share = (x - x.min()) / max(np.ptp(x), 1e-300)
    which = np.minimum((share * BINS).astype(int), BINS - 1)
    table = pd.DataFrame({"x": x, "y": y}).groupby(which).mean()
    return table["x"].to_numpy(), table["y"].to_numpy()


def _line(x, y, color: str, name: str) -> dict:
    look = {"hovertext": name, "opacity": 0.8, "line": {"color": color, "width": 1.5}}
    drawn = draw.line(x, y, color, "") | look
    if len(x) <= FEW:
        return drawn | {"mode": "markers", "marker": {"color": color, "size": 8}}
    return drawn


def _axis(curve: Curve) -> str:
    name, unit = AXES.get(curve.axis, (curve.axis, ""))
    name = tr(name)
    return f"{name} ({unit})" if unit else name


def _layout(curve: Curve, titles: list[str], reach: float) -> dict:
    unit, span = tr("left ({})", curve.unit), [-reach, reach]
    look = {"showlegend": False, "height": 260 + 200 * (len(titles) - 1)}
    layout = draw.layout(_axis(curve), unit) | look
    layout["yaxis"] |= {"range": span}
    layout["margin"] = {"l": 60, "r": 15, "t": 30, "b": 50}
    tops = [1.0]
    if len(titles) == 2:
        layout["yaxis"] |= {"domain": [0.56, 1.0]}
        below = {"range": span, "domain": [0.0, 0.44]}
        layout["yaxis2"] = {"title": {"text": unit}} | below
        layout["xaxis"] |= {"anchor": "y2"}
        tops = [1.0, 0.44]
    title = {"x": 0, "xref": "paper", "yref": "paper", "showarrow": False}
    title |= {"xanchor": "left", "yanchor": "bottom"}
    pairs = zip(titles, tops, strict=True)
    layout["annotations"] = [  # plotly takes some tags in titles
        title | {"text": f"<b>{escape(text, quote=False)}</b>", "y": top}
        for text, top in pairs
    ]
    return layout
