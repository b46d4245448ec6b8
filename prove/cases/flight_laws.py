"""What acts on a flying seed, and what an impact returns: the laws of the drop, as
functions of numbers.

`law` (11,): gravity, drag (force over weight at 2 m/s), Re per m/s, wind along x [m/s],
Magnus number K [1/1] with a = K ω × v, updraught [1/s], field [1/s²] and its centre
[m]; see LAW. `impact` (8,): see IMPACT."""

import math

import numpy as np
from numba import njit

LAW = (
    "gravity",
    "drag",
    "re_per_speed",
    "wind",
    "magnus",
    "updraught",
    "field",
    "field_centre",
)
IMPACT = ("e", "viscous", "yield_speed", "yielding", "zener", "damage", "upright")
SPEED_M_S = 2.0  # where drag is stated
LEAST_E, MOST_E = 0.02, 0.98


@njit(cache=True)
def drag_number(re):
    """Drag number of a sphere [1]; Brown & Lawler, J. Environ. Eng. 129 (2003) 222, Re
    < 2e5."""
    re = max(re, 1e-3)
    return 24 / re * (1 + 0.15 * re**0.681) + 0.407 / (1 + 8710 / re)


@njit(cache=True)
def acceleration(place, v, spin, law):
    """Acceleration in flight (3,) [m/s²]."""
    a = np.zeros(3)
    a[2] = -law[0]
    wx, wy, wz = v[0] - law[3], v[1], v[2] - law[5] * max(place[2], 0.0)
    speed = math.sqrt(wx * wx + wy * wy + wz * wz)
    if law[1] > 0.0 and speed > 1e-9:
        ratio = (
            drag_number(law[2] * speed)
            * speed**2
            / (drag_number(law[2] * SPEED_M_S) * SPEED_M_S**2)
        )
        pull = -law[0] * law[1] * ratio / speed
        a[0] += pull * wx
        a[1] += pull * wy
        a[2] += pull * wz
    if law[4] != 0.0:
        a[0] += law[4] * (spin[1] * v[2] - spin[2] * v[1])
        a[1] += law[4] * (spin[2] * v[0] - spin[0] * v[2])
        a[2] += law[4] * (spin[0] * v[1] - spin[1] * v[0])
    a[0] += law[6] * (place[0] - law[7])
    return a


@njit(cache=True)
def restitution(speed, count, upright, impact):
    """Normal restitution [1] of a central impact at `speed` [m/s], the count-th (from
    0) of this seed.

    viscous: e₀ (1 + c₁ s) / (1 + b₁ s + b₂ s² + b₃ s³ + b₄ s⁴), s² = β v^⅕, Müller &
    Pöschel, Phys. Rev. E 84 (2011) 021302. yielding: beyond v_y, e = e₀ (1 − w + w
    √(6√3/5) √(1 − (v_y/v)²/6) (r / (r + 2√(6/5 − r²/5)))^¼), r = v_y / v, Thornton, J.
    Appl. Mech. 64 (1997) 383. zener: e₀ exp(−1.719 λ), λ = b v^⅕, Zener, Phys. Rev. 59
    (1941) 669. damage: × (1 + η)^count. upright: × (1 + s (2c − 1)), c the steepness of
    the long axis."""
    e = impact[0]
    grow = speed**0.2
    s = math.sqrt(impact[1] * grow)
    e *= (1 + 0.501086 * s) / (
        1 + 0.501086 * s + 1.15345 * s**2 + 0.577977 * s**3 + 0.532178 * s**4
    )
    if impact[3] > 0.0 and speed > impact[2]:
        r = impact[2] / speed
        full = (
            math.sqrt(6 * math.sqrt(3) / 5)
            * math.sqrt(1 - r * r / 6)
            * (r / (r + 2 * math.sqrt(1.2 - 0.2 * r * r))) ** 0.25
        )
        e *= 1 - impact[3] + impact[3] * min(full, 1.0)
    e *= math.exp(-1.719 * impact[4] * grow)
    e *= (1 + impact[5]) ** count
    e *= 1 + impact[6] * (2 * upright - 1)
    return min(max(e, LEAST_E), MOST_E)


def law_array(**values: float | np.floating) -> np.ndarray:
    """`law` with the named entries, the others zero."""
    return np.array([float(values.get(name, 0.0)) for name in LAW])


def impact_array(**values: float | np.floating) -> np.ndarray:
    """Numbers of the impact's laws in the order of IMPACT, 0 for those that are not
    given."""
    return np.array([float(values.get(name, 0.0)) for name in IMPACT])
