"""A tri-axial ellipsoid that falls on a plate: rigid body in three dimensions, soft
contact, classical Runge–Kutta.

Axes: x to the right and z up in the picture, y into it. Contact is a linear spring and
dashpot at the ellipsoid's lowest point, allowed to pull at its end, so that a central
impact returns exactly the restitution that the law asks for."""

import math

import numpy as np
from numba import njit

from benchtwin.prove.cases.flight_laws import acceleration, restitution

G_M_S2 = 9.80665
CONTACT_STEP_S, FINEST_STEP_S = 2e-6, 1e-9
FILM_M = 3e-5  # a film lets go after so much stretching
STUCK_S = 3e-3  # a seed that a film holds for so long bounces no more
SLIP_M_S = 0.01  # Coulomb friction is rounded off below this slip speed
NO_CONTACT, PRESSED, STRETCHED = 0, 1, 2

# rows of the log of impacts
T_BEGIN, T_END, VX_IN, VZ_IN, VX_OUT, VZ_OUT = range(6)
E_LAW, V_NORMAL, UPRIGHT, TURN_IN, TURN_OUT = range(6, 11)


@njit(cache=True)
def rotation(q):
    """Rotation matrix (3, 3) of a unit quaternion (w, x, y, z): body to world."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    r = np.empty((3, 3))
    r[0, 0] = 1 - 2 * (y * y + z * z)
    r[0, 1] = 2 * (x * y - w * z)
    r[0, 2] = 2 * (x * z + w * y)
    r[1, 0] = 2 * (x * y + w * z)
    r[1, 1] = 1 - 2 * (x * x + z * z)
    r[1, 2] = 2 * (y * z - w * x)
    r[2, 0] = 2 * (x * z - w * y)
    r[2, 1] = 2 * (y * z + w * x)
    r[2, 2] = 1 - 2 * (x * x + y * y)
    return r


@njit(cache=True)
def lowest(r, axes, normal):
    """Height h of the centre above the plane that the ellipsoid just touches, and the
    contact point from the centre (3,)."""
    body = np.empty(3)
    for i in range(3):
        body[i] = (
            r[0, i] * normal[0] + r[1, i] * normal[1] + r[2, i] * normal[2]
        ) * axes[i]
    h = math.sqrt(body[0] ** 2 + body[1] ** 2 + body[2] ** 2)
    point = np.zeros(3)
    for i in range(3):
        for j in range(3):
            point[j] -= r[j, i] * axes[i] * body[i] / h
    return h, point


@njit(cache=True)
def cross(a, b):
    """Cross product of two vectors (3,)."""
    x, y = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2]
    return np.array((x, y, a[0] * b[1] - a[1] * b[0]))


@njit(cache=True)
def effective_mass(r, point, normal, mass, inertia):
    """Mass that a frictionless blow along `normal` at `point` meets [kg]."""
    arm = cross(point, normal)
    turn = 0.0
    for i in range(3):
        body = r[0, i] * arm[0] + r[1, i] * arm[1] + r[2, i] * arm[2]
        turn += body * body / inertia[i]
    return 1.0 / (1.0 / mass + turn)


@njit(cache=True)
def rates(state, axes, inertia, plate, law, contact):
    """d/dt of state = place (3), velocity (3), quaternion (4), spin about the body's
    axes (3)."""
    out = np.empty(13)
    v, q, w = state[3:6], state[6:10], state[10:13]
    r = rotation(q)
    spin = np.zeros(3)
    for i in range(3):
        for j in range(3):
            spin[i] += r[i, j] * w[j]
    mass = plate[6]
    a = acceleration(state[0:3], v, spin, law)
    torque = np.zeros(3)
    if contact[0] != NO_CONTACT:
        n = plate[0:3]
        h, point = lowest(r, axes, n)
        depth = h - (state[0] * n[0] + state[1] * n[1] + state[2] * n[2])
        vc = v + cross(spin, point)
        vn = vc[0] * n[0] + vc[1] * n[1] + vc[2] * n[2]
        force = np.zeros(3)
        if contact[0] == PRESSED:
            push = plate[4] * depth - contact[1] * vn
            slip = vc - vn * n
            size = math.sqrt(slip[0] ** 2 + slip[1] ** 2 + slip[2] ** 2 + SLIP_M_S**2)
            force = push * n - plate[3] * max(push, 0.0) * slip / size
        else:
            force = -plate[5] / FILM_M * n
        a = a + force / mass
        world = cross(point, force)
        for i in range(3):
            torque[i] = r[0, i] * world[0] + r[1, i] * world[1] + r[2, i] * world[2]
    out[0:3] = v
    out[3:6] = a
    out[6] = -0.5 * (q[1] * w[0] + q[2] * w[1] + q[3] * w[2])
    out[7] = 0.5 * (q[0] * w[0] + q[2] * w[2] - q[3] * w[1])
    out[8] = 0.5 * (q[0] * w[1] + q[3] * w[0] - q[1] * w[2])
    out[9] = 0.5 * (q[0] * w[2] + q[1] * w[1] - q[2] * w[0])
    out[10] = (torque[0] + (inertia[1] - inertia[2]) * w[1] * w[2]) / inertia[0]
    out[11] = (torque[1] + (inertia[2] - inertia[0]) * w[2] * w[0]) / inertia[1]
    out[12] = (torque[2] + (inertia[0] - inertia[1]) * w[0] * w[1]) / inertia[2]
    return out


@njit(cache=True)
def advance(state, h, axes, inertia, plate, law, contact):
    """One step of the classical fourth-order rule."""
    k1 = rates(state, axes, inertia, plate, law, contact)
    k2 = rates(state + 0.5 * h * k1, axes, inertia, plate, law, contact)
    k3 = rates(state + 0.5 * h * k2, axes, inertia, plate, law, contact)
    k4 = rates(state + h * k3, axes, inertia, plate, law, contact)
    new = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    new[6:10] /= math.sqrt((new[6:10] ** 2).sum())
    return new


@njit(cache=True)
def fly(state, times, axes, inertia, plate, law, impact, most, slowest):
    """States at `times` (n, 13), log of impacts (m, 11), number of times reached."""
    rows = np.empty((times.size, 13))
    log = np.zeros((most + 1, 11))
    contact, count, now = np.zeros(2), 0, times[0]
    n, mass = plate[0:3], plate[6]
    for k in range(times.size):
        while now < times[k] - 1e-12:
            r = rotation(state[6:10])
            h, point = lowest(r, axes, n)
            gap = state[0] * n[0] + state[1] * n[1] + state[2] * n[2] - h
            spin = r @ state[10:13]
            vc = state[3:6] + cross(spin, point)
            vn = vc[0] * n[0] + vc[1] * n[1] + vc[2] * n[2]
            if contact[0] == NO_CONTACT and gap <= 0.0 and vn < 0.0:
                if count == most or -state[5] < slowest:
                    return rows, log[:count], k
                e = restitution(-vn, count, abs(r[2, 0]), impact)
                meff = effective_mass(r, point, n, mass, inertia)
                loss = -math.log(e)
                damping = loss / math.sqrt(math.pi**2 + loss**2)
                contact[0] = PRESSED
                contact[1] = 2 * damping * math.sqrt(plate[4] * meff)
                row = log[count]
                row[T_BEGIN] = now
                row[VX_IN] = state[3]
                row[VZ_IN] = state[5]
                row[E_LAW] = e
                row[V_NORMAL], row[UPRIGHT], row[TURN_IN] = -vn, abs(r[2, 0]), -spin[1]
            elif contact[0] == PRESSED and gap > 0.0 and vn > 0.0:
                contact[0] = STRETCHED if plate[5] > 0.0 else NO_CONTACT
            elif contact[0] != NO_CONTACT and now - log[count, T_BEGIN] > STUCK_S:
                return rows, log[:count], k
            elif contact[0] == STRETCHED and gap <= 0.0:
                contact[0] = PRESSED
            elif contact[0] == STRETCHED and gap > FILM_M:
                contact[0] = NO_CONTACT
            if contact[0] == NO_CONTACT and count < most and log[count, T_BEGIN] > 0.0:
                row = log[count]
                row[T_END] = now
                row[VX_OUT] = state[3]
                row[VZ_OUT] = state[5]
                row[TURN_OUT] = -spin[1]
                count += 1
            step = CONTACT_STEP_S
            if contact[0] == NO_CONTACT and gap > 0.0:
                fastest = abs(vn) + np.abs(state[10:13]).sum() * axes.max() + 0.05
                step = max(step, 0.5 * gap / fastest)
                if vn < 0.0:  # land on the plate, not in it
                    step = min(step, max(-gap / vn, FINEST_STEP_S))
            elif (
                contact[0] == PRESSED and vn > 0.0
            ):  # the dashpot must not pull beyond the contact's end
                step = min(step, max(-gap / vn, FINEST_STEP_S))
            step = min(step, times[k] - now)
            state = advance(state, step, axes, inertia, plate, law, contact)
            now += step
        rows[k] = state
    return rows, log[:count], times.size


@njit(cache=True)
def outlines(rows, axes):
    """(n, 2, 2) of states (n, 13): points p from the centre with pᵀ S⁻¹ p = 1 are the
    outline [m²]."""
    out = np.zeros((len(rows), 2, 2))
    for i in range(len(rows)):
        r = rotation(rows[i, 6:10])
        for k in range(3):
            out[i, 0, 0] += (r[0, k] * axes[k]) ** 2
            out[i, 0, 1] += r[0, k] * r[2, k] * axes[k] ** 2
            out[i, 1, 1] += (r[2, k] * axes[k]) ** 2
        out[i, 1, 0] = out[i, 0, 1]
    return out


def angle(shapes: np.ndarray) -> np.ndarray:
    """The long axis's angle in the picture (n,), unwrapped [rad], anticlockwise."""
    twice = np.arctan2(2 * shapes[:, 0, 1], shapes[:, 0, 0] - shapes[:, 1, 1])
    return np.unwrap(twice) / 2
