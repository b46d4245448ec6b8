"""A tri-axial ellipsoid that falls on a plate: rigid body in three dimensions, soft
contact, classical Runge–Kutta.

Axes: x to the right and z up in the picture, y into it. Contact is a linear spring and
dashpot at the ellipsoid's lowest point, allowed to pull at its end, so that a central
impact returns exactly the restitution that the law asks for. A world's fields: see
drop.py."""

import math

import numpy as np
from numba import njit

from benchtwin.prove.cases.flight_laws import acceleration, restitution

CONTACT_STEP_S, FINEST_STEP_S = 2e-6, 1e-9
FILM_M = 3e-5  # a film lets go after so much stretching
STUCK_S = 3e-3  # a seed that a film holds for so long bounces no more
SLIP_M_S = 0.01  # Coulomb friction is rounded off below this slip speed
LEAST_IMPACT_M_S = 0.22
NO_CONTACT, PRESSED, STRETCHED = 0, 1, 2
IMPACT = np.dtype(
    [
        (name, float)
        for name in (
            *("begin_s", "end_s", "vx_in", "vz_in", "vx_out", "vz_out"),
            *("e", "normal_m_s", "upright", "turn_in", "turn_out"),
        )
    ]
)


@njit(cache=True)
def rotation(q):
    """Rotation matrix (3, 3) of a unit quaternion (w, x, y, z): body to world."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


@njit(cache=True)
def lowest(r, axes, normal):
    """Height h of the centre above the plane that the ellipsoid just touches, and the
    contact point from the centre (3,)."""
    body = (r.T @ normal) * axes
    h = math.sqrt((body**2).sum())
    return h, -(r @ (axes * body / h))


@njit(cache=True)
def effective_mass(r, point, normal, mass, inertia):
    """Mass that a frictionless blow along `normal` at `point` meets [kg]."""
    arm = r.T @ np.cross(point, normal)
    return 1.0 / (1.0 / mass + (arm**2 / inertia).sum())


@njit(cache=True)
def solid(world):
    """Half axes (3,) [m], mass [kg], moments of inertia (3,) [kg m²], the plate's
    normal (3,)."""
    stretched = world.shape_conversion
    axes = np.array(world.axes) * np.array([1 + stretched, 1.0, 1 - stretched])
    mass = 4 / 3 * math.pi * axes.prod() * world.density
    tilt = math.radians(world.plate_tilt)
    normal = np.array([math.sin(tilt), 0.0, math.cos(tilt)])
    return axes, mass, mass / 5 * ((axes**2).sum() - axes**2), normal


@njit(cache=True)
def stiffness(mass, world):
    """Of the contact [N/m]: half a swing takes contact_s."""
    return mass * (math.pi / world.contact_s) ** 2


@njit(cache=True)
def approach(state, axes, normal):
    """(gap [m], velocity of the lowest point (3,), its part along the normal) of a
    state."""
    r = rotation(state[6:10])
    h, point = lowest(r, axes, normal)
    v = state[3:6] + np.cross(r @ state[10:13], point)
    return (state[:3] * normal).sum() - h, v, (v * normal).sum()


@njit(cache=True)
def rates(state, world, seed, contact, damping):
    """d/dt of state = place (3), velocity (3), quaternion (4), spin about the body's
    axes (3); damping [kg/s]."""
    axes, mass, inertia, n = seed
    v, q, w = state[3:6], state[6:10], state[10:13]
    r = rotation(q)
    force = np.zeros(3)
    if contact == PRESSED:
        gap, at, along = approach(state, axes, n)
        push = -stiffness(mass, world) * gap - damping * along
        slip = at - along * n
        size = math.sqrt((slip**2).sum() + SLIP_M_S**2)
        force = push * n - world.friction * max(push, 0.0) * slip / size
    elif contact == STRETCHED:
        force = -0.5 * mass * world.film_adhesion**2 / FILM_M * n
    torque = r.T @ np.cross(lowest(r, axes, n)[1], force)
    out = np.empty(13)
    out[0:3] = v
    out[3:6] = acceleration(state[0:3], v, r @ w, world) + force / mass
    out[6] = -0.5 * (q[1:] * w).sum()
    out[7:10] = 0.5 * (q[0] * w + np.cross(q[1:], w))
    out[10:13] = (torque - np.cross(w, inertia * w)) / inertia
    return out


@njit(cache=True)
def advance(state, h, world, seed, contact, damping):
    """One step of the classical fourth-order rule."""
    k1 = rates(state, world, seed, contact, damping)
    k2 = rates(state + 0.5 * h * k1, world, seed, contact, damping)
    k3 = rates(state + 0.5 * h * k2, world, seed, contact, damping)
    k4 = rates(state + h * k3, world, seed, contact, damping)
    new = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    new[6:10] /= math.sqrt((new[6:10] ** 2).sum())
    return new


@njit(cache=True)
def fly(state, times, world):
    """States at `times` (n, 13) as far as they are reached, log of impacts."""
    rows, log = np.empty((times.size, 13)), np.zeros(world.most_bounces + 1, IMPACT)
    seed = solid(world)
    axes, mass, inertia, n = seed
    contact, damping, count, now = NO_CONTACT, 0.0, 0, times[0]
    for k in range(times.size):
        while now < times[k] - 1e-12:
            gap, _, vn = approach(state, axes, n)
            r = rotation(state[6:10])
            turn = -(r @ state[10:13])[1]
            impact = log[count]
            if contact == NO_CONTACT and gap <= 0.0 and vn < 0.0:
                if count == world.most_bounces or -state[5] < LEAST_IMPACT_M_S:
                    return rows[:k], log[:count]
                impact.begin_s, impact.turn_in = now, turn
                impact.vx_in, impact.vz_in = state[3], state[5]
                impact.normal_m_s, impact.upright = -vn, abs(r[2, 0])
                impact.e = restitution(-vn, count, impact.upright, world)
                loss = -math.log(impact.e)
                met = effective_mass(r, lowest(r, axes, n)[1], n, mass, inertia)
                share = loss / math.sqrt(math.pi**2 + loss**2)
                damping = 2 * share * math.sqrt(stiffness(mass, world) * met)
                contact = PRESSED
            elif contact == PRESSED and gap > 0.0 and vn > 0.0:
                contact = STRETCHED if world.film_adhesion > 0.0 else NO_CONTACT
            elif contact != NO_CONTACT and now - impact.begin_s > STUCK_S:
                return rows[:k], log[:count]
            elif contact == STRETCHED and gap <= 0.0:
                contact = PRESSED
            elif contact == STRETCHED and gap > FILM_M:
                contact = NO_CONTACT
            if contact == NO_CONTACT and impact.begin_s > 0.0:
                impact.end_s, impact.turn_out = now, turn
                impact.vx_out, impact.vz_out = state[3], state[5]
                count += 1
            step = CONTACT_STEP_S
            if contact == NO_CONTACT and gap > 0.0:
                fastest = abs(vn) + np.abs(state[10:13]).sum() * axes.max() + 0.05
                step = max(step, 0.5 * gap / fastest)
            # land on the plate, not in it; the dashpot must not pull beyond the
            # contact's end
            if (contact == NO_CONTACT and gap > 0.0 and vn < 0.0) or (
                contact == PRESSED and vn > 0.0
            ):
                step = min(step, max(-gap / vn, FINEST_STEP_S))
            step = min(step, times[k] - now)
            state = advance(state, step, world, seed, contact, damping)
            now += step
        rows[k] = state
    return rows, log[:count]


@njit(cache=True)
def outlines(rows, axes):
    """(n, 2, 2) of states (n, 13): points p from the centre with pᵀ S⁻¹ p = 1 are the
    outline [m²]."""
    out = np.empty((len(rows), 2, 2))
    for i in range(len(rows)):
        across = rotation(rows[i, 6:10])[::2] * axes
        out[i] = across @ across.T
    return out


def angle(shapes: np.ndarray) -> np.ndarray:
    """The long axis's angle in the picture (n,), unwrapped [rad], anticlockwise."""
    twice = np.arctan2(2 * shapes[:, 0, 1], shapes[:, 0, 0] - shapes[:, 1, 1])
    return np.unwrap(twice) / 2
