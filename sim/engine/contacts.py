"""All contacts of one block of bodies: find which listed pairs touch, gather them into
tiles, apply the laws, add up the forces.

Blocks are fixed runs of bodies in spatial order, their number set by the number of
bodies alone. A block adds into its own window of forces (its bodies and the partners
ahead of it in order); `gather_forces` adds the windows body by body in block order. So
the order of every sum is fixed, however many threads share the blocks."""

import math

import numpy as np
from numba import njit

from benchtwin.sim.engine.bodies import FROM_CONTACTS
from benchtwin.sim.engine.compiled import INNER
from benchtwin.sim.engine.gathering import (
    S_CONTACTS,
    gather_pairs,
    gather_walls,
    scatter_pairs,
    scatter_walls,
)
from benchtwin.sim.engine.sleeping import CALM
from benchtwin.sim.engine.surfaces import nearest, shares_feature
from benchtwin.sim.engine.tiles import LANES, approach, laws, pair_geometry
from benchtwin.sim.engine.view import View

REACH = False
SHORT = 1.0 - 1e-6  # for rounding: `quiet` is kept in single precision


def reach(radius, modulus, row, table):
    """How far apart a pair that has touched still acts [m]; `kernels.build` binds the
    chosen laws' in its place."""
    return 0.0


def awake_pairs(first, last, s: View):
    """Numbers of the listed pairs first … last−1 of which one body at least is awake,
    into `s.awake` from `first` on; how many."""
    count = first
    for k in range(np.uint64(first), np.uint64(last)):
        s.awake[count] = k
        count += (
            s.calm[s.owner[s.pair_i[k]]] < CALM or s.calm[s.owner[s.pair_j[k]]] < CALM
        )
    return count - first


def touching_pairs(first, last, few, s: View, active):
    """Listed ball pairs first … last−1 that touch (or still act), into `active`;
    forgets those that have parted. Returns how many. few: so many pairs only, whose
    numbers stand in `s.awake` from `first` on; −1: all.

    Most listed pairs are far from touching. Measured once, a gap cannot close before
    the paths of both balls have grown by as much: until their sum reaches its
    `pair_quiet` the pair is not looked at. `s.ball` is flat, four numbers a ball."""
    ball, path, owner = s.ball, s.path, s.owner
    pair_i, pair_j = s.pair_i, s.pair_j
    touch, quiet = s.pair_touch, s.pair_quiet
    near = np.uint64(0)
    if few < 0:
        # an index that could be negative is checked at each use
        for k in range(np.uint64(first), np.uint64(last)):
            active[near] = k
            near += np.uint64(path[pair_i[k]] + path[pair_j[k]] >= quiet[k])
    else:
        for n in range(np.uint64(first), np.uint64(first + few)):
            k = s.awake[n]
            active[near] = k
            near += np.uint64(path[pair_i[k]] + path[pair_j[k]] >= quiet[k])
    count = 0
    for n in range(near):
        k = active[n]
        i, j = pair_i[k] * 4, pair_j[k] * 4
        dx = ball[i] - ball[j]
        dy = ball[i + 1] - ball[j + 1]
        dz = ball[i + 2] - ball[j + 2]
        both = ball[i + 3] + ball[j + 3]
        gap2 = dx * dx + dy * dy + dz * dz
        if gap2 < both * both:
            active[count] = k
            count += 1
            quiet[k] = -1.0
            continue
        if REACH and touch[k]:
            row = (
                s.material[owner[pair_i[k]]] * s.materials
                + s.material[owner[pair_j[k]]]
            )
            wide = both + reach(
                ball[i + 3] * ball[j + 3] / both, s.table[row, 0], row, s.table
            )
            if gap2 < wide * wide:
                active[count] = k
                count += 1
                quiet[k] = -1.0
                continue
        quiet[k] = (
            path[pair_i[k]] + path[pair_j[k]] + math.sqrt(gap2) - both * (1.0 + 1e-12)
        ) * SHORT
        if touch[k]:
            touch[k] = 0
            s.pair_memory[k, :] = 0.0
    return count


def touching_walls(first, last, look, s: View, active, meet):
    """Listed ball–primitive pairs first … last−1 that touch, into `active`, with normal
    and overlap in `meet`. Returns how many.

    A ball near an edge that several triangles of one wall share meets it once: of all
    primitives that share the nearest feature the nearest counts, the first listed among
    equals. A contact that a ball takes over from a neighbouring triangle of the same
    wall keeps its memory, so that a ball rolls over a tessellated plane as over a
    plane."""
    ball, owner = s.ball, s.owner
    wall_i, wall_p, prim_wall = s.wall_i, s.wall_p, s.prim_wall
    count = 0
    k = first
    while k < last:
        end = k + 1
        while (
            end < last
            and wall_i[end] == wall_i[k]
            and prim_wall[wall_p[end]] == prim_wall[wall_p[k]]
        ):
            end += 1
        start = count
        i = wall_i[k]
        if not look and s.calm[owner[i]] >= CALM:
            k = end
            continue
        x, y, z, r = ball[4 * i], ball[4 * i + 1], ball[4 * i + 2], ball[4 * i + 3]
        for c in range(k, end):
            p = wall_p[c]
            nx, ny, nz, distance, feature = nearest(s.prim_kind[p], s.prim[p], x, y, z)
            limit = r
            if REACH and s.wall_touch[c]:
                row = s.material[owner[i]] * s.materials + s.wall_material[prim_wall[p]]
                limit += reach(r, s.table[row, 0], row, s.table)
            if distance < limit:
                active[count] = c
                meet[count, 0] = nx
                meet[count, 1] = ny
                meet[count, 2] = nz
                meet[count, 3] = r - distance
                meet[count, 4] = feature
                count += 1
        if count - start > 1:
            count = _each_feature_once(start, count, active, meet, wall_p, s.corners)
        _forget_or_hand_over(k, end, start, count, active, s.wall_memory, s.wall_touch)
        k = end
    return count


