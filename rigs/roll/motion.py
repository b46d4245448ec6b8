"""A rolling seed: release, incline, corner, level, until it stops or rocks.

    dv/dt = F [ drive − n s (μ + R(|v|)) − n h'(x) + P(x) + Q(t) ] + o v² h'(x)
    F = g / (1 + I/(m r²))

drive: sin β on the incline, that of the slope on the level; n: cos β and 1; s: sign of
the motion; R: speed-dependent resistance over weight; h: height of the centre over its
path; P, Q: pushes over weight; o: an oval seed turns more slowly where its centre is
high (v = ω h). Runge–Kutta of fourth order between events, each met exactly; between
its steps a cubic. R, P, Q are tables, linear between points."""

from typing import NamedTuple

import numba
import numpy as np

from benchtwin.bench.table import NOTHING, Table, look

LONGEST_STEP_S = 8e-3
MOST_STEPS = 1000  # where a fit asks for a release long ago
MOST_STOPS = 500  # after which a rocking seed counts as at rest
SHORTEST_STEP_S = 1e-4
LONGEST_TURN = 0.35  # of the ripple's argument, a step
NEWTON_STEPS = 20  # to the corner or a stop
CLOSE = 1e-14  # of a step, within which these are met


class Tables(NamedTuple):
    """R over speed, P over the way since release, Q over the time since then."""

    resistance: Table
    place: Table
    time: Table


class Way(NamedTuple):
    """Parameters of a run, SI."""

    t0: float  # release
    x0: float
    corner: float  # place where the incline ends
    f: float  # F above
    sin: float  # of the incline
    cos: float
    mu: float
    level: float = 0.0  # drive there
    gain: float = 1.0  # acceleration on the incline over that of rolling
    keep: float = 1.0  # share of the speed kept at the corner
    slip_loss: float = 0.0  # [m/s]: lost within slip_time behind the corner
    slip_time: float = 1.0
    ripple: tuple[float, float] = (0.0, 0.0)  # c, s: h = ½ (c cos φ + s sin φ)
    turn: float = 0.0  # φ = turn x + phase
    phase: float = 0.0
    oval: float = 0.0  # o [1/m]


def travel(
    times: np.ndarray,
    way: Way,
    resistance: Table = NOTHING,
    place: Table = NOTHING,
    time: Table = NOTHING,
) -> tuple[np.ndarray, np.ndarray]:
    """Place and speed (n,) at `times` (n,), ascending."""
    ripple = abs(way.turn) if any(way.ripple) or len(place.values) > 1 else 0.0
    longest = max(LONGEST_STEP_S, (times[-1] - way.t0) / MOST_STEPS)
    way = way._replace(slip_time=max(way.slip_time, 1e-6))
    x, v = np.empty(len(times)), np.empty(len(times))
    _travel(
        times,
        way,
        Tables(resistance, place, time),
        longest,
        ripple / LONGEST_TURN,
        x,
        v,
    )
    return x, v


compiled = numba.njit(cache=True, error_model="numpy", boundscheck=False)


@compiled
def _climb(x, way):
    c, s = way.ripple
    if c == 0.0 and s == 0.0:
        return 0.0
    phi = way.turn * x + way.phase
    return 0.5 * way.turn * (s * np.cos(phi) - c * np.sin(phi))


@compiled
def _push(t, x, way, on_incline, tables):
    """Drive over weight, whichever way the seed rolls."""
    climb = _climb(x, way)
    extra = look(x - way.x0, tables.place) + look(t - way.t0, tables.time)
    return (way.sin - way.cos * climb if on_incline else way.level - climb) + extra


@compiled
def _rate(t, x, v, heading, way, on_incline, slipping, tables):
    normal = way.cos if on_incline else 1.0
    against = way.mu + look(abs(v), tables.resistance)
    a = way.f * (_push(t, x, way, on_incline, tables) - heading * normal * against)
    if way.oval != 0.0:
        a += way.oval * v * v * _climb(x, way)
    if on_incline:
        return a * way.gain
    return a - way.slip_loss / way.slip_time if slipping else a


