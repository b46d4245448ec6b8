"""All contacts of one block of bodies: find which listed pairs touch, gather them into tiles, apply the laws, add up the forces.

Blocks are fixed runs of bodies in spatial order, their number set by the number of bodies alone. A block adds into its own window of
forces (its bodies and the partners ahead of it in order); `gather_forces` adds the windows body by body in block order. So the
order of every sum is fixed, however many threads share the blocks.
"""

import math

from numba import njit

from sim.engine import tiles
from sim.engine.bodies import MASS, V, W, X
from sim.engine.compiled import OPTIONS
from sim.engine.surfaces import nearest, shares_feature
from sim.engine.tiles import LANES, STRIDE

LAST_LANE = LANES - 1  # "& LAST_LANE" tells the compiler that a lane is not negative, which spares it a check of every index
WALL_MASS = 1e300  # so that m_i m_j / (m_i + m_j) is the seed's own mass
# Columns of a block's sums.
S_OVERLAP, S_NORMAL, S_TANGENTIAL, S_DAMPED, S_SLIPPED, S_ROLLED, S_EXTRA, S_WALLS, S_CONTACTS = range(9)
SUMS = 9
LEDGER = False
REACH = False
HAS_RESTITUTION = False
HAS_SPRING = False


def reach(radius, modulus, row, table):
    """How far apart a pair that has touched still acts [m]; `kernels.build` binds the chosen laws' in its place."""
    return 0.0


def touching_pairs(first, last, ball, owner, material, materials, table, pair_i, pair_j, memory, touch, active):
    """Listed ball pairs first … last−1 that touch (or still act), into `active`; forgets those that have parted. Returns how many.

    `ball` is flat, four numbers a ball.
    """
    count = 0
    for k in range(first, last):
        i, j = pair_i[k] * 4, pair_j[k] * 4
        dx = ball[i] - ball[j]
        dy = ball[i + 1] - ball[j + 1]
        dz = ball[i + 2] - ball[j + 2]
        both = ball[i + 3] + ball[j + 3]
        gap2 = dx * dx + dy * dy + dz * dz
        hit = gap2 < both * both
        if REACH and not hit and touch[k]:
            row = material[owner[pair_i[k]]] * materials + material[owner[pair_j[k]]]
            both += reach(ball[i + 3] * ball[j + 3] / both, table[row, 0], row, table)
            hit = gap2 < both * both
        active[count] = k
        count += hit
        if touch[k] > hit:
            touch[k] = 0
            memory[k, :] = 0.0
    return count


def touching_walls(first, last, ball, owner, material, materials, table, wall_i, wall_p, memory, touch, prim, prim_kind, prim_wall,
                   wall_material, corners, active, meet):  # fmt: skip
    """Listed ball–primitive pairs first … last−1 that touch, into `active`, with normal and overlap in `meet`. Returns how many.

    A ball near an edge that several triangles of one wall share meets it once: of all primitives that share the nearest feature
    the nearest counts, the first listed among equals. A contact that a ball takes over from a neighbouring triangle of the same
    wall keeps its memory, so that a ball rolls over a tessellated plane as over a plane.
    """
    count = 0
    k = first
    while k < last:
        end = k + 1
        while end < last and wall_i[end] == wall_i[k] and prim_wall[wall_p[end]] == prim_wall[wall_p[k]]:
            end += 1
        start = count
        i = wall_i[k]
        x, y, z, r = ball[4 * i], ball[4 * i + 1], ball[4 * i + 2], ball[4 * i + 3]
        for c in range(k, end):
            p = wall_p[c]
            nx, ny, nz, distance, feature = nearest(prim_kind[p], prim[p], x, y, z)
            limit = r
            if REACH and touch[c]:
                row = material[owner[i]] * materials + wall_material[prim_wall[p]]
                limit += reach(r, table[row, 0], row, table)
            if distance < limit:
                active[count] = c
                meet[count, 0], meet[count, 1], meet[count, 2], meet[count, 3] = nx, ny, nz, r - distance
                meet[count, 4] = feature
                count += 1
        if count - start > 1:
            count = _each_feature_once(start, count, active, meet, wall_p, corners)
        _forget_or_hand_over(k, end, start, count, active, memory, touch)
        k = end
    return count


@njit(**OPTIONS)
def copy(into, row):
    for k in range(len(row)):
        into[k] = row[k]


