"""What acts on a flying seed, and what an impact returns: the laws of the drop, as
functions of a world (drop.py)."""

import math

import numpy as np
from numba import njit

from benchtwin.prove.cases.air import G_M_S2, drag_number

SPEED_M_S = 2.0  # where drag is stated
YIELD_M_S = 0.03
LEAST_E, MOST_E = 0.02, 0.98


@njit(cache=True)
def acceleration(place, v, spin, world):
    """Acceleration in flight (3,) [m/s²]."""
    a = np.array([0.0, 0.0, -G_M_S2])
    wind = np.array([world.draught, 0.0, world.updraught * max(place[2], 0.0)])
    through = v - wind
    speed = math.sqrt((through**2).sum())
    drag = (world.air + world.drag) * world.pull
    if drag > 0.0 and speed > 1e-9:
        ratio = (
            drag_number(world.re_per_speed * speed)
            * speed**2
            / (drag_number(world.re_per_speed * SPEED_M_S) * SPEED_M_S**2)
        )
        a -= G_M_S2 * drag * ratio / speed * through
    a += world.magnus * world.magnus_unit * np.cross(spin, v)
    a[0] += world.field * (place[0] - world.field_m)
    return a


@njit(cache=True)
def fading(speed, world):
    """What is left of restitution by laws that fall with the speed [m/s] of an impact.

    viscous: (1 + c₁ s) / (1 + b₁ s + b₂ s² + b₃ s³ + b₄ s⁴), s² = β v^⅕, Müller &
    Pöschel, Phys. Rev. E 84 (2011) 021302. yielding: beyond v_y, 1 − w + w √(6√3/5)
    √(1 − (v_y/v)²/6) (r / (r + 2√(6/5 − r²/5)))^¼, r = v_y / v, Thornton, J. Appl.
    Mech. 64 (1997) 383. zener: exp(−1.719 λ), λ = b v^⅕, Zener, Phys. Rev. 59 (1941)
    669."""
    grow = speed**0.2
    s = math.sqrt(world.viscous * grow)
    left = (1 + 0.501086 * s) / (
        1 + 0.501086 * s + 1.15345 * s**2 + 0.577977 * s**3 + 0.532178 * s**4
    )
    if world.yielding > 0.0 and speed > YIELD_M_S:
        r = YIELD_M_S / speed
        full = (
            math.sqrt(6 * math.sqrt(3) / 5)
            * math.sqrt(1 - r * r / 6)
            * (r / (r + 2 * math.sqrt(1.2 - 0.2 * r * r))) ** 0.25
        )
        left *= 1 - world.yielding + world.yielding * min(full, 1.0)
    return left * math.exp(-1.719 * world.zener * grow)


@njit(cache=True)
def restitution(speed, count, upright, world):
    """Normal restitution [1] of a central impact at `speed` [m/s], the count-th (from
    0) of this seed; upright: steepness c of the long axis.

    × (1 + η)^count, η the damage of an impact; × (1 + s (2c − 1))."""
    e = world.e * fading(speed, world) * (1 + world.impact_damage) ** count
    e *= 1 + world.oriented_restitution * (2 * upright - 1)
    return min(max(e, LEAST_E), MOST_E)
