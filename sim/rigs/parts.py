"""Pieces of a rig as meshes: slabs and prisms with flat faces."""

from collections.abc import Sequence

import numpy as np

from benchtwin.sim.motion import Part
from benchtwin.sim.seed.surface import Mesh


def slab(name: str, low: Sequence[float], high: Sequence[float]) -> Part:
    """A cuboid from corner `low` to corner `high` [m]."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    return prism(name, [(x0, z0), (x1, z0), (x1, z1), (x0, z1)], y0, y1)


def prism(
    name: str,
    outline: Sequence[tuple[float, float]],
    front_m: float,
    back_m: float,
) -> Part:
    """A convex outline of points (x, z) [m], counter-clockwise as the camera sees it,
    drawn out from y = front_m to back_m."""
    flat = np.asarray(outline, float)
    n = len(flat)
    front, back = (
        np.column_stack([flat[:, 0], np.full(n, y), flat[:, 1]])
        for y in (front_m, back_m)
    )
    polygons = [front, back[::-1]]
    polygons += [
        np.array([front[(k + 1) % n], front[k], back[k], back[(k + 1) % n]])
        for k in range(n)
    ]
    vertices: list[np.ndarray] = []
    faces: list[tuple[int, int, int]] = []
    normals: list[np.ndarray] = []
    for polygon in polygons:  # faces share no vertices: edges stay sharp
        start = len(vertices)
        normal = np.cross(polygon[1] - polygon[0], polygon[2] - polygon[0])
        vertices += list(polygon)
        normals += [normal / np.linalg.norm(normal)] * len(polygon)
        faces += [(start, start + k, start + k + 1) for k in range(1, len(polygon) - 1)]
    mesh = Mesh(np.array(vertices), np.array(faces, np.int32), np.array(normals))
    return Part(name, mesh)


def ring(
    name: str,
    inside_m: float,
    outside_m: float,
    front_m: float,
    back_m: float,
    finish: str,
) -> Part:
    """A tube about the y axis between two radii, from y = front_m to back_m [m]."""
    pieces = 96
    turn = 2 * np.pi * np.arange(pieces + 1) / pieces
    vertices: list[np.ndarray] = []
    faces: list[np.ndarray] = []
    normals: list[np.ndarray] = []
    circles = {
        (r, y): np.column_stack(
            [r * np.cos(turn), np.full(pieces + 1, y), r * np.sin(turn)]
        )
        for r in (inside_m, outside_m)
        for y in (front_m, back_m)
    }
    out = np.column_stack([np.cos(turn), np.zeros(pieces + 1), np.sin(turn)])
    ahead = np.tile([0.0, -1.0, 0.0], (pieces + 1, 1))
    sheets = (
        ((inside_m, front_m), (outside_m, front_m), ahead),
        ((outside_m, front_m), (outside_m, back_m), out),
        ((outside_m, back_m), (inside_m, back_m), -ahead),
        ((inside_m, back_m), (inside_m, front_m), -out),
    )
    for one, other, facing in sheets:
        start = int(sum(map(len, vertices)))
        vertices += [circles[one], circles[other]]
        normals += [facing, facing]
        k = start + np.arange(pieces)
        faces += [
            np.column_stack([k, k + 1, k + pieces + 1]),
            np.column_stack([k + 1, k + pieces + 2, k + pieces + 1]),
        ]
    triangles = np.concatenate(faces).astype(np.int32)
    mesh = Mesh(np.concatenate(vertices), triangles, np.concatenate(normals))
    return Part(name, mesh, finish)
