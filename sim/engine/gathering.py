"""Between the arrays of a state and a tile: contacts' bodies, parameters and memory in,
forces, torques and memory out."""

from benchtwin.sim.engine import tiles
from benchtwin.sim.engine.bodies import FROM_CONTACTS, MASS, V, W, X
from benchtwin.sim.engine.surfaces import BALL
from benchtwin.sim.engine.tiles import LANES, STRIDE
from benchtwin.sim.engine.view import View

# "& LAST_LANE" tells the compiler that a lane is not negative, which spares it a check
# of every index
LAST_LANE = LANES - 1
WALL_MASS = 1e300  # so that m_i m_j / (m_i + m_j) is the seed's own mass
# Columns of a block's sums.
S_OVERLAP, S_NORMAL, S_TANGENTIAL, S_DAMPED, S_SLIPPED = range(5)
S_ROLLED, S_EXTRA, S_WALLS, S_CONTACTS = range(5, 9)
SUMS = 9
LEDGER = False
HAS_RESTITUTION = False
HAS_ROLLING_SPRING = False
HAS_NORMAL = False
HAS_SPRING = False
# what laws along the normal remember: how many numbers, and their first row in a tile
OWN, OWN_ROW = 0, 0
TAKEN, OWN_FIRST = 7, 8  # columns of a contact's memory: what a spring took, theirs


def gather_two(P, t, ball, motion, single, i, j, a, c):
    """Balls i and j of bodies a and c: where they are and how they move, against each
    other where only that counts."""
    i, j, a, c = 4 * i, 4 * j, 10 * a, 10 * c
    P[tiles.DX + t] = ball[i] - ball[j]
    P[tiles.DY + t] = ball[i + 1] - ball[j + 1]
    P[tiles.DZ + t] = ball[i + 2] - ball[j + 2]
    P[tiles.RJ + t] = ball[j + 3]
    P[tiles.VX + t] = motion[a + V] - motion[c + V]
    P[tiles.VY + t] = motion[a + V + 1] - motion[c + V + 1]
    P[tiles.VZ + t] = motion[a + V + 2] - motion[c + V + 2]
    P[tiles.WJX + t] = motion[c + W]
    P[tiles.WJY + t] = motion[c + W + 1]
    P[tiles.WJZ + t] = motion[c + W + 2]
    P[tiles.MJ + t] = motion[c + MASS]
    if not single:
        P[tiles.OJX + t] = ball[j] - motion[c + X]
        P[tiles.OJY + t] = ball[j + 1] - motion[c + X + 1]
        P[tiles.OJZ + t] = ball[j + 2] - motion[c + X + 2]


def gather_first(P, t, ball, motion, single, i, a):
    """What of ball i and its body a counts by itself. ball and motion are flat, 4 and
    10 numbers a row: constant strides spare a multiplication for each number."""
    i, a = 4 * i, 10 * a
    P[tiles.RI + t] = ball[i + 3]
    P[tiles.WIX + t] = motion[a + W]
    P[tiles.WIY + t] = motion[a + W + 1]
    P[tiles.WIZ + t] = motion[a + W + 2]
    P[tiles.MI + t] = motion[a + MASS]
    if not single:
        P[tiles.OIX + t] = ball[i] - motion[a + X]
        P[tiles.OIY + t] = ball[i + 1] - motion[a + X + 1]
        P[tiles.OIZ + t] = ball[i + 2] - motion[a + X + 2]


def gather_numbers(P, t, row, rows, table):
    """The material pair's numbers and the chosen laws' parameters, unless lane t still
    holds those of the same pair."""
    if rows[t] == row:
        return
    rows[t] = row
    for c in range(tiles.COLUMNS):
        P[tiles.MODULUS + c * STRIDE + t] = table[row, c]
    for c in range(tiles.COLUMNS, table.shape[1]):
        P[tiles.EXTRA + (c - tiles.COLUMNS) * STRIDE + t] = table[row, c]


