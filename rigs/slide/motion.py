"""A block on a tilting plate: at rest until the pull exceeds static friction, then
sliding.

    (1 + κ) ẍ = g sin θ − c θ̇² (r₀ − x) − μ(v) (g cos θ + F/m − 2 c θ̇ ẋ)
                − d (ẋ + s √ẋ)²,   θ a cubic in t, or stairs on it

    μ = μ_k + R(√|v|) + P(x)

x down the plate; r₀: distance of the hinge (0 if not stated); 2 θ̇ ẋ: Coriolis
acceleration that lifts a block sliding on a rotating plate (c: its share); d, s: air;
R, P: tables of friction, over the root of speed, since much differs near 0, and over
the way.
The onset is given, and determines static friction, so that travel is smooth in every
other parameter. On a shaken plate it is when the mean pull reaches friction. A block
may have a speed at its onset (it was pushed, or moves from the first row on); where it
may rest, it stays where friction stops it.
Runge–Kutta from the onset."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.table import NOTHING, Table, look

STEPS = 300  # at least, from rest to the end
FARTHEST_M = 100.0  # bound on travel, against overflow in a fit
# initial speed of a shaken block over a/ω: mean, and sd between phases
SHARE = 0.85
SCATTER = 0.2


class Laws(NamedTuple):
    """All that acts, SI; symbols as above."""

    friction: float = 0.0  # μ_k
    static_excess: float = 0.0  # friction lost at once
    press: float = 0.0  # F/m
    inertia: float = 0.0  # κ
    turning: float = 1.0  # c
    from_hinge: float = 0.0  # r₀
    air: float = 0.0  # d [1/m]
    slow_air: float = 0.0  # s [√(m/s)]
    stair: float = 0.0  # step height [rad], 0: even
    lag: float = 0.0  # place on a step at which it lets go
    shake: float = 0.0  # a [m/s²], of a vibrating plate
    omega: float = 188.5  # [rad/s]
    wave_chance: float = 0.0  # [sd]
    climb: float = 0.05  # time to climb a step [s]


class Tables(NamedTuple):
    """R and P: friction beside that of the block."""

    root_speed: Table = NOTHING
    way: Table = NOTHING

    @property
    def at_rest(self) -> float:
        """Both where the block lets go."""
        return float(self.root_speed.values[0] + self.way.values[0])


NO_MORE = Tables()


def friction_at(
    onset: float, tilt: np.ndarray, laws: Laws, tables: Tables = NO_MORE
) -> float:
    """Kinetic friction of a block that lets go at `onset`."""
    angle, rate = tilt[0] + onset * (tilt[1] + onset * (tilt[2] + onset * tilt[3])), 0.0
    if not laws.stair:
        rate = tilt[1] + onset * (2 * tilt[2] + onset * 3 * tilt[3])
    pull = G_M_S2 * math.sin(angle) - laws.turning * rate**2 * laws.from_hinge
    return (
        pull / (G_M_S2 * math.cos(angle) + laws.press)
        - laws.static_excess
        - tables.at_rest
    )


def travel(
    time_s: np.ndarray,
    onset: float,
    tilt: np.ndarray,
    laws: Laws,
    speed: float = 0.0,
    rests: bool = False,
    tables: Tables = NO_MORE,
) -> tuple[np.ndarray, np.ndarray]:
    """x (n,) [m] and v (n,) [m/s]; tilt (4,): coefficients of θ [rad] in t, lowest
    first; speed [m/s] at the onset; rests: whether friction may stop the block."""
    time, tilt = np.ascontiguousarray(time_s, float), np.ascontiguousarray(tilt, float)
    laws = Laws(*(float(value) for value in laws))
    return _travel(time, float(onset), tilt, laws, tables, float(speed), rests)


@njit(cache=True)
def _tilt(t: float, onset: float, tilt: np.ndarray, laws: Laws) -> tuple[float, float]:
    angle = tilt[0] + t * (tilt[1] + t * (tilt[2] + t * tilt[3]))
    if laws.stair > 0:
        begun = tilt[0] + onset * (tilt[1] + onset * (tilt[2] + onset * tilt[3]))
        since = t - onset + laws.lag * laws.climb
        period = max(laws.stair / max(tilt[1], 1e-9), laws.climb)
        stairs = math.floor(since / period)
        return (
            begun
            + laws.stair
            * (stairs + min(1.0, (since - stairs * period) / laws.climb) - laws.lag),
            0.0,
        )
    return angle, tilt[1] + t * (2 * tilt[2] + t * 3 * tilt[3])


@njit(cache=True)
def _acceleration(
    t: float,
    x: float,
    v: float,
    onset: float,
    tilt: np.ndarray,
    laws: Laws,
    tables: Tables,
) -> float:
    angle, rate = _tilt(t, onset, tilt, laws)
    friction = laws.friction + look(math.sqrt(abs(v)), tables.root_speed)
    friction += look(x, tables.way)
    normal = G_M_S2 * math.cos(angle) + laws.press - 2 * laws.turning * rate * v
    force = (
        G_M_S2 * math.sin(angle)
        - laws.turning * rate**2 * (laws.from_hinge - x if laws.from_hinge > 0 else 0.0)
        - friction * normal
    )
    # C_d = 0.2924 (1 + 9.06/√Re)² of a sphere: Abraham 1970, Physics of Fluids 13, 2194
    air = math.copysign(laws.air * (abs(v) + laws.slow_air * math.sqrt(abs(v))) ** 2, v)
    return (force - air) / max(1.0 + laws.inertia, 0.05)


@njit(cache=True)
def _step(
    t: float,
    s: float,
    x: float,
    v: float,
    onset: float,
    tilt: np.ndarray,
    laws: Laws,
    tables: Tables,
) -> tuple[float, float]:
    """x and v one Runge–Kutta step of s later."""
    half, end = t + s / 2, t + s
    a1 = _acceleration(t, x, v, onset, tilt, laws, tables)
    x2, v2 = x + s / 2 * v, v + s / 2 * a1
    a2 = _acceleration(half, x2, v2, onset, tilt, laws, tables)
    x3, v3 = x + s / 2 * v2, v + s / 2 * a2
    a3 = _acceleration(half, x3, v3, onset, tilt, laws, tables)
    a4 = _acceleration(end, x + s * v3, v + s * a3, onset, tilt, laws, tables)
    return x + s * v + s * s / 6 * (a1 + a2 + a3), v + s / 6 * (
        a1 + 2 * a2 + 2 * a3 + a4
    )


@njit(cache=True)
def _crept(laws: Laws, growth: float, until: float) -> tuple[float, float]:
    """Way [m], speed [m/s] of a shaken block's slips: v = a/ω (1 − s)^2.5, s = −growth
    until/a."""
    left = (
        1.0 + growth * until / laws.shake if laws.shake > 0.0 and growth > 0.0 else 0.0
    )
    if left <= 0.0:
        return 0.0, 0.0
    speed = laws.shake / laws.omega * left**2.5
    return speed * left * laws.shake / growth / 3.5, speed


@njit(cache=True)
def _travel(
    time: np.ndarray,
    onset: float,
    tilt: np.ndarray,
    laws: Laws,
    tables: Tables,
    begun: float,
    rests: bool,
) -> tuple[np.ndarray, np.ndarray]:
    """Steps from row to row; a block that may not rest does not stick again, so a fit
    may try any friction."""
    place, speed = np.zeros(len(time)), np.zeros(len(time))
    longest = (time[-1] - time[0]) / STEPS
    angle, rate = _tilt(onset, onset, tilt, laws)
    growth = G_M_S2 * rate * (math.cos(angle) + laws.friction * math.sin(angle))
    x, t = _crept(laws, growth, 0.0)[0], onset
    v = begun + laws.shake / laws.omega * (SHARE + SCATTER * laws.wave_chance)
    stopped = False
    for i in range(len(time)):
        if time[i] <= onset:
            place[i], speed[i] = _crept(laws, growth, time[i] - onset)
            continue
        # a fit may try an onset long before the first row
        count = min(max(math.ceil((time[i] - t) / longest), 1), STEPS)
        s = (time[i] - t) / count
        for k in range(count):
            if stopped:
                break
            before, came = x, v
            x, v = _step(t + k * s, s, x, v, onset, tilt, laws, tables)
            if rests and v <= 0.0:  # v falls evenly within a step
                x = before + s * came**2 / (2 * max(came - v, 1e-12))
                v, stopped = 0.0, True
            if not abs(x) < FARTHEST_M:
                x, v = math.copysign(FARTHEST_M, x), 0.0
        t = time[i]
        place[i], speed[i] = x, v
    return place, speed
