"""Moving rigid clumps: velocity Verlet for the centre of mass, a symplectic splitting for the rotation (`turning`).

One step is `predict` (positions and orientations by one step; velocities as far as the old forces tell), the forces there, and
`correct` (velocities with the mean of old and new forces). Forces that depend on velocity thus see it to second order in the
step.
"""

import math

import numpy as np
from numba import njit

from sim.engine import turning
from sim.engine.compiled import OPTIONS
from sim.engine.tiles import LANES

# Columns of `motion`: centre of mass, velocity, spin (world axes), mass.
X, V, W, MASS = 0, 3, 6, 9
# Columns of `shape`: principal moments inverted, mass, diameter of the sphere of equal volume, bounding radius, whether all
# moments agree, whether it is one ball about the centre of mass, mass inverted.
J1, J2, J3, SHAPE_MASS, DIAMETER, BOUND, ROUND, SINGLE, INVERSE_MASS = range(9)


@njit(**OPTIONS)
def spin_of(q, shape, lx, ly, lz):
    """Angular velocity R I⁻¹ Rᵀ L in world axes."""
    if shape[ROUND] > 0.0:
        return lx * shape[J1], ly * shape[J1], lz * shape[J1]
    a, b, c, d, e, f, g, h, i = turning.matrix(q[0], q[1], q[2], q[3])
    p = (a * lx + d * ly + g * lz) * shape[J1]
    r = (b * lx + e * ly + h * lz) * shape[J2]
    s = (c * lx + f * ly + i * lz) * shape[J3]
    return a * p + b * r + c * s, d * p + e * r + f * s, g * p + h * r + i * s


def traits(shape, shape_of):
    """1/m and, for bodies of one ball about the centre of mass, 1/I, else 0; two numbers a body, flat, in the bodies' order.

    With thousands of sizes the table of shapes is a cache miss a body; this is read in sequence.
    """
    simple = (shape[:, ROUND] > 0) & (shape[:, SINGLE] > 0)
    return np.column_stack([shape[:, INVERSE_MASS], np.where(simple, shape[:, J1], 0.0)])[shape_of].ravel()


