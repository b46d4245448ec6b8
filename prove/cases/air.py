"""Weight, and what air takes from a seed that moves."""

import numpy as np
from numba import njit

G_M_S2 = 9.80665
AIR_DENSITY, AIR_VISCOSITY = 1.20, 1.81e-5


@njit(cache=True)
def drag_number(re):
    """Drag number of a sphere [1]; Brown & Lawler, J. Environ. Eng. 129 (2003) 222, Re
    < 2e5."""
    re = max(re, 1e-3)
    return 24 / re * (1 + 0.15 * re**0.681) + 0.407 / (1 + 8710 / re)


@njit(cache=True)
def blown(v, air, re_per_speed):
    """What air takes from a seed at `v` [m/s], over its mass [m/s²]: (ρ A/2m) C_d(Re)
    v|v|; air: ρ A/2m [1/m], Re at 1 m/s."""
    return air * drag_number(re_per_speed * abs(v)) * v * abs(v)


def drag_scale(axes_mm: np.ndarray, density: float) -> tuple[float, float]:
    """(ρ A/2m [1/m], Re at 1 m/s) of the sphere of a seed's volume, axes (3,) full."""
    d = float(np.prod(axes_mm)) ** (1 / 3) * 1e-3
    return 0.75 * AIR_DENSITY / density / d, AIR_DENSITY * d / AIR_VISCOSITY
