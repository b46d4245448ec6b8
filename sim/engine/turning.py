"""Free rotation of up to 32 bodies at once, in vector registers: one body alone is a
chain of divisions that wait for each other.

H = Σ Π_k² / 2 I_k is split into turns about the three principal axes, each solved
exactly, in the order ½1 ½2 3 ½2 ½1 (Dullweber, Leimkuhler, McLachlan 1997, J. Chem.
Phys. 107, 5840). Angular momentum is kept to rounding, the energy error is bounded and
of second order, and there are no sines: tan(θ/2) is taken to its cubic term, and the
turn made of it is a turn exactly. Rows of a tile as in `tiles`, in the place of what
the laws compute.

Rolling friction against a body's own spin is a force of Coulomb's kind: it brakes with
its full torque while the body spins, and holds with no more than is needed once it does
not. `braked` solves that exactly for each half of a step, so that a body at rest stays
at rest. (Applied as a torque of constant size, it would turn a resting body to and fro
from step to step.)"""

import math

from numba import njit

from benchtwin.sim.engine.compiled import INNER
from benchtwin.sim.engine.tiles import COMPUTED, rows

QW, QX, QY, QZ = rows(COMPUTED, 4)  # orientation: unit quaternion, body to world
# angular momentum in the middle of the step, world axes
LX, LY, LZ = rows(COMPUTED + 4, 3)
KX, KY, KZ = rows(COMPUTED + 7, 3)  # what the torque adds to it by the end of the step
J1, J2, J3 = rows(COMPUTED + 10, 3)  # principal moments inverted
WX, WY, WZ = rows(COMPUTED + 13, 3)  # out: spin at the end of the step, world axes
# out: rotation matrix then (not from `turn_round`)
RXX, RXY, RXZ, RYX, RYY, RYZ, RZX, RZY, RZZ = rows(COMPUTED + 16, 9)
# most angular momentum that rolling friction takes in half a step; out: energy it took
BRAKE, LOST = rows(COMPUTED + 25, 2)

THIRD = 1.0 / 3.0
HAS_ROLLING_SPIN = (
    False  # whether a law brakes bodies' own spin; `kernels.build` says so
)


@njit(**INNER)
def matrix(w, x, y, z):
    """Rotation matrix, body to world, of a unit quaternion."""
    return (
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )


@njit(**INNER)
def turned(P, t):
    """The matrix in lane t."""
    return (
        P[RXX + t],
        P[RXY + t],
        P[RXZ + t],
        P[RYX + t],
        P[RYY + t],
        P[RYZ + t],
        P[RZX + t],
        P[RZY + t],
        P[RZZ + t],
    )


@njit(**INNER)
def _half_tangent(angle):
    half = 0.5 * angle
    return half + half * half * half * THIRD


@njit(**INNER)
def braked(p1, p2, p3, j1, j2, j3, most):
    """Angular momentum about principal axes after rolling friction has taken up to
    `most` of it, against the spin.

    Where the friction could take more than all, nothing is left. Inverted moments j;
    also the energy lost [J]."""
    w1, w2, w3 = p1 * j1, p2 * j2, p3 * j3
    spin2 = w1 * w1 + w2 * w2 + w3 * w3
    spin = math.sqrt(spin2)
    # Taken along the spin's direction u, the spin itself is gone once c = |ω| / u·I⁻¹u
    # is taken.
    # 1 / u·I⁻¹u
    along = spin2 / max(w1 * w1 * j1 + w2 * w2 * j2 + w3 * w3 * j3, 1e-300)
    taken = min(most, spin * along) / max(spin, 1e-300)
    left = 1.0 if p1 * p1 + p2 * p2 + p3 * p3 > most * most else 0.0
    q1 = left * (p1 - taken * w1)
    q2 = left * (p2 - taken * w2)
    q3 = left * (p3 - taken * w3)
    lost = 0.5 * (
        p1 * w1 + p2 * w2 + p3 * w3 - q1 * q1 * j1 - q2 * q2 * j2 - q3 * q3 * j3
    )
    return q1, q2, q3, lost


