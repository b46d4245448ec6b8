"""The force laws over a tile of contacts, in vector registers.

Contacts are gathered 32 at a time into rows of one small flat array (row r, lane t at
[r * STRIDE + t]), the laws run lane by lane, and the results are scattered back in
order. With one flat array and constant row offsets the compiler can prove that rows do
not overlap and turns the lane loop into vector instructions, the laws in it included.
"""

import math

from benchtwin.sim.engine.quadrature import edge_weight, speed_now
from benchtwin.sim.laws.hertz_mindlin import (
    damping_factor,
    damping_force,
    elastic_force,
    normal_stiffness,
    tangential_force,
)

LANES = 32
# from row to row: no power of two, so that the rows spread over the sets of the
# first-level cache, where all fit
STRIDE = 40


def rows(first: int, count: int) -> list[int]:
    """Where `count` rows of a tile begin, from its row `first` on."""
    return [(first + k) * STRIDE for k in range(count)]


# Filled by the gathering: side i is a ball of a seed, side j another ball or a wall.
DX, DY, DZ, RI, RJ = rows(0, 5)  # from ball centre j to i, radii [m]
# from body centre to ball centre; stay 0 where every seed is one ball
OIX, OIY, OIZ, OJX, OJY, OJZ = rows(5, 6)
# velocity of body i's centre less that of body j's, or of the wall's at the contact
VX, VY, VZ = rows(11, 3)
WIX, WIY, WIZ, WJX, WJY, WJZ, MI, MJ = rows(14, 8)  # spins, masses
UX, UY, UZ = rows(22, 3)  # a wall's velocity at the contact
# part of the masses that this contact's damping answers for (see `contacts.shares`)
SHARE = 25 * STRIDE
MODULUS, SHEAR, DAMPING, MU, MU_R, E_IN = rows(26, 6)  # the pair of materials
# what the contact remembers: tangential displacement (3), impact speed (1), rolling
# spring (3), and what a chosen spring has taken [J]
MEMORY, TAKEN = 32 * STRIDE, 39 * STRIDE
# From the geometry.
COMPUTED = 40  # rows from here to EXTRA hold nothing from one tile to the next
# unit normal from j to i, overlap, effective radius
NX, NY, NZ, OVERLAP, RADIUS = rows(40, 5)
AIX, AIY, AIZ, AJX, AJY, AJZ = rows(45, 6)  # arms from the body centres to the contact
# velocity of i against j at the contact: against and across the normal
CLOSING, SLIP_X, SLIP_Y, SLIP_Z = rows(51, 4)
EDGE = 55 * STRIDE  # see `quadrature.edge_weight`
# From the laws: force on i; for i and for j the torque, the most that the contact
# brakes its own spin by, and the squared speed at the contact, which wakes a sleeper.
FX, FY, FZ, TIX, TIY, TIZ, BRAKE_I, STIR_I, TJX, TJY, TJZ, BRAKE_J, STIR_J = rows(
    56, 13
)
# Accounts: stored energies [J] and, the normal laws' apart, only when the ledger is
# kept, powers [W].
ACCOUNTS = rows(69, 6)
E_NORMAL, E_TANGENTIAL, P_NORMAL, P_TANGENTIAL, P_ROLLING, P_EXTRA = ACCOUNTS
EXTRA = 75 * STRIDE  # the chosen laws' parameters, a row each
FIXED_ROWS = 75

# of the table of material pairs before the laws' parameters: MODULUS … E_IN
COLUMNS = 6


