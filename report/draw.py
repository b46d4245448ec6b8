"""Parts of figures: colours, names in words, lines, bands, axes. Plain Plotly JSON."""

from collections.abc import Iterable
from typing import Any

import numpy as np

BLUE, ORANGE, GREY, GREEN, RED = "#1f5fa8", "#d9730d", "#6b7280", "#2e7d4f", "#b3261e"
NAMES = {
    "restitution": "restitution, seed–steel",
    "static_friction": "static friction, seed–steel",
    "rolling_friction": "rolling friction, seed–steel",
    "seed_restitution": "restitution, seed–seed",
    "seed_static_friction": "static friction, seed–seed",
    "seed_rolling_friction": "rolling friction, seed–seed",
    "rebound_height_mm": "rebound height (mm)",
    "slide_angle_deg": "sliding angle (°)",
    "run_out_mm": "run-out (mm)",
    "repose_angle_deg": "angle of repose (°)",
    "centroid_angle_deg": "centroid angle (°)",
    "filled_mass_g": "mass filled in (g)",
    "retained_mass_g": "mass left (g)",
}


def name(key: str) -> str:
    """A column's name in words."""
    return NAMES.get(key, key.replace("_", " "))


def unit(key: str) -> str:
    """A unit as it is printed; none for a plain number."""
    return {"1": "", "deg": "°"}.get(key, key)


def short(key: str) -> str:
    """A parameter's name without the pair of materials."""
    return name(key).split(",")[0]


def line(
    x: Iterable[float], y: Iterable[float], color: str, label: str, dash: str = "solid"
) -> dict:
    """A line for plotly."""
    look = {"line": {"color": color, "dash": dash}, "showlegend": bool(label)}
    drawn = {"type": "scatter", "mode": "lines", "name": label} | look
    return drawn | {"x": listed(x), "y": listed(y)}


def points(
    x: Iterable[float], y: Iterable[float], label: str = "", **marker: Any
) -> dict:
    """Points for plotly; marker: color, size, symbol."""
    drawn = {"type": "scatter", "mode": "markers", "name": label, "marker": marker}
    return drawn | {"x": listed(x), "y": listed(y)}


def band(x: np.ndarray, low: np.ndarray, high: np.ndarray, color: str) -> dict:
    """An area between two curves for plotly, in a shade of `color`."""
    edge = line(np.r_[x, x[::-1]], np.r_[low, high[::-1]], color, "")
    look = {"fill": "toself", "fillcolor": color + "22", "line": {"width": 0}}
    return edge | look | {"hoverinfo": "skip"}


def level(ends: list[float], mean: float, reach: float, label: str) -> list[dict]:
    """A bench's mean and its interval, mean ± reach, over the whole width of a
    figure."""
    low, high = np.full(2, mean - reach), np.full(2, mean + reach)
    area = band(np.array(ends), low, high, ORANGE)
    return [area, line(ends, [mean] * 2, ORANGE, label)]


def layout(x: str, y: str, **more: Any) -> dict:
    """A figure's layout for plotly, with the axes' titles."""
    return {
        "xaxis": {"title": {"text": x}},
        "yaxis": {"title": {"text": y}},
        "margin": {"l": 60, "r": 15, "t": 10, "b": 50},
        "height": 400,
        "legend": {"orientation": "h", "y": -0.3},
    } | more


def listed(values: Iterable[float]) -> list[float]:
    """Six digits of each value, as JSON takes them."""
    return [float(f"{v:.6g}") for v in values]


def rows(z: np.ndarray) -> list[list[float]]:
    """Six digits of each value of a table (n, m), as JSON takes them."""
    return [listed(row) for row in z]
