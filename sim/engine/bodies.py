"""Moving rigid clumps: velocity Verlet for the centre of mass, a symplectic splitting for the rotation.

One step is `predict` (positions and orientations by one step; velocities as far as the old forces tell), the forces there, and
`correct` (velocities with the mean of old and new forces). Forces that depend on velocity thus see it to second order in the
step.

Free rotation: H = Σ Π_k² / 2 I_k is split into turns about the three principal axes, each solved exactly, in the order ½1 ½2 3
½2 ½1 (Dullweber, Leimkuhler, McLachlan 1997, J. Chem. Phys. 107, 5840). Angular momentum is kept to rounding, the energy error
is bounded and of second order, and there are no sines: tan(θ/2) is taken to its cubic term, and the turn made of it is a turn
exactly.
"""

import math

import numpy as np
from numba import njit

from sim.engine.compiled import OPTIONS

# Columns of `motion`: centre of mass, velocity, spin (world axes), mass.
X, V, W, MASS = 0, 3, 6, 9
# Columns of `shape`: principal moments inverted, mass, diameter of the sphere of equal volume, bounding radius, whether all
# moments agree, whether it is one ball about the centre of mass, mass inverted.
J1, J2, J3, SHAPE_MASS, DIAMETER, BOUND, ROUND, SINGLE, INVERSE_MASS = range(9)


