"""Seeds at rest sleep (`World.sleep`): they stand, and contacts between two sleepers
are left out.

Every SLEEP_EVERY steps all contacts are computed. A body that was slow and balanced at
CALM of these in a row falls asleep. It wakes when the forces on it no longer balance,
so that a load is handed on from neighbour to neighbour, or at once when something fast
touches it. Forces are in shares of the body's weight, torques of weight × radius,
speeds of √(g d)."""

import math

from numba import njit

from benchtwin.sim.engine.compiled import INNER

SLEEP_EVERY, CALM = 16, 8
CALM_SPEED, CALM_FORCE, WAKING_FORCE, WAKING_SPEED = 4e-3, 0.05, 0.1, 0.02


@njit(**INNER)
def is_struck(speed2, g, diameter):
    """Whether something touches a sleeper with a squared speed that wakes it at
    once."""
    return speed2 > WAKING_SPEED * WAKING_SPEED * g * diameter


@njit(**INNER)
def is_balanced(asleep, fx, fy, fz, tx, ty, tz, brake, diameter, weight):
    """Whether force and torque leave a body at rest where it is; `brake` is the torque
    that rolling friction can hold."""
    limit = (WAKING_FORCE if asleep else CALM_FORCE) * weight
    torque = math.sqrt(tx * tx + ty * ty + tz * tz)
    return (
        fx * fx + fy * fy + fz * fz <= limit * limit
        and torque <= brake + 0.5 * diameter * limit
    )


@njit(**INNER)
def is_slow(vx, vy, vz, wx, wy, wz, g, diameter):
    """Whether a body moves and turns as slowly as one at rest."""
    moving2 = vx * vx + vy * vy + vz * vz
    turning2 = 0.25 * diameter * diameter * (wx * wx + wy * wy + wz * wz)
    return moving2 + turning2 < CALM_SPEED * CALM_SPEED * g * diameter