def _each_feature_once(start, count, active, meet, wall_p, corners):
    kept = start
    for a in range(start, count):
        feature = int(meet[a, 4])
        good = True
        if feature > 0:
            for b in range(start, count):
                if b != a and shares_feature(corners[wall_p[active[a]]], feature, corners[wall_p[active[b]]]):
                    slack = 1e-9 * abs(meet[a, 3])
                    deeper = meet[b, 3] > meet[a, 3] + slack
                    equal = abs(meet[b, 3] - meet[a, 3]) <= slack
                    if deeper or (equal and b < a):
                        good = False
        meet[a, 5] = 1.0 if good else 0.0
    for a in range(start, count):
        if meet[a, 5] > 0.0:
            active[kept] = active[a]
            copy(meet[kept], meet[a])
            kept += 1
    return kept


def _forget_or_hand_over(k, end, start, count, active, memory, touch):
    at = start
    for c in range(k, end):
        if at < count and active[at] == c:
            at += 1
        elif touch[c]:
            for a in range(start, count):
                if not touch[active[a]]:
                    touch[active[a]] = 1
                    copy(memory[active[a]], memory[c])
                    break
            touch[c] = 0
            memory[c, :] = 0.0


def shares_of_pairs(count, active, ball, owner, pair_i, pair_j, share):
    """Each contact's share of the damping where several balls of one seed touch the same other seed.

    Springs side by side add up, S = Σ S_k, but dashpots γ √(S_k m) would add up to more than γ √(S m), and a seed that lands on k
    balls would rebound less. With m_k = m S_k / S they sum to exactly that: restitution then does not depend on the number of
    balls. S_k ∝ √(R* δ), one material pair.
    """
    a = 0
    while a < count:
        i, j = pair_i[active[a]], pair_j[active[a]]
        end = a + 1
        while end < count and owner[pair_i[active[end]]] == owner[i] and owner[pair_j[active[end]]] == owner[j]:
            end += 1
        if end == a + 1:
            share[a:end] = 1.0
        else:
            total = 0.0
            for c in range(a, end):
                i, j = 4 * pair_i[active[c]], 4 * pair_j[active[c]]
                dx, dy, dz = ball[i] - ball[j], ball[i + 1] - ball[j + 1], ball[i + 2] - ball[j + 2]
                overlap = ball[i + 3] + ball[j + 3] - math.sqrt(dx * dx + dy * dy + dz * dz)
                share[c] = math.sqrt(max(overlap, 0.0) * ball[i + 3] * ball[j + 3] / (ball[i + 3] + ball[j + 3]))
                total += share[c]
            for c in range(a, end):
                share[c] /= max(total, 1e-300)
        a = end


def shares_of_walls(count, active, meet, ball, owner, wall_i, wall_p, prim_wall, share):
    """The same for several balls of one seed on the same wall."""
    a = 0
    while a < count:
        body, wall = owner[wall_i[active[a]]], prim_wall[wall_p[active[a]]]
        end = a + 1
        while end < count and owner[wall_i[active[end]]] == body and prim_wall[wall_p[active[end]]] == wall:
            end += 1
        if end == a + 1:
            share[a:end] = 1.0
        else:
            total = 0.0
            for c in range(a, end):
                share[c] = math.sqrt(max(meet[c, 3], 0.0) * ball[4 * wall_i[active[c]] + 3])
                total += share[c]
            for c in range(a, end):
                share[c] /= max(total, 1e-300)
        a = end


def gather_side(P, t, at, ball, i, motion, a):
    """Ball i, centre, velocity, spin and mass of body a into tile rows that start at `at` = (ball, centre, velocity).

    ball and motion are flat, 4 and 10 numbers a row: constant strides spare a multiplication for each number.
    """
    b, c, v = at
    i *= 4
    P[b + t] = ball[i]
    P[b + STRIDE + t] = ball[i + 1]
    P[b + 2 * STRIDE + t] = ball[i + 2]
    P[b + 3 * STRIDE + t] = ball[i + 3]
    a *= 10
    P[c + t] = motion[a + X]
    P[c + STRIDE + t] = motion[a + X + 1]
    P[c + 2 * STRIDE + t] = motion[a + X + 2]
    P[v + t] = motion[a + V]
    P[v + STRIDE + t] = motion[a + V + 1]
    P[v + 2 * STRIDE + t] = motion[a + V + 2]
    P[v + 3 * STRIDE + t] = motion[a + W]
    P[v + 4 * STRIDE + t] = motion[a + W + 1]
    P[v + 5 * STRIDE + t] = motion[a + W + 2]
    P[v + 6 * STRIDE + t] = motion[a + MASS]


def gather_numbers(P, t, row, rows, table):
    """The material pair's numbers and the chosen laws' parameters, unless lane t still holds those of the same pair."""
    if rows[t] == row:
        return
    rows[t] = row
    for c in range(tiles.COLUMNS):
        P[tiles.MODULUS + c * STRIDE + t] = table[row, c]
    for c in range(tiles.COLUMNS, table.shape[1]):
        P[tiles.EXTRA + (c - tiles.COLUMNS) * STRIDE + t] = table[row, c]