def pair_geometry(P, count):
    """Normal, overlap, effective radius and arms of `count` ball–ball contacts. The
    contact lies in the middle of the overlap."""
    for t in range(count):
        dx, dy, dz = P[DX + t], P[DY + t], P[DZ + t]
        ri, rj = P[RI + t], P[RJ + t]
        distance = math.sqrt(dx * dx + dy * dy + dz * dz)
        inverse = 1.0 / distance
        nx, ny, nz = dx * inverse, dy * inverse, dz * inverse
        overlap = ri + rj - distance
        to_i = ri - 0.5 * overlap
        to_j = rj - 0.5 * overlap
        P[NX + t], P[NY + t], P[NZ + t] = nx, ny, nz
        P[OVERLAP + t] = overlap
        P[RADIUS + t] = ri * rj / (ri + rj)
        P[AIX + t] = P[OIX + t] - nx * to_i
        P[AIY + t] = P[OIY + t] - ny * to_i
        P[AIZ + t] = P[OIZ + t] - nz * to_i
        P[AJX + t] = P[OJX + t] + nx * to_j
        P[AJY + t] = P[OJY + t] + ny * to_j
        P[AJZ + t] = P[OJZ + t] + nz * to_j


def approach(P, count, dt, early):
    """Velocities at `count` contacts, and the weights of those that are at their edge.

    Few are, and a weight costs as much as a fifth of all laws: so they are picked out
    (into `early`) and weighed singly."""
    for t in range(count):
        nx, ny, nz = P[NX + t], P[NY + t], P[NZ + t]
        ax, ay, az = P[AIX + t], P[AIY + t], P[AIZ + t]
        bx, by, bz = P[AJX + t], P[AJY + t], P[AJZ + t]
        wix, wiy, wiz = P[WIX + t], P[WIY + t], P[WIZ + t]
        wjx, wjy, wjz = P[WJX + t], P[WJY + t], P[WJZ + t]
        vx = P[VX + t] + wiy * az - wiz * ay - (wjy * bz - wjz * by)
        vy = P[VY + t] + wiz * ax - wix * az - (wjz * bx - wjx * bz)
        vz = P[VZ + t] + wix * ay - wiy * ax - (wjx * by - wjy * bx)
        closing = -(vx * nx + vy * ny + vz * nz)
        P[CLOSING + t] = closing
        P[SLIP_X + t] = vx + closing * nx
        P[SLIP_Y + t] = vy + closing * ny
        P[SLIP_Z + t] = vz + closing * nz
        P[EDGE + t] = 1.0
    edges = 0
    for t in range(count):
        early[edges] = t
        edges += P[OVERLAP + t] < 2.0 * dt * abs(P[CLOSING + t])
    for n in range(edges):
        P[EDGE + early[n]] = weight(P, early[n], dt)


# What is called above and in `laws` below; `kernels.build` binds the chosen laws in
# their place. P and t lead to a law's parameters.
def weight(P, t, dt):
    """Weight of the damping at a contact's edge: Hertz's."""
    return edge_weight(max(P[OVERLAP + t], 0.0), P[CLOSING + t], dt)


def restitution(impact_speed, e, P, t):
    """Stands for a chosen law of restitution: leaves `e` as it is."""
    return e


def friction(slip_speed, mu, P, t):
    """Stands for a chosen law of friction: leaves `mu` as it is."""
    return mu


def normal(overlap, closing_speed, radius, modulus, P, t):
    """Stands for chosen laws of the normal force: adds none."""
    return 0.0


def spring(gap, closing_speed, radius, modulus, e, damping, P, t):
    """Elastic force [N], what the solids carry [N], stiffness [N/m] and damping γ of
    Hertz's spring; stands for a chosen one, too."""
    overlap = max(gap, 0.0)
    stiffness = normal_stiffness(overlap, radius, modulus)
    elastic = elastic_force(stiffness, overlap)
    return elastic, elastic, stiffness, damping


def rolling_spin(normal_force, spin_speed, arm, mu_r, P, t):
    """Stands for a chosen law of rolling against a body's own spin: no torque."""
    return 0.0


def rolling_relative(normal_force, rolling_speed, radius, mu_r, P, t):
    """Stands for a chosen law of relative rolling: no torque."""
    return 0.0


def rolling_spring(
    mx, my, mz, ax, ay, az, dt, stiffness, normal_force, radius, inertia, mu_r, P, t
):
    """Stands for a chosen law of an elastic–plastic rolling moment: no moment and no
    torque."""
    return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


