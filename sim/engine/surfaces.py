"""Where a ball meets a wall: nearest points on planes, parallelograms, cylinders,
triangles and balls; and how moving walls move.

A wall is one or more primitives, a row of numbers each: origin p (3), vectors a (3) and
b (3), radius. plane: p a point, a the unit normal (solid behind it). parallelogram and
triangle: p a corner, a and b its edges from there. cylinder: p the middle of one end, a
the axis to the other end, radius; a thin shell, felt from inside and outside. ball: p
its centre, radius; solid."""

import math

from benchtwin.sim.engine.view import View

PLANE, PARALLELOGRAM, CYLINDER, TRIANGLE, BALL = range(5)
ROW = 10
# features of a triangle: face 0, edges 1–3 (from corner 0, 1, 2 onwards), corners 4–6
FACE = 0
EDGE = 1
VERTEX = 4


def nearest(kind, row, x, y, z):
    """Nearest point of one primitive to a ball's centre: unit normal (3) towards the
    ball, distance, feature.

    Distances are negative behind a plane and inside a ball; all others are felt from
    both sides.
    """
    dx, dy, dz = x - row[0], y - row[1], z - row[2]
    if kind == PLANE:
        return row[3], row[4], row[5], dx * row[3] + dy * row[4] + dz * row[5], FACE
    feature = FACE
    if kind == CYLINDER:
        px, py, pz = _on_cylinder(row, dx, dy, dz)
    elif kind == PARALLELOGRAM:
        px, py, pz = _on_parallelogram(row, dx, dy, dz)
    elif kind == BALL:
        px, py, pz = 0.0, 0.0, 0.0
    else:
        px, py, pz, feature = _on_triangle(row, dx, dy, dz)
    nx, ny, nz = dx - px, dy - py, dz - pz
    distance = math.sqrt(nx * nx + ny * ny + nz * nz)
    # the centre lies in the wall: any direction is as good; the overlap watch stops the
    # run
    if distance < 1e-300:
        return 0.0, 0.0, 1.0, 0.0, feature
    beyond = distance - row[9] if kind == BALL else distance
    return nx / distance, ny / distance, nz / distance, beyond, feature


def _on_cylinder(row, dx, dy, dz):
    ax, ay, az = row[3], row[4], row[5]
    length2 = ax * ax + ay * ay + az * az
    s = min(max((dx * ax + dy * ay + dz * az) / length2, 0.0), 1.0)
    along = (dx * ax + dy * ay + dz * az) / length2
    rx, ry, rz = dx - along * ax, dy - along * ay, dz - along * az
    r = math.sqrt(rx * rx + ry * ry + rz * rz)
    k = row[9] / max(r, 1e-300)
    return s * ax + k * rx, s * ay + k * ry, s * az + k * rz


def _on_parallelogram(row, dx, dy, dz):
    """Exact for rectangles, which is what `walls.Rectangle` makes."""
    ax, ay, az, bx, by, bz = row[3], row[4], row[5], row[6], row[7], row[8]
    u = min(
        max((dx * ax + dy * ay + dz * az) / (ax * ax + ay * ay + az * az), 0.0), 1.0
    )
    v = min(
        max((dx * bx + dy * by + dz * bz) / (bx * bx + by * by + bz * bz), 0.0), 1.0
    )
    return u * ax + v * bx, u * ay + v * by, u * az + v * bz


def _on_triangle(row, dx, dy, dz):
    """Ericson (2005), Real-Time Collision Detection, section 5.1.5, keeping which
    corner, edge or face it was."""
    ax, ay, az, bx, by, bz = row[3], row[4], row[5], row[6], row[7], row[8]
    d1 = ax * dx + ay * dy + az * dz
    d2 = bx * dx + by * dy + bz * dz
    if d1 <= 0.0 and d2 <= 0.0:
        return 0.0, 0.0, 0.0, VERTEX
    d3 = d1 - (ax * ax + ay * ay + az * az)
    d4 = d2 - (ax * bx + ay * by + az * bz)
    if d3 >= 0.0 and d4 <= d3:
        return ax, ay, az, VERTEX + 1
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        v = d1 / (d1 - d3)
        return v * ax, v * ay, v * az, EDGE
    d5 = d1 - (ax * bx + ay * by + az * bz)
    d6 = d2 - (bx * bx + by * by + bz * bz)
    if d6 >= 0.0 and d5 <= d6:
        return bx, by, bz, VERTEX + 2
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        w = d2 / (d2 - d6)
        return w * bx, w * by, w * bz, EDGE + 2
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return ax + w * (bx - ax), ay + w * (by - ay), az + w * (bz - az), EDGE + 1
    scale = 1.0 / (va + vb + vc)
    v, w = vb * scale, vc * scale
    return v * ax + w * bx, v * ay + w * by, v * az + w * bz, FACE


def shares_feature(corners, feature, others):
    """Whether the triangle with corner numbers `others` contains the given feature of
    the triangle `corners`."""
    if feature >= VERTEX:
        first, second = corners[feature - VERTEX], corners[feature - VERTEX]
    elif feature >= EDGE:
        first, second = corners[feature - EDGE], corners[(feature - EDGE + 1) % 3]
    else:
        return False
    has_first = others[0] == first or others[1] == first or others[2] == first
    has_second = others[0] == second or others[1] == second or others[2] == second
    return has_first and has_second


