"""Which balls are near which: bodies sorted into cells, half lists of ball pairs with a
skin, and the memory carried across.

A list stays good until a ball has moved half the skin. Making a new one also puts the
bodies into spatial order (cell by cell, the longest side of the bed outermost), which
keeps partners near each other in memory: measured 1.8–2.7 × on beds of 20,000."""

import math
from collections import namedtuple

import numpy as np

from benchtwin.sim.engine.bodies import BOUND, X
from benchtwin.sim.engine.surfaces import PLANE, TRIANGLE, nearest

# Bodies as they are searched, and the cells that they are sorted into.
Bodies = namedtuple("Bodies", "motion shape_of shape ball_start ball")
Grid = namedtuple("Grid", "size sides low strides axes starts")


def stencil(axes):
    """The 13 forward neighbours of a cell, as steps along the axes: those that come
    later in cell order (axes: outermost first)."""
    outer, middle, inner = axes[0], axes[1], axes[2]
    forward = np.empty((13, 3), np.int64)
    count = 0
    for a in range(2):
        for b in range(-1, 2):
            for c in range(-1, 2):
                if a > 0 or (a == 0 and (b > 0 or (b == 0 and c > 0))):
                    forward[count, outer] = a
                    forward[count, middle] = b
                    forward[count, inner] = c
                    count += 1
    return forward


def find_pairs(bodies, grid, skin, pair_i, pair_j, first_pair):
    """All ball pairs of different bodies nearer than the skin, bodies being in cell
    order; first_pair[n] is where body n's begin.

    Returns how many there are; only those that fit are written.
    """
    motion, shape_of, shape, ball_start, ball = bodies
    size, sides, low, strides, axes, starts = grid
    n = len(motion)
    room = len(pair_i)
    forward = stencil(axes)
    at = np.empty(3, np.int64)
    count = 0
    for a in range(n):
        first_pair[a] = count
        cell = 0
        for k in range(3):
            at[k] = min(int((motion[a, X + k] - low[k]) / size), sides[k] - 1)
            cell += at[k] * strides[k]
        for f in range(14):
            if f == 0:
                begin, end = a + 1, starts[cell + 1]
            else:
                inside, other = True, 0
                for k in range(3):
                    c = at[k] + forward[f - 1, k]
                    inside = inside and 0 <= c < sides[k]
                    other += c * strides[k]
                if not inside:
                    continue
                begin, end = starts[other], starts[other + 1]
            # an index that could be negative is checked at each use
            for b in range(np.uint64(begin), np.uint64(end)):
                dx = motion[a, X] - motion[b, X]
                dy = motion[a, X + 1] - motion[b, X + 1]
                dz = motion[a, X + 2] - motion[b, X + 2]
                near = shape[shape_of[a], BOUND] + shape[shape_of[b], BOUND] + skin
                if dx * dx + dy * dy + dz * dz >= near * near:
                    continue
                for i in range(np.uint64(ball_start[a]), np.uint64(ball_start[a + 1])):
                    for j in range(
                        np.uint64(ball_start[b]),
                        np.uint64(ball_start[b + np.uint64(1)]),
                    ):
                        x = ball[i, 0] - ball[j, 0]
                        y = ball[i, 1] - ball[j, 1]
                        z = ball[i, 2] - ball[j, 2]
                        near = ball[i, 3] + ball[j, 3] + skin
                        if x * x + y * y + z * z < near * near:
                            if count < room:
                                pair_i[count] = i
                                pair_j[count] = j
                            count += 1
    first_pair[n] = count
    return count


