"""Moving rigid clumps: velocity Verlet for the centre of mass, a symplectic splitting
for the rotation (`turning`).

One step is `predict` (positions and orientations by one step; velocities as far as the
old forces tell), the forces there, and `correct` (velocities with the mean of old and
new forces). Forces that depend on velocity thus see it to second order in the step."""

import math

import numpy as np
from numba import njit

from benchtwin.sim.engine import sleeping, turning
from benchtwin.sim.engine.compiled import INNER
from benchtwin.sim.engine.sleeping import CALM
from benchtwin.sim.engine.tiles import LANES
from benchtwin.sim.engine.turning import turn_free, turn_round
from benchtwin.sim.engine.view import View

# Columns of `motion`: centre of mass, velocity, spin (world axes), mass.
X, V, W, MASS = 0, 3, 6, 9
# Columns of `load` after force (3) and torque (3): the most that rolling friction
# brakes the spin by (`turning.braked`). Contacts add up one more, the squared speeds at
# which they touch the body, which wake it.
BRAKE, STIR = 6, 7
LOAD, FROM_CONTACTS = 7, 8
# Columns of `shape`: principal moments inverted, mass, diameter of the sphere of equal
# volume, bounding radius, whether all moments agree, whether it is one ball about the
# centre of mass, mass inverted.
J1, J2, J3, SHAPE_MASS, DIAMETER, BOUND, ROUND, SINGLE, INVERSE_MASS = range(9)


def traits(shape):
    """1/m and, for bodies of one ball about the centre of mass, 1/I, else 0: numbers of
    each shape, which are read in the bodies' order.

    With thousands of sizes the table of shapes is a cache miss a body."""
    simple = (shape[:, ROUND] > 0) & (shape[:, SINGLE] > 0)
    return np.column_stack(
        [shape[:, INVERSE_MASS], np.where(simple, shape[:, J1], 0.0)]
    )