def recall(P, t, memory, fresh):
    """What the contact remembers; what a new one would is asked for by −1 for its
    impact speed, NEVER for the energy that its spring took."""
    for c in range(3):
        P[tiles.MEMORY + c * STRIDE + t] = memory[c]
    if HAS_RESTITUTION:
        P[tiles.MEMORY + 3 * STRIDE + t] = -1.0 if fresh else memory[3]
    if HAS_ROLLING_SPRING:
        for c in range(4, 7):
            P[tiles.MEMORY + c * STRIDE + t] = memory[c]
    if HAS_SPRING:
        P[tiles.TAKEN + t] = tiles.NEVER if fresh else memory[TAKEN]
    for c in range(OWN):
        P[OWN_ROW + c * STRIDE + t] = memory[OWN_FIRST + c]


def gather_wall(P, t, ball, motion, i, a, meet, twist):
    """Ball i of body a on a wall: geometry, and the wall as the other body, with the
    velocity it has at the contact.

    The contact lies in the middle of the overlap; the spin of a turning wall enters as
    its own (it rolls under the ball)."""
    i, a = 4 * i, 10 * a
    nx, ny, nz, overlap = meet[0], meet[1], meet[2], meet[3]
    radius = P[tiles.RI + t]
    to_i = radius - 0.5 * overlap
    cx, cy, cz = ball[i] - nx * to_i, ball[i + 1] - ny * to_i, ball[i + 2] - nz * to_i
    P[tiles.NX + t], P[tiles.NY + t], P[tiles.NZ + t] = nx, ny, nz
    P[tiles.OVERLAP + t] = overlap
    P[tiles.RADIUS + t] = radius
    P[tiles.AIX + t] = cx - motion[a + X]
    P[tiles.AIY + t] = cy - motion[a + X + 1]
    P[tiles.AIZ + t] = cz - motion[a + X + 2]
    P[tiles.AJX + t], P[tiles.AJY + t], P[tiles.AJZ + t] = 0.0, 0.0, 0.0
    ux = twist[0] + twist[4] * cz - twist[5] * cy
    uy = twist[1] + twist[5] * cx - twist[3] * cz
    uz = twist[2] + twist[3] * cy - twist[4] * cx
    P[tiles.UX + t], P[tiles.UY + t], P[tiles.UZ + t] = ux, uy, uz
    P[tiles.VX + t] = motion[a + V] - ux
    P[tiles.VY + t] = motion[a + V + 1] - uy
    P[tiles.VZ + t] = motion[a + V + 2] - uz
    P[tiles.WJX + t], P[tiles.WJY + t], P[tiles.WJZ + t] = twist[3], twist[4], twist[5]
    P[tiles.MJ + t] = WALL_MASS
    P[tiles.RJ + t] = 1.0


def keep(P, t, memory):
    """Back from the tile: see `recall`."""
    for c in range(3):
        memory[c] = P[tiles.MEMORY + c * STRIDE + t]
    if HAS_RESTITUTION:
        memory[3] = P[tiles.MEMORY + 3 * STRIDE + t]
    if HAS_ROLLING_SPRING:
        for c in range(4, 7):
            memory[c] = P[tiles.MEMORY + c * STRIDE + t]
    if HAS_SPRING:
        memory[TAKEN] = P[tiles.TAKEN + t]
    for c in range(OWN):
        memory[OWN_FIRST + c] = P[OWN_ROW + c * STRIDE + t]


def push(P, t, window, row):
    """Force, torque, brake and stir on side i."""
    for c in range(FROM_CONTACTS):
        window[row + c] += P[tiles.FX + c * STRIDE + t]


def push_back(P, t, window, row):
    """The opposite force, and its own torque, brake and stir, on side j."""
    for c in range(3):
        window[row + c] -= P[tiles.FX + c * STRIDE + t]
    for c in range(FROM_CONTACTS - 3):
        window[row + 3 + c] += P[tiles.TJX + c * STRIDE + t]


def push_wall(P, t, load):
    """Subtract the force in lane `t` of the tile from a wall's load (3,) [N]."""
    for c in range(3):
        load[c] -= P[tiles.FX + c * STRIDE + t]