@njit(**INNER)
def copy(into, row):
    """Copy a row into another of the same length."""
    for k in range(len(row)):
        into[k] = row[k]


def _each_feature_once(start, count, active, meet, wall_p, corners):
    kept = start
    for a in range(start, count):
        feature = int(meet[a, 4])
        good = True
        if feature > 0:
            for b in range(start, count):
                if b != a and shares_feature(
                    corners[wall_p[active[a]]], feature, corners[wall_p[active[b]]]
                ):
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


def contact_radius(k, meet, on_wall, s: View):
    """√(R* δ) of a listed ball on a wall [m], `meet` being where they touch, or of a
    listed pair of balls: a contact's stiffness is in proportion to it."""
    ball = s.ball
    if on_wall:
        return math.sqrt(max(meet[3], 0.0) * ball[4 * s.wall_i[k] + 3])
    i, j = 4 * s.pair_i[k], 4 * s.pair_j[k]
    dx = ball[i] - ball[j]
    dy = ball[i + 1] - ball[j + 1]
    dz = ball[i + 2] - ball[j + 2]
    overlap = ball[i + 3] + ball[j + 3] - math.sqrt(dx * dx + dy * dy + dz * dz)
    return math.sqrt(
        max(overlap, 0.0) * ball[i + 3] * ball[j + 3] / (ball[i + 3] + ball[j + 3])
    )


def shares(count, active, meet, on_wall, first, second, owner, s: View, share):
    """Each contact's share of the damping where several balls of one seed touch the
    same other seed or wall (`owner` of `second`).

    Springs side by side add up, S = Σ S_k, but dashpots γ √(S_k m) would add up to more
    than γ √(S m), and a seed that lands on k balls would rebound less. With m_k = m S_k
    / S they sum to exactly that: restitution then does not depend on the number of
    balls. One material pair."""
    a = 0
    while a < count:
        body, other = s.owner[first[active[a]]], owner[second[active[a]]]
        end = a + 1
        while (
            end < count
            and s.owner[first[active[end]]] == body
            and owner[second[active[end]]] == other
        ):
            end += 1
        if end == a + 1:
            share[a] = 1.0
        else:
            total = 0.0
            for c in range(a, end):
                share[c] = contact_radius(active[c], meet[c], on_wall, s)
                total += share[c]
            for c in range(a, end):
                share[c] /= max(total, 1e-300)
        a = end


def block_forces(b, dt, look, woken, account, s: View, scratch):
    """Forces of all contacts of block b, into its window; `s` is the kernel's view of
    the state (`view.View`). look: those between sleeping bodies too; woken: whether
    a body has just woken; account: whether to add up what contacts store."""
    P = scratch.tile
    active = scratch.active
    meet = scratch.meet
    share = scratch.share
    rows = scratch.rows
    early = scratch.early
    base = s.block_window[b] - s.block_body[b]
    s.window[
        s.block_window[b] * FROM_CONTACTS : s.block_window[b + 1] * FROM_CONTACTS
    ] = 0.0
    s.wall_push[b, :, :] = 0.0
    sums = s.sums[b]
    sums[:] = 0.0
    first, last = s.block_pair[b], s.block_pair[b + 1]
    if look:
        s.awakes[b] = -1  # who sleeps may change after this step
    elif s.awakes[b] < 0 or woken:
        s.awakes[b] = awake_pairs(first, last, s)
    pairs = touching_pairs(first, last, s.awakes[b], s, active)
    if s.shared:
        shares(pairs, active, meet, False, s.pair_i, s.pair_j, s.owner, s, share)
    first, last = s.block_wall[b], s.block_wall[b + 1]
    walls = touching_walls(first, last, look, s, active[pairs:], meet)
    if s.shared:
        i, p, of = s.wall_i, s.wall_p, s.prim_wall
        shares(walls, active[pairs:], meet, True, i, p, of, s, share[pairs:])
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
            gather_walls(
                P,
                s,
                active[at : at + count],
                share[at : at + count],
                meet[at - pairs :],
                rows,
            )
        approach(P, (count + 7) // 8 * 8, dt, early)
        # whole vectors; lanes beyond `count` hold leftovers that nobody reads
        laws(P, (count + 7) // 8 * 8, dt, s.pull, s.whole)
        if tile < tiles_of_pairs:
            scatter_pairs(P, s, active[at : at + count], base, sums, account)
        else:
            scatter_walls(
                P, s, active[at : at + count], base, s.wall_push[b], sums, account
            )


def gather_forces(c, s: View, fresh):
    """Contact forces on the bodies of block c: the windows of all blocks that reach
    them, added in block order, into `fresh`."""
    first, last = s.block_body[c], s.block_body[c + 1]
    for n in range(first, last):
        for k in range(FROM_CONTACTS):
            fresh[n - first, k] = 0.0
    for b in range(c + 1):
        shift = s.block_window[b] - s.block_body[b]
        end = min(last, s.block_body[b] + s.block_window[b + 1] - s.block_window[b])
        for n in range(first, end):
            for k in range(FROM_CONTACTS):
                fresh[n - first, k] += s.window[FROM_CONTACTS * (shift + n) + k]