def turn_round(P, count, dt):
    """A step of bodies whose moments agree: their spin is constant, one turn about it
    is the whole motion."""
    for t in range(count):
        j = P[J1 + t]
        if HAS_ROLLING_SPIN:
            most = P[BRAKE + t]
            lx, ly, lz, lost = braked(P[LX + t], P[LY + t], P[LZ + t], j, j, j, most)
            P[LX + t], P[LY + t], P[LZ + t], P[LOST + t] = lx, ly, lz, lost
            lx, ly, lz, _ = braked(
                lx + P[KX + t], ly + P[KY + t], lz + P[KZ + t], j, j, j, most
            )
            P[KX + t], P[KY + t], P[KZ + t] = (
                lx - P[LX + t],
                ly - P[LY + t],
                lz - P[LZ + t],
            )
        h = 0.5 * dt * j
        hx, hy, hz = h * P[LX + t], h * P[LY + t], h * P[LZ + t]
        k = 1.0 + (hx * hx + hy * hy + hz * hz) * THIRD
        hx, hy, hz = k * hx, k * hy, k * hz
        w, x, y, z = P[QW + t], P[QX + t], P[QY + t], P[QZ + t]
        nw = w - hx * x - hy * y - hz * z
        nx = x + hx * w + hy * z - hz * y
        ny = y + hy * w + hz * x - hx * z
        nz = z + hz * w + hx * y - hy * x
        s = 1.0 / math.sqrt(nw * nw + nx * nx + ny * ny + nz * nz)
        P[QW + t], P[QX + t], P[QY + t], P[QZ + t] = s * nw, s * nx, s * ny, s * nz
        P[WX + t] = (P[LX + t] + P[KX + t]) * j
        P[WY + t] = (P[LY + t] + P[KY + t]) * j
        P[WZ + t] = (P[LZ + t] + P[KZ + t]) * j


def turn_free(P, count, dt):
    """A step of bodies with any moments; also their rotation matrices."""
    for t in range(count):
        w, x, y, z = P[QW + t], P[QX + t], P[QY + t], P[QZ + t]
        lx, ly, lz = P[LX + t], P[LY + t], P[LZ + t]
        j1, j2, j3 = P[J1 + t], P[J2 + t], P[J3 + t]
        a, b, c, d, e, f, g, h, i = matrix(w, x, y, z)
        p1 = a * lx + d * ly + g * lz
        p2 = b * lx + e * ly + h * lz
        p3 = c * lx + f * ly + i * lz
        if HAS_ROLLING_SPIN:
            p1, p2, p3, lost = braked(p1, p2, p3, j1, j2, j3, P[BRAKE + t])
            lx = a * p1 + b * p2 + c * p3
            ly = d * p1 + e * p2 + f * p3
            lz = g * p1 + h * p2 + i * p3
            P[LX + t], P[LY + t], P[LZ + t], P[LOST + t] = lx, ly, lz, lost

        u = _half_tangent(0.5 * dt * p1 * j1)
        w, x, y, z = w - u * x, x + u * w, y + u * z, z - u * y
        k = 1.0 / (1.0 + u * u)
        p2, p3 = (
            ((1.0 - u * u) * p2 + 2.0 * u * p3) * k,
            ((1.0 - u * u) * p3 - 2.0 * u * p2) * k,
        )

        u = _half_tangent(0.5 * dt * p2 * j2)
        w, x, y, z = w - u * y, x - u * z, y + u * w, z + u * x
        k = 1.0 / (1.0 + u * u)
        p3, p1 = (
            ((1.0 - u * u) * p3 + 2.0 * u * p1) * k,
            ((1.0 - u * u) * p1 - 2.0 * u * p3) * k,
        )

        u = _half_tangent(dt * p3 * j3)
        w, x, y, z = w - u * z, x + u * y, y - u * x, z + u * w
        k = 1.0 / (1.0 + u * u)
        p1, p2 = (
            ((1.0 - u * u) * p1 + 2.0 * u * p2) * k,
            ((1.0 - u * u) * p2 - 2.0 * u * p1) * k,
        )

        u = _half_tangent(0.5 * dt * p2 * j2)
        w, x, y, z = w - u * y, x - u * z, y + u * w, z + u * x
        k = 1.0 / (1.0 + u * u)
        p3, p1 = (
            ((1.0 - u * u) * p3 + 2.0 * u * p1) * k,
            ((1.0 - u * u) * p1 - 2.0 * u * p3) * k,
        )

        u = _half_tangent(0.5 * dt * p1 * j1)
        w, x, y, z = w - u * x, x + u * w, y + u * z, z - u * y
        s = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
        w, x, y, z = s * w, s * x, s * y, s * z
        P[QW + t], P[QX + t], P[QY + t], P[QZ + t] = w, x, y, z

        a, b, c, d, e, f, g, h, i = matrix(w, x, y, z)
        lx, ly, lz = lx + P[KX + t], ly + P[KY + t], lz + P[KZ + t]
        p1 = a * lx + d * ly + g * lz
        p2 = b * lx + e * ly + h * lz
        p3 = c * lx + f * ly + i * lz
        if HAS_ROLLING_SPIN:
            p1, p2, p3, _ = braked(p1, p2, p3, j1, j2, j3, P[BRAKE + t])
        p1, p2, p3 = p1 * j1, p2 * j2, p3 * j3
        P[WX + t] = a * p1 + b * p2 + c * p3
        P[WY + t] = d * p1 + e * p2 + f * p3
        P[WZ + t] = g * p1 + h * p2 + i * p3
        P[RXX + t], P[RXY + t], P[RXZ + t] = a, b, c
        P[RYX + t], P[RYY + t], P[RYZ + t] = d, e, f
        P[RZX + t], P[RZY + t], P[RZZ + t] = g, h, i