def predict(
    first, last, dt, P, motion, turn, spin, load, trait, shape_of, shape, shape_start, shape_ball, ball_start, ball, path
):
    """Advance bodies first … last−1 and their balls by dt; returns the longest path of a ball since the lists were made. P is a
    tile."""
    farthest = 0.0
    while first < last:
        single = trait[2 * first + 1] > 0.0
        count = 1
        while count < LANES and first + count < last and (trait[2 * (first + count) + 1] > 0.0) == single:
            count += 1
        for t in range(count):
            n = first + t
            start_step(t, dt, P, motion[n], turn[n], spin[n], load[n], trait[2 * n])
            if single:
                P[turning.J1 + t] = trait[2 * n + 1]
            else:
                row = shape[shape_of[n]]
                P[turning.J1 + t], P[turning.J2 + t], P[turning.J3 + t] = row[J1], row[J2], row[J3]
        if single:
            turn_round(P, (count + 3) // 4 * 4, dt)
        else:
            turn_free(P, (count + 3) // 4 * 4, dt)
        for t in range(count):
            n = first + t
            m = motion[n]
            end_step(t, P, m, turn[n])
            if single:
                way = put_ball(ball_start[n], m[X], m[X + 1], m[X + 2], ball, path)
            else:
                turned = turning.turned(P, t)
                way = place_balls(
                    ball_start[n], m[X], m[X + 1], m[X + 2], turned, shape_of[n], shape_start, shape_ball, ball, path
                )
            farthest = max(farthest, way)
        first += count
    return farthest


def start_step(t, dt, P, m, q, spun, f, inverse_mass):
    """A body by one step, as far as it goes without turning; what the turn needs into lane t."""
    h = 0.5 * dt
    half = h * inverse_mass
    vx, vy, vz = m[V] + half * f[0], m[V + 1] + half * f[1], m[V + 2] + half * f[2]
    m[X], m[X + 1], m[X + 2] = m[X] + dt * vx, m[X + 1] + dt * vy, m[X + 2] + dt * vz
    m[V], m[V + 1], m[V + 2] = vx + half * f[0], vy + half * f[1], vz + half * f[2]
    kx, ky, kz = h * f[3], h * f[4], h * f[5]
    lx, ly, lz = spun[0] + kx, spun[1] + ky, spun[2] + kz
    spun[0], spun[1], spun[2] = lx + kx, ly + ky, lz + kz
    P[turning.QW + t], P[turning.QX + t], P[turning.QY + t], P[turning.QZ + t] = q[0], q[1], q[2], q[3]
    P[turning.LX + t], P[turning.LY + t], P[turning.LZ + t] = lx, ly, lz
    P[turning.KX + t], P[turning.KY + t], P[turning.KZ + t] = kx, ky, kz


def end_step(t, P, m, q):
    """Orientation and spin of a body from lane t."""
    q[0], q[1], q[2], q[3] = P[turning.QW + t], P[turning.QX + t], P[turning.QY + t], P[turning.QZ + t]
    m[W], m[W + 1], m[W + 2] = P[turning.WX + t], P[turning.WY + t], P[turning.WZ + t]


turn_round, turn_free = turning.turn_round, turning.turn_free


@njit(**OPTIONS)
def put_ball(at, x, y, z, ball, path):
    """Move a ball there; how long its path is by now, a sum of straight steps. ball is flat, four numbers a ball."""
    dx, dy, dz = x - ball[4 * at], y - ball[4 * at + 1], z - ball[4 * at + 2]
    ball[4 * at], ball[4 * at + 1], ball[4 * at + 2] = x, y, z
    path[at] += math.sqrt(dx * dx + dy * dy + dz * dz)
    return path[at]


@njit(**OPTIONS)
def place_balls(at, cx, cy, cz, turned, kind, shape_start, shape_ball, ball, path):
    """Move the balls of a body (from number `at` on) to where its centre and rotation matrix have them; their longest path."""
    farthest = 0.0
    a, b, c, d, e, f, g, h, i = turned
    first = shape_start[kind]
    for k in range(shape_start[kind + 1] - first):
        u, v, w = shape_ball[first + k, 0], shape_ball[first + k, 1], shape_ball[first + k, 2]
        x, y, z = cx + a * u + b * v + c * w, cy + d * u + e * v + f * w, cz + g * u + h * v + i * w
        farthest = max(farthest, put_ball(at + k, x, y, z, ball, path))
    return farthest


HAS_BODY = False


def body_law(vx, vy, vz, wx, wy, wz, diameter, numbers):
    """Force and torque of the chosen body laws together; `kernels.build` binds them in its place."""
    return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


def correct(first, last, dt, gravity, body_numbers, fresh, motion, turn, spin, load, trait, shape_of, shape):
    """Bring velocities of bodies first … last−1 up to date with the mean of the old forces `load` and the `fresh` ones
    (contacts only; weight and body laws are added here), which replace them. Returns kinetic energy, largest squared speed,
    body laws' power."""
    kinetic, fastest, power = 0.0, 0.0, 0.0
    h = 0.5 * dt
    for n in range(first, last):
        m, f, new, spun = motion[n], load[n], fresh[n - first], spin[n]
        gx, gy, gz, hx, hy, hz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if HAS_BODY:
            gx, gy, gz, hx, hy, hz = body_law(
                m[V], m[V + 1], m[V + 2], m[W], m[W + 1], m[W + 2], shape[shape_of[n], DIAMETER], body_numbers
            )
            power += gx * m[V] + gy * m[V + 1] + gz * m[V + 2] + hx * m[W] + hy * m[W + 1] + hz * m[W + 2]
        fx = new[0] + m[MASS] * gravity[0] + gx
        fy = new[1] + m[MASS] * gravity[1] + gy
        fz = new[2] + m[MASS] * gravity[2] + gz
        half = h * trait[2 * n]
        m[V] += half * (fx - f[0])
        m[V + 1] += half * (fy - f[1])
        m[V + 2] += half * (fz - f[2])
        f[0], f[1], f[2] = fx, fy, fz
        tx, ty, tz = new[3] + hx, new[4] + hy, new[5] + hz
        spun[0] += h * (tx - f[3])
        spun[1] += h * (ty - f[4])
        spun[2] += h * (tz - f[5])
        f[3], f[4], f[5] = tx, ty, tz
        j = trait[2 * n + 1]
        if j > 0.0:
            m[W], m[W + 1], m[W + 2] = spun[0] * j, spun[1] * j, spun[2] * j
        else:
            m[W], m[W + 1], m[W + 2] = spin_of(turn[n], shape[shape_of[n]], spun[0], spun[1], spun[2])
        v2 = m[V] * m[V] + m[V + 1] * m[V + 1] + m[V + 2] * m[V + 2]
        kinetic += 0.5 * m[MASS] * v2 + 0.5 * (m[W] * spun[0] + m[W + 1] * spun[1] + m[W + 2] * spun[2])
        fastest = max(fastest, v2)
    return kinetic, fastest, power
