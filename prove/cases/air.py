"""Air drag on a seed that slides or rolls, and what a recording states of the air."""

import numpy as np

AIR_DENSITY, AIR_VISCOSITY = 1.20, 1.81e-5
AIRY_SHARE = 0.7  # of benches that stand in air; the others say that they do not


def drag_scale(axes_mm: tuple[float, float, float], density: float) -> tuple[float, float]:
    """(ρ A/2m [1/m], Re at 1 m/s) of the sphere of a seed's volume, axes (3,) full."""
    d = float(np.prod(axes_mm)) ** (1 / 3) * 1e-3
    return 0.75 * AIR_DENSITY / density / d, AIR_DENSITY * d / AIR_VISCOSITY


def air_keys(airy: bool) -> dict[str, float]:
    """What a recording says of it."""
    return {"density_kg_m3": AIR_DENSITY if airy else 0.0}
