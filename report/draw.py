"""Parts of figures: colours, names in words, lines, bands, axes. Plain Plotly JSON."""

from collections.abc import Iterable

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
    """A unit as it is printed."""
    return {"deg": "°"}.get(key, key)


def short(key: str) -> str:
    return name(key).split(",")[0]


def line(x: Iterable[float], y: Iterable[float], color: str, label: str, dash: str = "solid") -> dict:
    return {
        "type": "scatter",
        "mode": "lines",
        "x": listed(x),
        "y": listed(y),
        "name": label,
        "line": {"color": color, "dash": dash},
        "showlegend": bool(label),
    }


def band(x: np.ndarray, low: np.ndarray, high: np.ndarray, color: str) -> dict:
    return {
        "type": "scatter",
        "mode": "lines",
        "x": listed(np.r_[x, x[::-1]]),
        "y": listed(np.r_[low, high[::-1]]),
        "fill": "toself",
        "fillcolor": color + "22",
        "line": {"width": 0},
        "hoverinfo": "skip",
        "showlegend": False,
    }


def layout(x: str, y: str) -> dict:
    return {
        "xaxis": {"title": {"text": x}},
        "yaxis": {"title": {"text": y}},
        "margin": {"l": 60, "r": 15, "t": 10, "b": 50},
        "height": 400,
        "legend": {"orientation": "h", "y": -0.3},
    }


def listed(values: Iterable[float]) -> list[float]:
    return [float(f"{v:.6g}") for v in values]


def rows(z: np.ndarray) -> list[list[float]]:
    return [listed(row) for row in z]
