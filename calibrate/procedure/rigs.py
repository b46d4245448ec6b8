"""The four rigs of the procedure: which parameter each is read for, and how that
reading follows from it."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Rig:
    """A seed–steel rig.

    response: column of its reading; degree: of the polynomial that the paper fits (its
    `equation`); limits: physical ends of the parameter; step: smallest half width that
    a range of it is simulated over."""

    name: str
    parameter: str
    response: str
    unit: str
    degree: int
    equation: str
    limits: tuple[float, float]
    step: float

    @property
    def sd(self) -> str:
        """Column with the standard deviation of single runs."""
        return f"sd_{self.unit}"


STEEL = {
    "drop": Rig(
        "drop", "restitution", "rebound_height_mm", "mm", 2, "Eq. 5", (0.05, 1.0), 0.1
    ),
    "slide": Rig(
        "slide",
        "static_friction",
        "slide_angle_deg",
        "deg",
        1,
        "Eq. 6",
        (0.02, 3.0),
        0.1,
    ),
    "roll": Rig(
        "roll", "rolling_friction", "run_out_mm", "mm", 2, "Eq. 7", (0.0005, 1.0), 0.004
    ),
}
PILE_RESPONSE = "repose_angle_deg"
SEED_FACTORS = ("seed_restitution", "seed_static_friction", "seed_rolling_friction")
SEED_LIMITS = {
    "seed_restitution": (0.05, 0.95),
    "seed_static_friction": (0.02, 1.5),
    "seed_rolling_friction": (0.0005, 0.5),
}
PARAMETERS = (*(rig.parameter for rig in STEEL.values()), *SEED_FACTORS)


def direct(rig: str, reading: float, description: dict) -> float | None:
    """The parameter straight from a reading, without simulation; None where the rig's
    own lengths are not stated.

    Eq. 1: e = √(H₂/H₁); Eq. 2: μ = tan α; Eq. 3: μ_r = S sin β/(S cos β + L). reading
    in mm or degrees.

    >>> lengths = {"incline_deg": 15.0, "incline_length_mm": 10.0}
    >>> round(direct("roll", 214.0, {"roll": lengths}), 5)
    0.01157
    """
    if rig == "drop":
        height = description.get("drop", {}).get("height_mm")
        return float(np.sqrt(reading / height)) if height else None
    if rig == "slide":
        return float(np.tan(np.radians(reading)))
    section = description.get("roll", {})
    if "incline_deg" not in section or "incline_length_mm" not in section:
        return None
    beta, length = np.radians(section["incline_deg"]), section["incline_length_mm"]
    return float(length * np.sin(beta) / (length * np.cos(beta) + reading))