SLIDE, TURN = 0, 1


def motion(number, t, numbers):
    """(value, rate) of the chosen motion law of that number; `kernels.build` binds the
    chosen ones in its place."""
    return 0.0, 0.0


def place_walls(t, view: View):
    """Put every moving wall where it is at time t: rows of `prim` from those of
    `prim_rest`, and its `twist` (velocity at the world's origin, angular velocity).
    `moves`: wall, SLIDE or TURN, direction (3), pivot (3), number of the law; a wall's
    moves apply one after the other. `wall_way[0]` becomes the farthest that a point of
    a wall has moved from `prim_ref`, where it was when the neighbour lists were
    made."""
    moves, prim, twist = view.moves, view.prim, view.twist
    if len(moves) == 0:
        return
    for w in range(len(twist)):
        twist[w, :] = 0.0
    for k in range(len(prim)):
        for c in range(ROW):
            prim[k, c] = view.prim_rest[k, c]
    for m in range(len(moves)):
        wall = int(moves[m, 0])
        value, rate = motion(int(moves[m, 8]), t, view.move_numbers[m])
        ux, uy, uz = moves[m, 2], moves[m, 3], moves[m, 4]
        tw = twist[wall]
        if moves[m, 1] == SLIDE:
            for k in range(len(prim)):
                if view.prim_wall[k] == wall:
                    prim[k, 0] += value * ux
                    prim[k, 1] += value * uy
                    prim[k, 2] += value * uz
            # The twist so far, of material points now shifted by d: v(p) = v0 + w × (p
            # − d).
            tw[0] += rate * ux - (tw[4] * uz - tw[5] * uy) * value
            tw[1] += rate * uy - (tw[5] * ux - tw[3] * uz) * value
            tw[2] += rate * uz - (tw[3] * uy - tw[4] * ux) * value
            continue
        c, s = math.cos(value), math.sin(value)
        px, py, pz = moves[m, 5], moves[m, 6], moves[m, 7]
        for k in range(len(prim)):
            if view.prim_wall[k] == wall:
                row = prim[k]
                x, y, z = rotate(
                    ux, uy, uz, c, s, row[0] - px, row[1] - py, row[2] - pz
                )
                row[0], row[1], row[2] = x + px, y + py, z + pz
                row[3], row[4], row[5] = rotate(
                    ux, uy, uz, c, s, row[3], row[4], row[5]
                )
                row[6], row[7], row[8] = rotate(
                    ux, uy, uz, c, s, row[6], row[7], row[8]
                )
        # v(p) = Q v_before(p_before) + rate u × (p − pivot), p_before = Qᵀ (p − pivot)
        # + pivot.
        vx = tw[0] + tw[4] * pz - tw[5] * py
        vy = tw[1] + tw[5] * px - tw[3] * pz
        vz = tw[2] + tw[3] * py - tw[4] * px
        vx, vy, vz = rotate(ux, uy, uz, c, s, vx, vy, vz)  # at the pivot
        wx, wy, wz = rotate(ux, uy, uz, c, s, tw[3], tw[4], tw[5])
        wx, wy, wz = wx + rate * ux, wy + rate * uy, wz + rate * uz
        tw[0] = vx - (wy * pz - wz * py)
        tw[1] = vy - (wz * px - wx * pz)
        tw[2] = vz - (wx * py - wy * px)
        tw[3], tw[4], tw[5] = wx, wy, wz
    view.wall_way[0] = 0.0
    for k in range(len(prim)):
        # a plane that moves is listed with every ball, however far
        if view.prim_kind[k] != PLANE:
            view.wall_way[0] = max(view.wall_way[0], moved(prim[k], view.prim_ref[k]))


def moved(row, ref):
    """How far a point of a primitive has moved at most: its corners, and for a cylinder
    its rim."""
    way2 = 0.0
    for a in range(2):
        for b in range(2):
            x = row[0] - ref[0] + a * (row[3] - ref[3]) + b * (row[6] - ref[6])
            y = row[1] - ref[1] + a * (row[4] - ref[4]) + b * (row[7] - ref[7])
            z = row[2] - ref[2] + a * (row[5] - ref[5]) + b * (row[8] - ref[8])
            way2 = max(way2, x * x + y * y + z * z)
    rim = 0.0
    length2 = row[3] * row[3] + row[4] * row[4] + row[5] * row[5]
    if row[9] > 0.0 and length2 > 0.0:
        dx, dy, dz = row[3] - ref[3], row[4] - ref[4], row[5] - ref[5]
        rim = row[9] * math.sqrt((dx * dx + dy * dy + dz * dz) / length2)
    return math.sqrt(way2) + rim


def rotate(ux, uy, uz, c, s, x, y, z):
    """Vector turned about the unit axis u by the angle with cosine c and sine s
    (Rodrigues)."""
    d = (ux * x + uy * y + uz * z) * (1.0 - c)
    return (
        x * c + (uy * z - uz * y) * s + ux * d,
        y * c + (uz * x - ux * z) * s + uy * d,
        z * c + (ux * y - uy * x) * s + uz * d,
    )