@njit(**OPTIONS)
def matrix(q):
    """Rotation matrix, body to world, of a unit quaternion (w, x, y, z)."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    return (
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),
        2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y),
    )  # fmt: skip


@njit(**OPTIONS)
def spin_of(q, shape, lx, ly, lz):
    """Angular velocity R I⁻¹ Rᵀ L in world axes."""
    if shape[ROUND] > 0.0:
        return lx * shape[J1], ly * shape[J1], lz * shape[J1]
    a, b, c, d, e, f, g, h, i = matrix(q)
    p = (a * lx + d * ly + g * lz) * shape[J1]
    r = (b * lx + e * ly + h * lz) * shape[J2]
    s = (c * lx + f * ly + i * lz) * shape[J3]
    return a * p + b * r + c * s, d * p + e * r + f * s, g * p + h * r + i * s


@njit(**OPTIONS)
def _half_tangent(angle):
    half = 0.5 * angle
    return half + half * half * half / 3.0


@njit(**OPTIONS)
def turn_round(q, wx, wy, wz, dt):
    """Orientation after dt at a constant spin: the whole free motion of a body whose moments agree."""
    hx, hy, hz = 0.5 * dt * wx, 0.5 * dt * wy, 0.5 * dt * wz
    k = 1.0 + (hx * hx + hy * hy + hz * hz) / 3.0
    hx, hy, hz = k * hx, k * hy, k * hz
    w, x, y, z = q[0], q[1], q[2], q[3]
    nw = w - hx * x - hy * y - hz * z
    nx = x + hx * w + hy * z - hz * y
    ny = y + hy * w + hz * x - hx * z
    nz = z + hz * w + hx * y - hy * x
    s = 1.0 / math.sqrt(nw * nw + nx * nx + ny * ny + nz * nz)
    q[0], q[1], q[2], q[3] = s * nw, s * nx, s * ny, s * nz


@njit(**OPTIONS)
def turn_free(q, shape, lx, ly, lz, dt):
    """Orientation after dt of free rotation with angular momentum L (world axes)."""
    a, b, c, d, e, f, g, h, i = matrix(q)
    p1, p2, p3 = a * lx + d * ly + g * lz, b * lx + e * ly + h * lz, c * lx + f * ly + i * lz
    w, x, y, z = q[0], q[1], q[2], q[3]

    t = _half_tangent(0.5 * dt * p1 * shape[J1])
    w, x, y, z = w - t * x, x + t * w, y + t * z, z - t * y
    k = 1.0 / (1.0 + t * t)
    p2, p3 = ((1.0 - t * t) * p2 + 2.0 * t * p3) * k, ((1.0 - t * t) * p3 - 2.0 * t * p2) * k

    t = _half_tangent(0.5 * dt * p2 * shape[J2])
    w, x, y, z = w - t * y, x - t * z, y + t * w, z + t * x
    k = 1.0 / (1.0 + t * t)
    p3, p1 = ((1.0 - t * t) * p3 + 2.0 * t * p1) * k, ((1.0 - t * t) * p1 - 2.0 * t * p3) * k

    t = _half_tangent(dt * p3 * shape[J3])
    w, x, y, z = w - t * z, x + t * y, y - t * x, z + t * w
    k = 1.0 / (1.0 + t * t)
    p1, p2 = ((1.0 - t * t) * p1 + 2.0 * t * p2) * k, ((1.0 - t * t) * p2 - 2.0 * t * p1) * k

    t = _half_tangent(0.5 * dt * p2 * shape[J2])
    w, x, y, z = w - t * y, x - t * z, y + t * w, z + t * x
    k = 1.0 / (1.0 + t * t)
    p3, p1 = ((1.0 - t * t) * p3 + 2.0 * t * p1) * k, ((1.0 - t * t) * p1 - 2.0 * t * p3) * k

    t = _half_tangent(0.5 * dt * p1 * shape[J1])
    w, x, y, z = w - t * x, x + t * w, y + t * z, z - t * y
    s = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    q[0], q[1], q[2], q[3] = s * w, s * x, s * y, s * z


def traits(shape, shape_of):
    """1/m and, for bodies of one ball about the centre of mass, 1/I, else 0; two numbers a body, flat, in the bodies' order.

    With thousands of sizes the table of shapes is a cache miss a body; this is read in sequence.
    """
    simple = (shape[:, ROUND] > 0) & (shape[:, SINGLE] > 0)
    return np.column_stack([shape[:, INVERSE_MASS], np.where(simple, shape[:, J1], 0.0)])[shape_of].ravel()


@njit(**OPTIONS)
def predict(first, last, dt, motion, turn, spin, load, trait, shape_of, shape, shape_start, shape_ball, ball_start, ball, ref):
    """Advance bodies first … last−1 and their balls by dt; returns the largest squared way of a ball since the lists were
    made."""
    farthest = 0.0
    h = 0.5 * dt
    for n in range(first, last):
        m, f, q, spun = motion[n], load[n], turn[n], spin[n]
        half, j = h * trait[2 * n], trait[2 * n + 1]
        vx, vy, vz = m[V] + half * f[0], m[V + 1] + half * f[1], m[V + 2] + half * f[2]
        x, y, z = m[X] + dt * vx, m[X + 1] + dt * vy, m[X + 2] + dt * vz
        m[X], m[X + 1], m[X + 2] = x, y, z
        m[V], m[V + 1], m[V + 2] = vx + half * f[0], vy + half * f[1], vz + half * f[2]
        tx, ty, tz = h * f[3], h * f[4], h * f[5]
        lx, ly, lz = spun[0] + tx, spun[1] + ty, spun[2] + tz
        if j > 0.0:
            turn_round(q, lx * j, ly * j, lz * j, dt)
            lx, ly, lz = lx + tx, ly + ty, lz + tz
            spun[0], spun[1], spun[2] = lx, ly, lz
            m[W], m[W + 1], m[W + 2] = lx * j, ly * j, lz * j
            at = ball_start[n]
            ball[4 * at], ball[4 * at + 1], ball[4 * at + 2] = x, y, z
            dx, dy, dz = x - ref[3 * at], y - ref[3 * at + 1], z - ref[3 * at + 2]
            farthest = max(farthest, dx * dx + dy * dy + dz * dz)
            continue
        s = shape[shape_of[n]]
        if s[ROUND] > 0.0:
            turn_round(q, lx * s[J1], ly * s[J1], lz * s[J1], dt)
        else:
            turn_free(q, s, lx, ly, lz, dt)
        lx, ly, lz = lx + tx, ly + ty, lz + tz
        spun[0], spun[1], spun[2] = lx, ly, lz
        m[W], m[W + 1], m[W + 2] = spin_of(q, s, lx, ly, lz)
        farthest = max(farthest, place_balls(n, x, y, z, q, shape_of[n], shape_start, shape_ball, ball_start, ball, ref))
    return farthest


@njit(**OPTIONS)
def place_balls(n, cx, cy, cz, q, kind, shape_start, shape_ball, ball_start, ball, ref):
    """Put the balls of body n where its centre and orientation have them; largest squared distance of one from `ref`.

    ball and ref are flat, 4 and 3 numbers a ball.
    """
    at = ball_start[n]
    farthest = 0.0
    a, b, c, d, e, f, g, h, i = matrix(q)
    for k in range(shape_start[kind], shape_start[kind + 1]):
        u, v, w = shape_ball[k, 0], shape_ball[k, 1], shape_ball[k, 2]
        x, y, z = cx + a * u + b * v + c * w, cy + d * u + e * v + f * w, cz + g * u + h * v + i * w
        ball[4 * at], ball[4 * at + 1], ball[4 * at + 2] = x, y, z
        dx, dy, dz = x - ref[3 * at], y - ref[3 * at + 1], z - ref[3 * at + 2]
        farthest = max(farthest, dx * dx + dy * dy + dz * dz)
        at += 1
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