def gather_pairs(P, s: View, active, share, rows):
    """Fill a tile with the pairs of balls in `active`."""
    for n in range(len(active)):
        t = n & LAST_LANE
        k = active[t]
        i, j = s.pair_i[k], s.pair_j[k]
        a, c = s.owner[i], s.owner[j]
        gather_first(P, t, s.ball, s.motion, s.single, i, a)
        gather_two(P, t, s.ball, s.motion, s.single, i, j, a, c)
        P[tiles.SHARE + t] = share[t] if s.shared else 1.0
        gather_numbers(P, t, s.material[a] * s.materials + s.material[c], rows, s.table)
        recall(P, t, s.pair_memory[k], s.pair_touch[k] == 0)


def gather_walls(P, s: View, active, share, meet, rows):
    """Fill a tile with the balls and walls in `active`; `meet` says where they
    touch."""
    for n in range(len(active)):
        t = n & LAST_LANE
        k = active[t]
        i, p = s.wall_i[k], s.wall_p[k]
        a, w = s.owner[i], s.prim_wall[p]
        gather_first(P, t, s.ball, s.motion, s.single, i, a)
        gather_wall(P, t, s.ball, s.motion, i, a, meet[t], s.twist[w])
        if s.prim_kind[p] == BALL:
            curved = s.prim[p, 9]
            P[tiles.RADIUS + t] *= curved / (P[tiles.RI + t] + curved)
        P[tiles.SHARE + t] = share[t] if s.shared else 1.0
        gather_numbers(
            P, t, s.material[a] * s.materials + s.wall_material[w], rows, s.table
        )
        recall(P, t, s.wall_memory[k], s.wall_touch[k] == 0)


def scatter_pairs(P, s: View, active, base, sums, account):
    """Add a tile's forces and torques to both bodies of each pair, and keep what the
    contacts remember."""
    for n in range(len(active)):
        t = n & LAST_LANE
        k = active[t]
        push(P, t, s.window, (base + s.owner[s.pair_i[k]]) * FROM_CONTACTS)
        push_back(P, t, s.window, (base + s.owner[s.pair_j[k]]) * FROM_CONTACTS)
        keep(P, t, s.pair_memory[k])
        s.pair_touch[k] = 1
        add_up(P, t, sums, False, account)


def scatter_walls(P, s: View, active, base, wall_push, sums, account):
    """Add a tile's forces and torques to bodies and walls, and keep what the contacts
    remember."""
    for n in range(len(active)):
        t = n & LAST_LANE
        k = active[t]
        push(P, t, s.window, (base + s.owner[s.wall_i[k]]) * FROM_CONTACTS)
        push_wall(P, t, wall_push[s.prim_wall[s.wall_p[k]]])
        keep(P, t, s.wall_memory[k])
        s.wall_touch[k] = 1
        add_up(P, t, sums, True, account)


def add_up(P, t, sums, is_wall, account):
    """A contact's entries in its block's sums; account: what it stores, too."""
    overlap = P[tiles.OVERLAP + t]
    smaller = P[tiles.RI + t] if is_wall else min(P[tiles.RI + t], P[tiles.RJ + t])
    if overlap > sums[S_OVERLAP] * smaller:  # spares most divisions
        sums[S_OVERLAP] = overlap / smaller
    if is_wall:  # work that a moving wall does
        for c in range(3):
            row = c * STRIDE + t
            sums[S_WALLS] += P[tiles.FX + row] * P[tiles.UX + row]
    if account:
        sums[S_NORMAL] += P[tiles.E_NORMAL + t]
        sums[S_TANGENTIAL] += P[tiles.E_TANGENTIAL + t]
    if HAS_NORMAL or LEDGER:
        sums[S_EXTRA] += P[tiles.P_EXTRA + t]
    if LEDGER:
        sums[S_DAMPED] += P[tiles.P_NORMAL + t]
        sums[S_SLIPPED] += P[tiles.P_TANGENTIAL + t]
        sums[S_ROLLED] += P[tiles.P_ROLLING + t]