def recall(P, t, memory, fresh):
    """What the contact remembers; a new one's impact speed is asked for by −1."""
    for c in range(3):
        P[tiles.MEMORY + c * STRIDE + t] = memory[c]
    if HAS_RESTITUTION:
        P[tiles.MEMORY + 3 * STRIDE + t] = -1.0 if fresh else memory[3]
    if HAS_SPRING:
        for c in range(4, 7):
            P[tiles.MEMORY + c * STRIDE + t] = memory[c]


def gather_wall(P, t, meet, twist):
    """A ball on a wall: geometry, and the wall as the other body, its "centre" at the contact, with the velocity it has there.

    The contact lies in the middle of the overlap; the spin of a turning wall enters as its own (it rolls under the ball).
    """
    nx, ny, nz, overlap = meet[0], meet[1], meet[2], meet[3]
    radius = P[tiles.BIR + t]
    to_i = radius - 0.5 * overlap
    cx, cy, cz = P[tiles.BIX + t] - nx * to_i, P[tiles.BIY + t] - ny * to_i, P[tiles.BIZ + t] - nz * to_i
    P[tiles.NX + t], P[tiles.NY + t], P[tiles.NZ + t] = nx, ny, nz
    P[tiles.OVERLAP + t] = overlap
    P[tiles.RADIUS + t] = radius
    P[tiles.SQUEEZE + t] = overlap / radius
    P[tiles.AIX + t] = cx - P[tiles.CIX + t]
    P[tiles.AIY + t] = cy - P[tiles.CIY + t]
    P[tiles.AIZ + t] = cz - P[tiles.CIZ + t]
    P[tiles.AJX + t], P[tiles.AJY + t], P[tiles.AJZ + t] = 0.0, 0.0, 0.0
    P[tiles.VJX + t] = twist[0] + twist[4] * cz - twist[5] * cy
    P[tiles.VJY + t] = twist[1] + twist[5] * cx - twist[3] * cz
    P[tiles.VJZ + t] = twist[2] + twist[3] * cy - twist[4] * cx
    P[tiles.WJX + t], P[tiles.WJY + t], P[tiles.WJZ + t] = twist[3], twist[4], twist[5]
    P[tiles.MJ + t] = WALL_MASS
    P[tiles.BJR + t] = 1.0


def keep(P, t, memory):
    """Back from the tile: see `recall`."""
    for c in range(3):
        memory[c] = P[tiles.MEMORY + c * STRIDE + t]
    if HAS_RESTITUTION:
        memory[3] = P[tiles.MEMORY + 3 * STRIDE + t]
    if HAS_SPRING:
        for c in range(4, 7):
            memory[c] = P[tiles.MEMORY + c * STRIDE + t]


def add_up(P, t, sums, is_wall):
    """A contact's entries in its block's sums."""
    sums[S_OVERLAP] = max(sums[S_OVERLAP], P[tiles.SQUEEZE + t])
    if LEDGER:
        sums[S_NORMAL] += P[tiles.E_NORMAL + t]
        sums[S_TANGENTIAL] += P[tiles.E_TANGENTIAL + t]
        sums[S_DAMPED] += P[tiles.P_NORMAL + t]
        sums[S_SLIPPED] += P[tiles.P_TANGENTIAL + t]
        sums[S_ROLLED] += P[tiles.P_ROLLING + t]
        sums[S_EXTRA] += P[tiles.P_EXTRA + t]
        if is_wall:
            sums[S_WALLS] += P[tiles.P_WALL + t]


def push(P, t, window, row):
    """Force and torque on side i."""
    for c in range(6):
        window[row + c] += P[tiles.FX + c * STRIDE + t]


def push_back(P, t, window, row):
    """The opposite force and its own torque on side j."""
    for c in range(3):
        window[row + c] -= P[tiles.FX + c * STRIDE + t]
        window[row + 3 + c] += P[tiles.TJX + c * STRIDE + t]


def push_wall(P, t, load):
    for c in range(3):
        load[c] -= P[tiles.FX + c * STRIDE + t]