def find_walls(bodies, grid, skin, prim, prim_kind, moving, box, wall_i, wall_p):
    """All pairs of a ball and a primitive nearer than the skin, primitive by primitive;
    returns how many. Planes that move are listed with every ball: turning, they sweep
    any distance. box (3, 2): scratch."""
    motion, shape_of, shape, ball_start, ball = bodies
    size, sides, low, strides, _, starts = grid
    room, count = len(wall_i), 0
    widest = 0.0
    for s in range(len(shape)):
        widest = max(widest, shape[s, BOUND])
    for p in range(len(prim)):
        everywhere = prim_kind[p] == PLANE and moving[p]
        for k in range(3):
            box[k, 0], box[k, 1] = 0, sides[k] - 1
            if prim_kind[p] != PLANE:
                least, most = extent(prim_kind[p], prim[p], k)
                least, most = least - widest - skin, most + widest + skin
                box[k, 0] = max(0, int(max(math.floor((least - low[k]) / size), -1.0)))
                box[k, 1] = int(min(math.floor((most - low[k]) / size), sides[k] - 1.0))
        for cx in range(box[0, 0], box[0, 1] + 1):
            for cy in range(box[1, 0], box[1, 1] + 1):
                for cz in range(box[2, 0], box[2, 1] + 1):
                    c = cx * strides[0] + cy * strides[1] + cz * strides[2]
                    for a in range(starts[c], starts[c + 1]):
                        m = motion[a]
                        bound = shape[shape_of[a], BOUND] + skin
                        if (
                            not everywhere
                            and nearest(
                                prim_kind[p], prim[p], m[X], m[X + 1], m[X + 2]
                            )[3]
                            >= bound
                        ):
                            continue
                        for i in range(ball_start[a], ball_start[a + 1]):
                            d = nearest(
                                prim_kind[p],
                                prim[p],
                                ball[i, 0],
                                ball[i, 1],
                                ball[i, 2],
                            )[3]
                            if everywhere or d < ball[i, 3] + skin:
                                if count < room:
                                    wall_i[count] = i
                                    wall_p[count] = p
                                count += 1
    return count


def extent(kind, row, k):
    """Least and largest coordinate k of a primitive (a cylinder's by its axis and
    radius, generously)."""
    ends = (
        row[k],
        row[k] + row[3 + k],
        row[k] + row[6 + k],
        row[k] + row[3 + k] + row[6 + k],
    )
    if kind == TRIANGLE:
        return min(ends[0], ends[1], ends[2]), max(ends[0], ends[1], ends[2])
    return min(ends) - row[9], max(ends) + row[9]


def carry(
    old_first, old_second, old_touch, old_memory, first, second, directed, memory, touch
):
    """Memory of the old list's touching pairs into the new one. Pairs stand by
    permanent numbers, old ones in a bucket each of their first; `directed`: of their
    lower. Seen from the other side, directions change sign (the impact speed, column 3,
    and what laws along the normal keep, from column 7 on, do not)."""
    most = 0
    for k in range(len(old_first)):
        most = max(most, old_first[k], old_second[k])
    for k in range(len(first)):
        most = max(most, first[k], second[k])
    bucket, at = np.zeros(most + 2, np.int64), np.zeros(most + 1, np.int64)
    for k in range(len(old_first)):
        if old_touch[k]:
            a, b = old_first[k], old_second[k]
            bucket[(min(a, b) if directed else a) + 1] += 1
    for a in range(most + 1):
        bucket[a + 1] += bucket[a]
        at[a] = bucket[a]
    rows = np.empty(bucket[most + 1], np.int64)
    for k in range(len(old_first)):
        if old_touch[k]:
            a, b = old_first[k], old_second[k]
            lower = min(a, b) if directed else a
            rows[at[lower]] = k
            at[lower] += 1
    for k in range(len(first)):
        a, b = first[k], second[k]
        lower = min(a, b) if directed else a
        for c in range(bucket[lower], bucket[lower + 1]):
            r = rows[c]
            same = old_first[r] == a and old_second[r] == b
            if same or (directed and old_first[r] == b and old_second[r] == a):
                touch[k] = 1
                for m in range(memory.shape[1]):
                    kept = old_memory[r, m]
                    memory[k, m] = kept if same or m == 3 or m >= 7 else -kept
                break