HAS_RESTITUTION = False
HAS_FRICTION = False
HAS_NORMAL = False
HAS_SPRING = False  # in the place of Hertz's
HAS_ROLLING_SPIN = False
HAS_ROLLING_RELATIVE = False
HAS_ROLLING_SPRING = False
LEDGER = False
NEVER = -1e300  # energy taken, where the contact is new


def laws(P, count, dt, pull, whole):
    """Force and torques of `count` contacts, from geometry, velocities, material pair
    and memory; the memory is brought up to date.

    pull: the most by which damping may exceed the elastic force [N], so that a contact
    pulls at its end: without limit, or 0. whole: 1 where damping counts in the caps of
    friction and rolling, else 0."""
    for t in range(count):
        nx, ny, nz = P[NX + t], P[NY + t], P[NZ + t]
        gap = P[OVERLAP + t]
        overlap = max(gap, 0.0)
        radius = P[RADIUS + t]
        ax, ay, az = P[AIX + t], P[AIY + t], P[AIZ + t]
        bx, by, bz = P[AJX + t], P[AJY + t], P[AJZ + t]
        wix, wiy, wiz = P[WIX + t], P[WIY + t], P[WIZ + t]
        wjx, wjy, wjz = P[WJX + t], P[WJY + t], P[WJZ + t]
        closing = P[CLOSING + t]
        vx, vy, vz = P[SLIP_X + t], P[SLIP_Y + t], P[SLIP_Z + t]
        mi, mj = P[MI + t], P[MJ + t]
        mass = mi * mj / (mi + mj) * P[SHARE + t]

        damping, e = P[DAMPING + t], P[E_IN + t]
        if HAS_RESTITUTION:
            impact = P[MEMORY + 3 * STRIDE + t]
            if impact < 0.0:  # set so by the gathering when the contact is new
                impact = max(closing, 0.0)
                P[MEMORY + 3 * STRIDE + t] = impact
            e = restitution(impact, e, P, t)
            damping = damping_factor(e)
        elastic, carried, stiffness, damping = spring(
            gap, closing, radius, P[MODULUS + t], e, damping, P, t
        )
        damping = damping * P[EDGE + t]
        damped = damping_force(
            stiffness, speed_now(closing, stiffness, mass, dt), mass, damping
        )
        damped = max(damped, -carried - pull)
        # EDEM's F_n is the elastic part: its impulse is exactly m (1 + e) v, damping's
        # over a whole contact being 0.
        carried = abs(carried + whole * damped)

        mu = P[MU + t]
        if HAS_FRICTION:
            mu = friction(math.sqrt(vx * vx + vy * vy + vz * vz), mu, P, t)
        shear = 8.0 * P[SHEAR + t] * math.sqrt(radius * overlap)
        if HAS_SPRING:  # Mindlin's share of any stiffness, which is 2 E* a
            shear = 4.0 * P[SHEAR + t] / P[MODULUS + t] * stiffness
        tx, ty, tz, sx, sy, sz = tangential_force(
            P[MEMORY + t],
            P[MEMORY + STRIDE + t],
            P[MEMORY + 2 * STRIDE + t],
            nx,
            ny,
            nz,
            vx,
            vy,
            vz,
            dt,
            shear,
            mass,
            damping,
            mu * carried,
        )
        if HAS_NORMAL or HAS_SPRING:  # what only a film holds keeps no spring
            held = 1.0 if stiffness > 0.0 else 0.0
            sx, sy, sz = sx * held, sy * held, sz * held
        P[MEMORY + t] = sx
        P[MEMORY + STRIDE + t] = sy
        P[MEMORY + 2 * STRIDE + t] = sz

        extra = 0.0
        if HAS_NORMAL:
            extra = normal(gap, closing, radius, P[MODULUS + t], P, t)
        along = elastic + damped + extra
        fx = along * nx + tx
        fy = along * ny + ty
        fz = along * nz + tz
        P[FX + t], P[FY + t], P[FZ + t] = fx, fy, fz

        rix, riy, riz, rjx, rjy, rjz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        # applied with the step, which knows where they end: see `bodies`
        brake_i, brake_j = 0.0, 0.0
        if HAS_ROLLING_SPIN:
            spin_i = math.sqrt(wix * wix + wiy * wiy + wiz * wiz)
            spin_j = math.sqrt(wjx * wjx + wjy * wjy + wjz * wjz)
            arm_i = math.sqrt(ax * ax + ay * ay + az * az)
            arm_j = math.sqrt(bx * bx + by * by + bz * bz)
            brake_i = rolling_spin(carried, spin_i, arm_i, P[MU_R + t], P, t)
            brake_j = rolling_spin(carried, spin_j, arm_j, P[MU_R + t], P, t)
        P[BRAKE_I + t], P[BRAKE_J + t] = brake_i, brake_j
        stir = closing * closing + vx * vx + vy * vy + vz * vz
        P[STIR_I + t], P[STIR_J + t] = stir, stir
        if HAS_ROLLING_RELATIVE or HAS_ROLLING_SPRING:
            ox, oy, oz = wix - wjx, wiy - wjy, wiz - wjz
            twist = ox * nx + oy * ny + oz * nz
            ox, oy, oz = ox - twist * nx, oy - twist * ny, oz - twist * nz
            if HAS_ROLLING_RELATIVE:
                speed = math.sqrt(ox * ox + oy * oy + oz * oz)
                brake = rolling_relative(
                    carried, speed, radius, P[MU_R + t], P, t
                ) / max(speed, 1e-300)
                rix, riy, riz = rix - brake * ox, riy - brake * oy, riz - brake * oz
                rjx, rjy, rjz = rjx + brake * ox, rjy + brake * oy, rjz + brake * oz
            if HAS_ROLLING_SPRING:
                ri, rj = P[RI + t], P[RJ + t]
                # A ball's own moment about the contact, 7/5 m r² (exact for spheres),
                # both in series; a wall's is endless.
                own, other = 1.4 * mi * ri * ri, 1.4 * mj * rj * rj
                inertia = own * other / (own + other)
                mx, my, mz, qx, qy, qz = rolling_spring(
                    P[MEMORY + 4 * STRIDE + t],
                    P[MEMORY + 5 * STRIDE + t],
                    P[MEMORY + 6 * STRIDE + t],
                    ox * dt,
                    oy * dt,
                    oz * dt,
                    dt,
                    stiffness,
                    carried,
                    radius,
                    inertia,
                    P[MU_R + t],
                    P,
                    t,
                )
                P[MEMORY + 4 * STRIDE + t] = mx
                P[MEMORY + 5 * STRIDE + t] = my
                P[MEMORY + 6 * STRIDE + t] = mz
                rix, riy, riz = rix + qx, riy + qy, riz + qz
                rjx, rjy, rjz = rjx - qx, rjy - qy, rjz - qz
        P[TIX + t] = ay * fz - az * fy + rix
        P[TIY + t] = az * fx - ax * fz + riy
        P[TIZ + t] = ax * fy - ay * fx + riz
        P[TJX + t] = bz * fy - by * fz + rjx
        P[TJY + t] = bx * fz - bz * fx + rjy
        P[TJZ + t] = by * fx - bx * fy + rjz

        P[E_NORMAL + t] = (4.0 / 15.0) * stiffness * overlap * overlap
        if HAS_SPRING:  # nobody knows what it stores: what it took by now counts
            work, taken = dt * elastic * closing, P[TAKEN + t]
            taken = taken + work if taken > NEVER else 0.5 * (elastic * overlap + work)
            P[TAKEN + t], P[E_NORMAL + t] = taken, taken - 0.5 * work
        P[E_TANGENTIAL + t] = 0.5 * shear * (sx * sx + sy * sy + sz * sz)
        if HAS_NORMAL or LEDGER:
            P[P_EXTRA + t] = extra * closing
        if LEDGER:
            P[P_NORMAL + t] = damped * closing
            if HAS_SPRING:
                P[P_NORMAL + t] += elastic * closing
            P[P_TANGENTIAL + t] = -(tx * vx + ty * vy + tz * vz)
            P[P_ROLLING + t] = -(
                rix * wix + riy * wiy + riz * wiz + rjx * wjx + rjy * wjy + rjz * wjz
            )