def predict(first, last, dt, s: View, P, who):
    """Advance bodies first … last−1 and their balls by dt. Returns the longest path of
    a ball since the lists were made, and the energy that rolling friction has taken
    [J]. s: the kernel's view of the state (`view.View`); P is a tile, who its lanes'
    bodies."""
    farthest, lost = 0.0, 0.0
    while first < last:
        count, single = 0, False
        while count < LANES and first < last:
            if s.calm[first] < CALM:
                if count > 0 and (s.trait[2 * first + 1] > 0.0) != single:
                    break
                single = s.trait[2 * first + 1] > 0.0
                who[count] = first
                count += 1
            first += 1
        for t in range(count):
            n = who[t]
            start_step(
                t, dt, P, s.body[n], s.turn[n], s.spin[n], s.load[n], s.trait[2 * n]
            )
            if single:
                P[turning.J1 + t] = s.trait[2 * n + 1]
            else:
                row = s.shape[s.shape_of[n]]
                P[turning.J1 + t] = row[J1]
                P[turning.J2 + t] = row[J2]
                P[turning.J3 + t] = row[J3]
        if single:
            turn_round(P, (count + 3) // 4 * 4, dt)
        else:
            turn_free(P, (count + 3) // 4 * 4, dt)
        for t in range(count):
            n = who[t]
            m = s.body[n]
            end_step(t, P, m, s.turn[n], s.spin[n])
            if HAS_ROLLING_SPIN:
                lost += P[turning.LOST + t]
            if single:
                way = put_ball(
                    s.ball_start[n], m[X], m[X + 1], m[X + 2], s.ball, s.path
                )
            else:
                turned = turning.turned(P, t)
                way = place_balls(
                    s.ball_start[n],
                    m[X],
                    m[X + 1],
                    m[X + 2],
                    turned,
                    s.shape_of[n],
                    s.shape_start,
                    s.shape_ball,
                    s.ball,
                    s.path,
                )
            farthest = max(farthest, way)
    return farthest, lost


def start_step(t, dt, P, m, q, spun, f, inverse_mass):
    """A body by one step, as far as it goes without turning; what the turn needs into
    lane t."""
    h = 0.5 * dt
    half = h * inverse_mass
    vx, vy, vz = m[V] + half * f[0], m[V + 1] + half * f[1], m[V + 2] + half * f[2]
    m[X], m[X + 1], m[X + 2] = m[X] + dt * vx, m[X + 1] + dt * vy, m[X + 2] + dt * vz
    m[V], m[V + 1], m[V + 2] = vx + half * f[0], vy + half * f[1], vz + half * f[2]
    kx, ky, kz = h * f[3], h * f[4], h * f[5]
    P[turning.QW + t] = q[0]
    P[turning.QX + t] = q[1]
    P[turning.QY + t] = q[2]
    P[turning.QZ + t] = q[3]
    P[turning.LX + t] = spun[0] + kx
    P[turning.LY + t] = spun[1] + ky
    P[turning.LZ + t] = spun[2] + kz
    P[turning.KX + t], P[turning.KY + t], P[turning.KZ + t] = kx, ky, kz
    P[turning.BRAKE + t] = h * f[BRAKE]


def end_step(t, P, m, q, spun):
    """Orientation, spin and angular momentum (that of the middle of the step) of a body
    from lane t."""
    spun[0], spun[1], spun[2] = P[turning.LX + t], P[turning.LY + t], P[turning.LZ + t]
    q[0] = P[turning.QW + t]
    q[1] = P[turning.QX + t]
    q[2] = P[turning.QY + t]
    q[3] = P[turning.QZ + t]
    m[W], m[W + 1], m[W + 2] = P[turning.WX + t], P[turning.WY + t], P[turning.WZ + t]


@njit(**INNER)
def put_ball(at, x, y, z, ball, path):
    """Move a ball there; how long its path is by now, a sum of straight steps. ball is
    flat, four numbers a ball."""
    dx, dy, dz = x - ball[4 * at], y - ball[4 * at + 1], z - ball[4 * at + 2]
    ball[4 * at], ball[4 * at + 1], ball[4 * at + 2] = x, y, z
    path[at] += math.sqrt(dx * dx + dy * dy + dz * dz)
    return path[at]


@njit(**INNER)
def place_balls(at, cx, cy, cz, turned, kind, shape_start, shape_ball, ball, path):
    """Move the balls of a body (from number `at` on) to where its centre and rotation
    matrix have them; their longest path."""
    farthest = 0.0
    a, b, c, d, e, f, g, h, i = turned
    first = shape_start[kind]
    for k in range(shape_start[kind + 1] - first):
        u = shape_ball[first + k, 0]
        v = shape_ball[first + k, 1]
        w = shape_ball[first + k, 2]
        x = cx + a * u + b * v + c * w
        y = cy + d * u + e * v + f * w
        z = cz + g * u + h * v + i * w
        farthest = max(farthest, put_ball(at + k, x, y, z, ball, path))
    return farthest


HAS_BODY = False
HAS_ROLLING_SPIN = False


def body_law(vx, vy, vz, wx, wy, wz, diameter, numbers):
    """Force and torque of the chosen body laws together; `kernels.build` binds them in
    its place."""
    return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


def correct(first, last, dt, look, slot, s: View, fresh):
    """Bring velocities of bodies first … last−1 up to date with the mean of the old
    forces `load` and the `fresh` ones (contacts only; weight and body laws are added
    here), which replace them. Returns kinetic energy, largest squared speed, body laws'
    power, and the energy that rolling friction has taken. look: whether bodies may fall
    asleep now; woken[slot] becomes 1 when a body wakes of which not all contacts are
    known."""
    kinetic, fastest, power, lost = 0.0, 0.0, 0.0, 0.0
    h = 0.5 * dt
    g = math.sqrt(
        s.gravity[0] * s.gravity[0]
        + s.gravity[1] * s.gravity[1]
        + s.gravity[2] * s.gravity[2]
    )
    for n in range(first, last):
        asleep = s.calm[n] >= CALM
        m, f, new, spun = s.body[n], s.load[n], fresh[n - first], s.spin[n]
        if asleep and not look:
            if sleeping.is_struck(new[STIR], g, s.shape[s.shape_of[n], DIAMETER]):
                s.calm[n] = 0
                f[:] = 0.0
                s.woken[slot] = 1
            continue
        gx, gy, gz, hx, hy, hz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if HAS_BODY:
            gx, gy, gz, hx, hy, hz = body_law(
                m[V],
                m[V + 1],
                m[V + 2],
                m[W],
                m[W + 1],
                m[W + 2],
                s.shape[s.shape_of[n], DIAMETER],
                s.body_numbers,
            )
            power += (
                gx * m[V]
                + gy * m[V + 1]
                + gz * m[V + 2]
                + hx * m[W]
                + hy * m[W + 1]
                + hz * m[W + 2]
            )
        fx = new[0] + m[MASS] * s.gravity[0] + gx
        fy = new[1] + m[MASS] * s.gravity[1] + gy
        fz = new[2] + m[MASS] * s.gravity[2] + gz
        tx, ty, tz = new[3] + hx, new[4] + hy, new[5] + hz
        pushed = fx, fy, fz, tx, ty, tz, new[BRAKE]
        if look:
            size = s.shape[s.shape_of[n], DIAMETER]
            balanced = sleeping.is_balanced(
                asleep, fx, fy, fz, tx, ty, tz, new[BRAKE], size, m[MASS] * g
            )
            slow = sleeping.is_slow(
                m[V], m[V + 1], m[V + 2], m[W], m[W + 1], m[W + 2], g, size
            )
            if asleep:
                if not balanced:  # from rest
                    s.calm[n] = 0
                    f[0], f[1], f[2] = fx, fy, fz
                    f[3], f[4], f[5], f[BRAKE] = tx, ty, tz, new[BRAKE]
                continue
            s.calm[n] = s.calm[n] + 1 if balanced and slow else 0
            if s.calm[n] >= CALM:
                m[V : V + 6] = 0.0
                spun[:] = 0.0
                continue
        j, row = s.trait[2 * n + 1], s.shape[s.shape_of[n]]
        energy, v2, taken = finish(
            h, pushed, m, f, spun, s.turn[n], s.trait[2 * n], j, row
        )
        kinetic += energy
        fastest = max(fastest, v2)
        lost += taken
    return kinetic, fastest, power, lost


def finish(h, pushed, m, f, spun, q, inverse_mass, j, row):
    """Velocity and spin of a body at the end of a step, h [s] being half of it, by what
    it is `pushed` with: force, torque and brake, which replace the old ones in f.
    Returns kinetic energy, squared speed, and the energy that rolling friction has
    taken. j: see `traits`; row: its shape's."""
    fx, fy, fz, tx, ty, tz, most = pushed
    half = h * inverse_mass
    m[V] += half * (fx - f[0])
    m[V + 1] += half * (fy - f[1])
    m[V + 2] += half * (fz - f[2])
    lx, ly, lz = spun[0] + h * tx, spun[1] + h * ty, spun[2] + h * tz
    f[0], f[1], f[2] = fx, fy, fz
    f[3], f[4], f[5], f[BRAKE] = tx, ty, tz, most
    taken = 0.0
    if j > 0.0:
        if HAS_ROLLING_SPIN:
            lx, ly, lz, taken = turning.braked(lx, ly, lz, j, j, j, h * most)
        m[W], m[W + 1], m[W + 2] = lx * j, ly * j, lz * j
    else:
        j1, j2, j3 = row[J1], row[J2], row[J3]
        a, b, c, d, e, k, o, u, i = turning.matrix(q[0], q[1], q[2], q[3])
        p1 = a * lx + d * ly + o * lz
        p2 = b * lx + e * ly + u * lz
        p3 = c * lx + k * ly + i * lz
        if HAS_ROLLING_SPIN:
            p1, p2, p3, taken = turning.braked(p1, p2, p3, j1, j2, j3, h * most)
            lx = a * p1 + b * p2 + c * p3
            ly = d * p1 + e * p2 + k * p3
            lz = o * p1 + u * p2 + i * p3
        p1, p2, p3 = p1 * j1, p2 * j2, p3 * j3
        m[W] = a * p1 + b * p2 + c * p3
        m[W + 1] = d * p1 + e * p2 + k * p3
        m[W + 2] = o * p1 + u * p2 + i * p3
    spun[0], spun[1], spun[2] = lx, ly, lz
    v2 = m[V] * m[V] + m[V + 1] * m[V + 1] + m[V + 2] * m[V + 2]
    kinetic = 0.5 * m[MASS] * v2 + 0.5 * (
        m[W] * spun[0] + m[W + 1] * spun[1] + m[W + 2] * spun[2]
    )
    return kinetic, v2, taken
