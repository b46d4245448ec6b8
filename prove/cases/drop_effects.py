"""The drop's effects as this proof makes them: parameter → what changes in the world or
in the camera.

Signs. drag: force over weight at 2 m/s, ≥ 0. magnus: C in a = C (ρ A r / 2m) ω × v,
vectors in space. draught: wind towards +x. restitution: e(0.5 m/s) − e(2 m/s), > 0 when
it falls. film: √(2W/m). impact-damage: e × (1 + η) with every impact, η < 0 when the
seed loses. plate-tilt: the plate falls towards +x. camera effects: see camera.py.
Outside: updraught [1/s] of rising air per metre of height; field [1/s²] away from a
place beside the rig; oriented-restitution: relative, upright landing minus flat.
follows, order-drift: change of e over half the range of a condition, of the order."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from benchtwin.prove.cases.flight_laws import IMPACT, restitution
from benchtwin.prove.cases.record import Effect

MIDDLE_M_S = 1.2  # restitution laws agree with the constant one here
STRENGTH = {
    "viscoelastic-restitution": "viscous",
    "plastic-restitution": "yielding",
    "plate-compliance": "zener",
}
MOST = {"viscous": 3.0, "yielding": 1.0, "zener": 0.7}
IN_CAMERA = {
    "scale-error": "scale_error",
    "clock-error": "clock_error",
    "camera-roll": "roll_deg",
    "perspective": "perspective",
    "silhouette-wobble": "wobble_mm",
    "clock-drift": "clock_drift",
}
FOLLOWS = ("follows", "order-drift")
IN_FLIGHT = ("drag", "magnus", "draught", "updraught", "field")
EFFECTS = {
    "drag": Effect(("flight",), "1", 0.001, 0.15),
    "magnus": Effect(("flight",), "1", 0.1, 8.0, 0, either=True),
    "draught": Effect(("flight",), "m/s", 0.02, 2.5, 0, either=True),
    "restitution-falls-with-speed": Effect(("impact",), "1"),
    "viscoelastic-restitution": Effect(("impact",), "1", 0.01, 0.12),
    "plastic-restitution": Effect(("impact",), "1", 0.01, 0.12),
    "film-adhesion": Effect(("impact",), "m/s", 0.02, 0.3),
    "impact-damage": Effect(("impact",), "1", 0.005, 0.2, -1),
    "plate-tilt": Effect(("impact",), "deg", 0.03, 4.0, 0),
    "plate-compliance": Effect(("impact",), "1", 0.01, 0.12),
    "shape-conversion": Effect(("impact",), None, 0.03, 0.22),
    "scale-error": Effect(("measurement",), "1", 0.002, 0.06, 0),
    "clock-error": Effect(("measurement",), "1", 0.001, 0.06, 0),
    "camera-roll": Effect(("measurement",), "deg", 0.1, 5.0, 0),
    "perspective": Effect(("measurement",), "1/m", 0.004, 0.3, 0, either=True),
    "silhouette-wobble": Effect(("measurement",), "mm", 0.01, 0.6, 0, either=True),
    "updraught": Effect(("flight",), None, 0.02, 20.0, 0, listed=False),
    "field": Effect(("flight",), None, 0.01, 8.0, 0, listed=False),
    "oriented-restitution": Effect(("impact",), None, 0.03, 0.5, 0, listed=False),
    "clock-drift": Effect(("measurement",), None, 0.001, 0.2, 0, listed=False),
    "order-drift": Effect(("impact",), None, 0.001, 0.12, 0, listed=False),
    "follows": Effect(("impact",), None, 0.001, 0.12, 0),
}


@dataclass(frozen=True)
class Air:
    """drag: force over weight at 2 m/s of the air that is there; magnus_unit: ρ A r /
    2m; stated density [kg/m³]."""

    drag: float
    magnus_unit: float
    density: float


def flight_changes(sizes: dict[str, float], air: Air) -> dict[str, float]:
    """Entries of `law` (flight_laws.LAW) with these effects."""
    return {
        "drag": sizes.get("drag", air.drag),
        "wind": sizes.get("draught", 0.0),
        "magnus": sizes.get("magnus", 0.0) * air.magnus_unit,
        "updraught": sizes.get("updraught", 0.0),
        "field": sizes.get("field", 0.0),
    }


def impact_changes(sizes: dict[str, float], e: float) -> dict[str, float]:
    """Entries of `impact` (flight_laws.IMPACT) with these effects; e: restitution at
    MIDDLE_M_S."""
    changes = {
        "e": e,
        "yield_speed": 0.03,
        "damage": sizes.get("impact-damage", 0.0),
        "upright": sizes.get("oriented-restitution", 0.0),
    }
    for name, key in STRENGTH.items():
        if name in sizes:
            changes |= falling(key, sizes[name], e)
    return changes


def falling(key: str, difference: float, e: float) -> dict[str, float]:
    """Strength `key` of a law that falls by `difference` from 0.5 to 2 m/s and passes
    through e in the middle."""

    def entries(strength: float) -> dict[str, float]:
        plain = {"e": 1.0, "yield_speed": 0.03, key: strength}
        return plain | {"e": e / value(plain, MIDDLE_M_S)}

    def off(strength: float) -> float:
        return (
            value(entries(strength), 0.5) - value(entries(strength), 2.0) - difference
        )

    return entries(brentq(off, 0.0, MOST[key]))


def value(
    entries: dict[str, float], speed: float, count: int = 0, upright: float = 0.5
) -> float:
    """The restitution law with these entries."""
    impact = np.array([entries.get(name, 0.0) for name in IMPACT])
    return float(_unclipped(impact, speed, count, upright))


def _unclipped(impact: np.ndarray, speed: float, count: int, upright: float) -> float:
    scale = 0.9 / impact[0]  # while solving for e, a factor of 1 must not be clipped
    small = impact.copy()
    small[0] *= scale
    return restitution(speed, count, upright, small) / scale