@compiled
def _step(t, x, v, h, heading, way, on_incline, slipping, tables):
    k1 = _rate(t, x, v, heading, way, on_incline, slipping, tables)
    v2 = v + 0.5 * h * k1
    k2 = _rate(
        t + 0.5 * h, x + 0.5 * h * v, v2, heading, way, on_incline, slipping, tables
    )
    v3 = v + 0.5 * h * k2
    k3 = _rate(
        t + 0.5 * h, x + 0.5 * h * v2, v3, heading, way, on_incline, slipping, tables
    )
    v4 = v + h * k3
    k4 = _rate(t + h, x + h * v3, v4, heading, way, on_incline, slipping, tables)
    return x + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (
        k1 + 2 * k2 + 2 * k3 + k4
    )


@compiled
def _until(t, x, v, h, heading, way, on_incline, slipping, tables, stop):
    """How much of h passes before the corner (stop False) or the stop (stop True), by
    Newton's method from its end."""
    begun, whole = heading, h
    for _ in range(NEWTON_STEPS):
        x1, v1 = _step(t, x, v, h, begun, way, on_incline, slipping, tables)
        if stop:
            rate = _rate(t + h, x1, v1, begun, way, on_incline, slipping, tables)
            less = v1 / rate if rate != 0.0 else h
        else:
            less = (x1 - way.corner) / v1 if v1 != 0.0 else h
        h = min(max(h - less, 0.0), whole)
        if abs(less) <= CLOSE * whole:
            break
    return h


@compiled
def _travel(times, way, tables, longest_step, steps_per_way, x_out, v_out):
    t, x, v, heading = way.t0, way.x0, 0.0, 1.0
    on_incline = x < way.corner
    slip_end, stops = -1e300, 0
    push = _push(t, x, way, on_incline, tables)
    resting = push <= (way.cos if on_incline else 1.0) * way.mu
    i = 0
    while i < len(times) and not resting:
        if times[i] <= t:
            x_out[i], v_out[i] = x, v if times[i] == t else 0.0
            i += 1
            continue
        slipping = t < slip_end
        h = min(times[-1] - t, longest_step)
        if steps_per_way * abs(v) * h > 1.0:
            h = min(h, max(1.0 / (steps_per_way * abs(v)), SHORTEST_STEP_S))
        if slipping:
            h = min(h, slip_end - t)
        x1, v1 = _step(t, x, v, h, heading, way, on_incline, slipping, tables)
        corner = on_incline and x1 >= way.corner
        stop = heading * v1 < 0.0 and not corner
        if corner or stop:
            h = _until(t, x, v, h, heading, way, on_incline, slipping, tables, stop)
            x1, v1 = _step(t, x, v, h, heading, way, on_incline, slipping, tables)
        end = t + h if t + h > t else times[i]
        while i < len(times) and times[i] <= end:
            u = (times[i] - t) / h if h > 0.0 else 1.0
            x_out[i], v_out[i] = _between(min(u, 1.0), h, x, v, x1, v1)
            i += 1
        t, x, v = end, x1, v1
        if corner:
            on_incline, v, slip_end = False, v * way.keep, t + way.slip_time
        if stop:
            v, stops = 0.0, stops + 1
            push = _push(t, x, way, on_incline, tables)
            normal = way.cos if on_incline else 1.0
            resting = (
                abs(push) <= normal * way.mu * (1 + 1e-9) + 1e-12 or stops > MOST_STOPS
            )
            heading = 1.0 if push > 0 else -1.0
    x_out[i:], v_out[i:] = x, 0.0


@compiled
def _between(u, h, x0, v0, x1, v1):
    """Place and speed at the share u of a step, by Hermite's cubic."""
    w = 1.0 - u
    place = (
        x0 * (1 + 2 * u) * w * w
        + v0 * h * u * w * w
        + x1 * u * u * (3 - 2 * u)
        - v1 * h * u * u * w
    )
    way = x1 - x0
    speed = 6 * u * w * way / h if h > 0.0 else 0.0
    return place, speed + v0 * w * (1 - 3 * u) + v1 * u * (3 * u - 2)