def block_forces(b, dt, s, P, active, meet, share, rows):
    """Forces of all contacts of block b, into its window; `s` is the kernel's view of the state (`kernels.View`)."""
    base = s.block_window[b] - s.block_body[b]
    s.window[s.block_window[b] * 6 : s.block_window[b + 1] * 6] = 0.0
    s.wall_push[b, :, :] = 0.0
    sums = s.sums[b]
    sums[:] = 0.0
    first, last = s.block_pair[b], s.block_pair[b + 1]
    pairs = touching_pairs(
        first, last, s.ball, s.owner, s.material, s.materials, s.table, s.pair_i, s.pair_j, s.pair_memory, s.pair_touch, active
    )
    if s.shared:
        shares_of_pairs(pairs, active, s.ball, s.owner, s.pair_i, s.pair_j, share)
    first, last = s.block_wall[b], s.block_wall[b + 1]
    walls = touching_walls(
        first, last, s.ball, s.owner, s.material, s.materials, s.table, s.wall_i, s.wall_p, s.wall_memory, s.wall_touch, s.prim,
        s.prim_kind, s.prim_wall, s.wall_material, s.corners, active[pairs:], meet,
    )  # fmt: skip
    if s.shared:
        shares_of_walls(walls, active[pairs:], meet, s.ball, s.owner, s.wall_i, s.wall_p, s.prim_wall, share[pairs:])
    sums[S_CONTACTS] = pairs + walls

    tiles_of_pairs = (pairs + LANES - 1) // LANES
    tiles_of_walls = (walls + LANES - 1) // LANES
    for tile in range(tiles_of_pairs + tiles_of_walls):
        if tile < tiles_of_pairs:
            at = tile * LANES
            count = min(LANES, pairs - at)
            gather_pairs(P, s, active[at : at + count], share[at : at + count], rows)
            pair_geometry(P, (count + 7) // 8 * 8)
        else:
            at = pairs + (tile - tiles_of_pairs) * LANES
            count = min(LANES, pairs + walls - at)
            gather_walls(P, s, active[at : at + count], share[at : at + count], meet[at - pairs :], rows)
        laws(P, (count + 7) // 8 * 8, dt, s.pull)  # whole vectors; lanes beyond `count` hold leftovers that nobody reads
        if tile < tiles_of_pairs:
            scatter_pairs(P, s, active[at : at + count], base, sums)
        else:
            scatter_walls(P, s, active[at : at + count], base, s.wall_push[b], sums)


def gather_pairs(P, s, active, share, rows):
    for n in range(len(active)):
        t = n & LAST_LANE
        k = active[t]
        i, j = s.pair_i[k], s.pair_j[k]
        a, c = s.owner[i], s.owner[j]
        gather_side(P, t, (tiles.BIX, tiles.CIX, tiles.VIX), s.ball, i, s.motion, a)
        gather_side(P, t, (tiles.BJX, tiles.CJX, tiles.VJX), s.ball, j, s.motion, c)
        P[tiles.SHARE + t] = share[t] if s.shared else 1.0
        gather_numbers(P, t, s.material[a] * s.materials + s.material[c], rows, s.table)
        recall(P, t, s.pair_memory[k], s.pair_touch[k] == 0)


def gather_walls(P, s, active, share, meet, rows):
    for n in range(len(active)):
        t = n & LAST_LANE
        k = active[t]
        i, p = s.wall_i[k], s.wall_p[k]
        a, w = s.owner[i], s.prim_wall[p]
        gather_side(P, t, (tiles.BIX, tiles.CIX, tiles.VIX), s.ball, i, s.motion, a)
        gather_wall(P, t, meet[t], s.twist[w])
        P[tiles.SHARE + t] = share[t] if s.shared else 1.0
        gather_numbers(P, t, s.material[a] * s.materials + s.wall_material[w], rows, s.table)
        recall(P, t, s.wall_memory[k], s.wall_touch[k] == 0)


def scatter_pairs(P, s, active, base, sums):
    for n in range(len(active)):
        t = n & LAST_LANE
        k = active[t]
        push(P, t, s.window, (base + s.owner[s.pair_i[k]]) * 6)
        push_back(P, t, s.window, (base + s.owner[s.pair_j[k]]) * 6)
        keep(P, t, s.pair_memory[k])
        s.pair_touch[k] = 1
        add_up(P, t, sums, False)


def scatter_walls(P, s, active, base, wall_push, sums):
    for n in range(len(active)):
        t = n & LAST_LANE
        k = active[t]
        push(P, t, s.window, (base + s.owner[s.wall_i[k]]) * 6)
        push_wall(P, t, wall_push[s.prim_wall[s.wall_p[k]]])
        keep(P, t, s.wall_memory[k])
        s.wall_touch[k] = 1
        add_up(P, t, sums, True)


pair_geometry = tiles.pair_geometry
laws = tiles.laws


def gather_forces(c, block_body, block_window, window, fresh):
    """Contact forces on the bodies of block c: the windows of all blocks that reach them, added in block order, into `fresh`."""
    first, last = block_body[c], block_body[c + 1]
    for n in range(first, last):
        for k in range(6):
            fresh[n - first, k] = 0.0
    for b in range(c + 1):
        shift = block_window[b] - block_body[b]
        end = min(last, block_body[b] + block_window[b + 1] - block_window[b])
        for n in range(first, end):
            for k in range(6):
                fresh[n - first, k] += window[6 * (shift + n) + k]
