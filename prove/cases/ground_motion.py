"""A block on a plate that tilts: rest, onset, sliding; and seeds that roll. By the
midpoint rule."""

import math

import numpy as np
from numba import njit

from benchtwin.prove.cases.flight_laws import drag_number

G_M_S2 = 9.80665
STEP_S, FINEST_STEP_S = 2e-4, 1e-9
JOG = 0.2  # of a stair's time is spent climbing it
# rows of `block`
STATIC, KINETIC, FALLING, STRIBECK_SPEED, VISCOUS, PULL, SHAKE = range(7)
SHAKE_HZ, ADDED, WORN, HINGE, AIR, REYNOLDS, STAIR = range(7, 14)
BLOCK = 14


@njit(cache=True)
def tilted(steady, rate, block):
    """(tilt, rate): `steady`, or stairs climbed s²(3 − 2s) in the last JOG of their
    time."""
    stair = block[STAIR]
    if stair <= 0.0:
        return steady, rate
    below = math.floor(steady / stair)
    s = max(0.0, (steady / stair - below - 1 + JOG) / JOG)
    return stair * (below + s * s * (3 - 2 * s)), rate * 6 * s * (1 - s) / JOG


@njit(cache=True)
def friction(speed, travel, block):
    """Coefficient of friction [1] while it slides at `speed` [m/s] after `travel`
    [m]."""
    mu = block[KINETIC] + block[VISCOUS] * speed + block[WORN] * travel
    if block[FALLING] > 0.0:
        mu += block[FALLING] * math.exp(-speed / block[STRIBECK_SPEED])
    return mu


@njit(cache=True)
def blown(v, air, re_per_speed):
    """What air takes from a seed at `v` [m/s], over its mass [m/s²]: (ρ A/2m) C_d(Re)
    v|v|; air: ρ A/2m [1/m], Re at 1 m/s."""
    return air * drag_number(re_per_speed * abs(v)) * v * abs(v)


@njit(cache=True)
def drive(t, x, v, steady, rate, block):
    """(downhill push, normal force) over mass [m/s²] in the plate's frame: weight, film
    pull, turning plate, shaking plate."""
    tilt, rate = tilted(steady, rate, block)
    push = G_M_S2 * math.sin(tilt) - (block[HINGE] - x) * rate * rate
    push += block[SHAKE] * math.sin(2 * math.pi * block[SHAKE_HZ] * t)
    normal = G_M_S2 * math.cos(tilt) + block[PULL] - 2 * rate * v
    return push, max(normal, 0.0)


@njit(cache=True)
def pulled(t, x, v, tilt, rate, block):
    """Acceleration along the plate [m/s²] at time t [s], travel x [m], speed v [m/s]
    and tilt [rad]."""
    push, normal = drive(t, x, v, tilt, rate, block)
    return (
        push - friction(v, x, block) * normal - blown(v, block[AIR], block[REYNOLDS])
    ) / (1 + block[ADDED])


@njit(cache=True)
def slide(times, start, rate, block, farthest):
    """Travel [m] at `times` [s] (n,), speed, and the number of times before `farthest`.
    start, rate: tilt in rad and rad/s."""
    x, v, now = 0.0, 0.0, times[0]
    out, speed = np.zeros(times.size), np.zeros(times.size)
    for k in range(times.size):
        steps = max(1, math.ceil((times[k] - now) / STEP_S))
        h = (times[k] - now) / steps
        for _ in range(steps):
            tilt = start + rate * now
            if v <= 0.0:
                push, normal = drive(now, x, 0.0, tilt, rate, block)
                v = 0.0
                if push <= block[STATIC] * normal:
                    now += h
                    continue
            a = pulled(now, x, v, tilt, rate, block)
            middle = pulled(
                now + h / 2,
                x + h / 2 * v,
                max(v + h / 2 * a, 0.0),
                tilt + rate * h / 2,
                rate,
                block,
            )
            x += h * (v + h / 2 * a)
            v += h * middle
            now += h
        out[k], speed[k] = x, v
        if x > farthest:
            return out, speed, k + 1
    return out, speed, times.size


# rows of `seed`
ROLLING, GROWING, LEVEL, BARRIER, RADIUS, PHASE, DRAG, SLIP_FRICTION, SLIPS, LOST = (
    range(10)
)
PATCH_FROM, PATCH_TO, PATCH, BLOWN, RE = range(10, 15)
SEED = 15
ROLLS, DRAG_SPEED_M_S = 5 / 7, 0.5


@njit(cache=True)
def driven(x, incline, seed):
    """Downhill push over weight [1] at x from the junction [m]: incline [rad] where x <
    0, slope of the level after it, shape."""
    push = math.sin(incline if x < 0 else -seed[LEVEL])
    if seed[BARRIER] > 0.0:
        push -= (
            seed[BARRIER] / seed[RADIUS] * math.sin(2 * x / seed[RADIUS] + seed[PHASE])
        )
    return push


@njit(cache=True)
def resisted(x, v, incline, seed):
    """What is against the motion, over weight [1]."""
    resist = seed[ROLLING] + seed[GROWING] * abs(v)
    if seed[PATCH_FROM] < x < seed[PATCH_TO]:
        resist += seed[PATCH]
    air = abs(blown(v, seed[BLOWN], seed[RE])) / G_M_S2
    tilt = incline if x < 0 else seed[LEVEL]
    return resist * math.cos(tilt) + seed[DRAG] * (v / DRAG_SPEED_M_S) ** 2 + air


@njit(cache=True)
def rolled(x, v, way, incline, seed):
    """Acceleration [m/s²] of pure rolling in the direction `way` (±1)."""
    against = way * resisted(x, v, incline, seed)
    return ROLLS * G_M_S2 * (driven(x, incline, seed) - against)


@njit(cache=True)
def roll(times, length, incline, seed):
    """Travel [m] at `times` after the release (n,), and speed. length: of the way on
    the incline [m]."""
    x, v, slip, now, way = -length, 0.0, 0.0, times[0], 1.0
    out, speed = np.zeros(times.size), np.zeros(times.size)
    slips = seed[SLIPS] > 0.0
    for k in range(times.size):
        while now < times[k]:
            h = min(STEP_S, times[k] - now)
            if x < 0.0 < x + 2 * h * v:  # a step ends where the incline does
                h = min(h, max(-x / v, FINEST_STEP_S))
            before = x
            # the foot slides: friction drives the turning, v − ωr is the slip
            if slips:
                tilt = incline if x < 0 else -seed[LEVEL]
                grip = seed[SLIP_FRICTION] * math.cos(tilt)
                a = G_M_S2 * (math.sin(tilt) - grip)
                turning = 2.5 * seed[ROLLING] * math.cos(tilt)
                slip += h * G_M_S2 * (math.sin(tilt) - 3.5 * grip + turning)
                x += h * (v + h / 2 * a)
                v += h * a
                slips = slip >= 0.0
            elif way != 0.0:
                a = rolled(x, v, way, incline, seed)
                middle = rolled(x + h / 2 * v, v + h / 2 * a, way, incline, seed)
                x += h * (v + h / 2 * a)
                v += h * middle
                if v * way <= 0.0:  # it turns back, or stays
                    v, push = 0.0, driven(x, incline, seed)
                    if abs(push) <= resisted(x, 0.0, incline, seed):
                        way = 0.0
                    else:
                        way = math.copysign(1.0, push)
            if before < 0.0 <= x:
                v *= 1 - seed[LOST]
            now = now + h if h < times[k] - now else times[k]
        out[k], speed[k] = x + length, v
    return out, speed
