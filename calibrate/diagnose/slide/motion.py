"""A block on a tilting plate: at rest until the pull along the plate exceeds its static friction, then

    (1 + κ) ẍ = g sin θ − c θ̇² (r₀ − x) − μ(v) (g cos θ + F/m − 2 c θ̇ ẋ) − d (ẋ + s √ẋ)²,   θ a cubic in t

x down the plate, r₀ from the hinge below (nil where it is not stated), 2 θ̇ ẋ the Coriolis acceleration that lifts a block sliding
on a plate that turns away from under it (c: its share), d and s air. The moment of onset (on a shaken plate: when the mean pull
is up to the friction) is given and says what static friction was: the travel is then smooth, and nearly linear, in every other
parameter. Runge–Kutta from that very moment, between the rows.
"""

import hashlib
import inspect
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import njit

from calibrate.diagnose.effects.slide import (
    kinetic_friction,
    partial_rolling,
    plate_vibration,
    stepped_tilt,
    stribeck,
    viscous_sliding,
)

G_M_S2 = 9.80665
STEPS = 300  # at least, from rest to the end
LAWS = (kinetic_friction, partial_rolling, plate_vibration, stepped_tilt, stribeck, viscous_sliding)
FARTHEST_M = 100.0  # a block that a fit drives on beyond this stays there: its numbers must not overflow


class Laws(NamedTuple):
    """All that acts, SI. friction: kinetic; static_excess, stribeck, ln_speed, shape, viscous: see the effects' files; press:
    normal force over mass beside the weight's; inertia κ; turning c; from_hinge r₀; air d [1/m]; stair,
    stair_phase [rad]: 0 for a plate raised without steps; worn [1/m]: friction gained per way slid (no candidate: a rival
    to those that are); shake, ln_hertz, wave_chance: of a plate that vibrates; slow_air s [√(m/s)]."""

    friction: float = 0.0
    static_excess: float = 0.0
    stribeck: float = 0.0
    ln_speed: float = 0.0
    shape: float = 0.0
    viscous: float = 0.0
    press: float = 0.0
    inertia: float = 0.0
    turning: float = 1.0
    from_hinge: float = 0.0
    air: float = 0.0
    stair: float = 0.0
    stair_phase: float = 0.0
    worn: float = 0.0
    shake: float = 0.0
    ln_hertz: float = 0.0
    wave_chance: float = 0.0
    slow_air: float = 0.0


def mark_of(sources: list[str]) -> str:
    """Of the laws from which a motion is compiled."""
    return hashlib.sha256("\0".join(sources).encode()).hexdigest()[:16]


def _kept(function: Callable) -> Callable:
    """Compiled, and kept on disk under a name that bears the mark of all laws: numba itself looks only at this file, and would
    hand out what was made from older laws."""
    function.__qualname__ = f"{function.__name__}_{mark_of([inspect.getsource(law) for law in LAWS])}"
    return njit(cache=True)(function)


def friction_at(onset: float, tilt: np.ndarray, laws: Laws) -> float:
    """Kinetic friction of a block that lets go at `onset`: pull over normal force there, less what friction loses in motion."""
    p = np.array(laws)
    pull, normal = _forces(onset, np.ascontiguousarray(tilt, float), p)
    return pull / normal - kinetic_friction.at_rest(0.0, p[1]) - stribeck.friction(0.0, p[2], p[3], p[4])


def travel(time_s: np.ndarray, onset: float, tilt: np.ndarray, laws: Laws) -> tuple[np.ndarray, np.ndarray]:
    """x (n,) [m] and v (n,) [m/s] at rising times. tilt (4,): coefficients of θ [rad] in t, lowest first."""
    time, tilt = np.ascontiguousarray(time_s, float), np.ascontiguousarray(tilt, float)
    return _travel(time, float(onset), tilt, np.array(laws))


@njit
def _tilt(t: float, tilt: np.ndarray, p: np.ndarray) -> tuple[float, float]:
    angle = tilt[0] + t * (tilt[1] + t * (tilt[2] + t * tilt[3]))
    rate = tilt[1] + t * (2 * tilt[2] + t * 3 * tilt[3])
    if p[11] > 0:
        return stepped_tilt.raised(angle, p[11], p[12]), 0.0
    return angle, rate


@_kept
def _forces(t: float, tilt: np.ndarray, p: np.ndarray) -> tuple[float, float]:
    """Pull along the plate and normal force on a block at rest, over its mass [m/s²]."""
    angle, rate = _tilt(t, tilt, p)
    pull = G_M_S2 * math.sin(angle) - p[8] * rate**2 * p[9]
    return pull, G_M_S2 * math.cos(angle) + p[6]


@njit
def air(v: float, size: float, slow: float) -> float:
    """[m/s²]; size [1/m], slow [√(m/s)]: C_d = 0.2924 (1 + 9.06/√Re)² of a sphere, Abraham 1970 (Physics of Fluids 13, 2194)."""
    return math.copysign(size * (abs(v) + slow * math.sqrt(abs(v))) ** 2, v)


@njit
def _acceleration(t: float, x: float, v: float, tilt: np.ndarray, p: np.ndarray) -> float:
    angle, rate = _tilt(t, tilt, p)
    friction = p[0] + stribeck.friction(v, p[2], p[3], p[4]) + viscous_sliding.friction(v, p[5]) + p[13] * x
    normal = G_M_S2 * math.cos(angle) + p[6] - 2 * p[8] * rate * v
    force = G_M_S2 * math.sin(angle) - p[8] * rate**2 * (p[9] - x if p[9] > 0 else 0.0) - friction * normal
    return (force - air(v, p[10], p[17])) * partial_rolling.share(p[7])


@njit
def _step(t: float, s: float, x: float, v: float, tilt: np.ndarray, p: np.ndarray) -> tuple[float, float]:
    """x and v one Runge–Kutta step of s later."""
    a1 = _acceleration(t, x, v, tilt, p)
    a2 = _acceleration(t + s / 2, x + s / 2 * v, v + s / 2 * a1, tilt, p)
    a3 = _acceleration(t + s / 2, x + s / 2 * (v + s / 2 * a1), v + s / 2 * a2, tilt, p)
    a4 = _acceleration(t + s, x + s * (v + s / 2 * a2), v + s * a3, tilt, p)
    return x + s * v + s * s / 6 * (a1 + a2 + a3), v + s / 6 * (a1 + 2 * a2 + 2 * a3 + a4)


@_kept
def _travel(time: np.ndarray, onset: float, tilt: np.ndarray, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Steps from row to row; a block in motion does not stick again, so that a fit may try too much friction."""
    place, speed = np.zeros(len(time)), np.zeros(len(time))
    longest = (time[-1] - time[0]) / STEPS
    angle, rate = _tilt(onset, tilt, p)
    growth = G_M_S2 * rate * (math.cos(angle) + p[0] * math.sin(angle))
    x, v, t = plate_vibration.crept(p[14], p[15], growth, 0.0)[0], plate_vibration.released(p[14], p[15], p[16]), onset
    for i in range(len(time)):
        if time[i] <= onset:
            place[i], speed[i] = plate_vibration.crept(p[14], p[15], growth, time[i] - onset)
            continue
        count = min(max(math.ceil((time[i] - t) / longest), 1), STEPS)  # a fit may try an onset long before the first row
        s = (time[i] - t) / count
        for k in range(count):
            x, v = _step(t + k * s, s, x, v, tilt, p)
            if not abs(x) < FARTHEST_M:
                x, v = math.copysign(FARTHEST_M, x), 0.0
        t = time[i]
        place[i], speed[i] = x, v
    return place, speed
