"""A rolling seed: release, incline, corner, level, until it stops or rocks.

    dv/dt = F [ drive − n s (μ + R(|v|)) − n h'(x) + P(x) + Q(t) ] + o v² h'(x),    F = g / (1 +
    I/(m r²))

drive: sin β on the incline, that of the slope on the level; n: cos β and 1; s: sign of the motion;
R: speed-dependent resistance over weight; h: height of the centre over its path; P, Q: pushes over
weight; o: an oval seed turns more slowly where its centre is high (v = ω h), and its translation
gains what its rotation loses. Runge–Kutta of fourth order between events, each met exactly. R, P, Q
are tables, linear between points.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numba
import numpy as np

LONGEST_STEP_S = 12e-3
MOST_STEPS = 5000  # where a fit asks for a release long ago
MOST_STOPS = 500  # after which a rocking seed counts as at rest
SHORTEST_STEP_S = 1e-4
LONGEST_TURN = 0.35  # of the ripple's argument, a step
BISECTIONS = 50


@dataclass(frozen=True, eq=False)
class Table:
    """Values (m,) at low, low + step, …; constant beyond both ends."""

    low: float
    step: float
    values: np.ndarray


NOTHING = Table(0.0, 1.0, np.zeros(1))


@dataclass(frozen=True)
class Way:
    """Parameters of a run, SI.

    t0, x0: release; corner: place where the incline ends; f: F above; sin, cos: of the incline; mu.
    level: drive there; gain: acceleration on the incline over that of rolling.
    keep: share of the speed kept at the corner; slip_loss [m/s]: lost within slip_time [s] behind
    it.
    ripple (c, s) [m]: h = ½ (c cos φ + s sin φ), φ = turn x + phase; oval [1/m]: o.
    """

    t0: float
    x0: float
    corner: float
    f: float
    sin: float
    cos: float
    mu: float
    level: float = 0.0
    gain: float = 1.0
    keep: float = 1.0
    slip_loss: float = 0.0
    slip_time: float = 1.0
    ripple: tuple[float, float] = (0.0, 0.0)
    turn: float = 0.0
    phase: float = 0.0
    oval: float = 0.0


class _Numbers(NamedTuple):
    """Numbers of a `Way` and of its tables, as the compiled functions take them."""

    t0: float
    x0: float
    corner: float
    f: float
    sin: float
    cos: float
    mu: float
    level: float
    gain: float
    keep: float
    slip_loss: float
    slip_time: float
    ripple_cos: float
    ripple_sin: float
    turn: float
    phase: float
    resistance_low: float
    resistance_step: float
    place_low: float
    place_step: float
    time_low: float
    time_step: float
    longest_step: float
    steps_per_way: float
    oval: float


def travel(
    times: np.ndarray, way: Way, resistance: Table = NOTHING, place: Table = NOTHING, time: Table = NOTHING
) -> tuple[np.ndarray, np.ndarray]:
    """Place and speed (n,) at `times` (n,), ascending; tables: R over speed, P over x − x0, Q
    over t − t0.
    """
    ripple = abs(way.turn) if any(way.ripple) or len(place.values) > 1 else 0.0
    numbers = _Numbers(*(float(n) for n in (
        way.t0, way.x0, way.corner, way.f, way.sin, way.cos, way.mu, way.level, way.gain, way.keep, way.slip_loss,
        max(way.slip_time, 1e-6), *way.ripple, way.turn, way.phase,
        resistance.low, resistance.step, place.low, place.step, time.low, time.step,
        max(LONGEST_STEP_S, (times[-1] - way.t0) / MOST_STEPS),
        ripple / LONGEST_TURN, way.oval,
    )))  # fmt: skip
    x, v = np.empty(len(times)), np.empty(len(times))
    _travel(times, numbers, resistance.values, place.values, time.values, x, v)
    return x, v


def _compiled(function):
    """Compiled once and cached on disk where possible."""
    try:
        return numba.njit(cache=True, error_model="numpy", boundscheck=False)(function)
    except RuntimeError:  # nowhere to keep it
        return numba.njit(error_model="numpy")(function)


@_compiled
def _look(at, low, step, values):
    last = len(values) - 1
    if last == 0:
        return values[0]
    u = (at - low) / step
    if u <= 0:
        return values[0]
    if u >= last:
        return values[last]
    i = int(u)
    return values[i] + (u - i) * (values[i + 1] - values[i])


@_compiled
def _climb(x, p):
    phi = p.turn * x + p.phase
    return 0.5 * p.turn * (p.ripple_sin * np.cos(phi) - p.ripple_cos * np.sin(phi)) if p.ripple_cos != 0.0 or p.ripple_sin != 0.0 else 0.0


@_compiled
def _push(t, x, p, on_incline, in_place, in_time):
    """Drive over weight, whichever way the seed rolls."""
    climb = _climb(x, p)
    extra = _look(x - p.x0, p.place_low, p.place_step, in_place) + _look(t - p.t0, p.time_low, p.time_step, in_time)
    return (p.sin - p.cos * climb if on_incline else p.level - climb) + extra


@_compiled
def _rate(t, x, v, heading, p, on_incline, slipping, by_speed, in_place, in_time):
    normal = p.cos if on_incline else 1.0
    against = p.mu + _look(abs(v), p.resistance_low, p.resistance_step, by_speed)
    a = p.f * (_push(t, x, p, on_incline, in_place, in_time) - heading * normal * against)
    if p.oval != 0.0:
        a += p.oval * v * v * _climb(x, p)
    if on_incline:
        return a * p.gain
    return a - p.slip_loss / p.slip_time if slipping else a


@_compiled
def _step(t, x, v, h, heading, p, on_incline, slipping, by_speed, in_place, in_time):
    k1 = _rate(t, x, v, heading, p, on_incline, slipping, by_speed, in_place, in_time)
    v2 = v + 0.5 * h * k1
    k2 = _rate(t + 0.5 * h, x + 0.5 * h * v, v2, heading, p, on_incline, slipping, by_speed, in_place, in_time)
    v3 = v + 0.5 * h * k2
    k3 = _rate(t + 0.5 * h, x + 0.5 * h * v2, v3, heading, p, on_incline, slipping, by_speed, in_place, in_time)
    v4 = v + h * k3
    k4 = _rate(t + h, x + h * v3, v4, heading, p, on_incline, slipping, by_speed, in_place, in_time)
    return x + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


@_compiled
def _until(t, x, v, h, heading, p, on_incline, slipping, by_speed, in_place, in_time, stop):
    """How much of h passes before the corner (stop False) or the stop (stop True)."""
    low, high = 0.0, h
    for _ in range(BISECTIONS):
        mid = 0.5 * (low + high)
        x1, v1 = _step(t, x, v, mid, heading, p, on_incline, slipping, by_speed, in_place, in_time)
        if (heading * v1 <= 0.0) if stop else (x1 >= p.corner):
            high = mid
        else:
            low = mid
    return high


@_compiled
def _travel(times, p, by_speed, in_place, in_time, x_out, v_out):
    t, x, v, heading = p.t0, p.x0, 0.0, 1.0
    on_incline = x < p.corner
    slip_end, stops = -1e300, 0
    resting = _push(t, x, p, on_incline, in_place, in_time) <= (p.cos if on_incline else 1.0) * p.mu
    for i in range(len(times)):
        while t < times[i] and not resting:
            slipping = t < slip_end
            h = min(times[i] - t, p.longest_step)
            if p.steps_per_way * abs(v) * h > 1.0:
                h = min(h, max(1.0 / (p.steps_per_way * abs(v)), SHORTEST_STEP_S))
            if slipping:
                h = min(h, slip_end - t)
            x1, v1 = _step(t, x, v, h, heading, p, on_incline, slipping, by_speed, in_place, in_time)
            corner = on_incline and x1 >= p.corner
            stop = heading * v1 < 0.0 and not corner
            if corner or stop:
                h = _until(t, x, v, h, heading, p, on_incline, slipping, by_speed, in_place, in_time, stop)
                x1, v1 = _step(t, x, v, h, heading, p, on_incline, slipping, by_speed, in_place, in_time)
            if t + h <= t:
                t = times[i]
            t, x, v = t + h, x1, v1
            if corner:
                on_incline, v, slip_end = False, v * p.keep, t + p.slip_time
            if stop:
                v, stops = 0.0, stops + 1
                push = _push(t, x, p, on_incline, in_place, in_time)
                resting = abs(push) <= (p.cos if on_incline else 1.0) * p.mu * (1 + 1e-9) + 1e-12
                resting = resting or stops > MOST_STOPS
                heading = 1.0 if push > 0 else -1.0
        x_out[i], v_out[i] = x, 0.0 if t > times[i] or resting else v
