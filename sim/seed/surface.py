"""Surfaces seen from the centre: how far out an ellipsoid and a union of balls reach in
a direction, and triangle meshes."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles: vertices (v, 3) [m], faces (f, 3) vertex numbers counter-clockwise
    from outside, unit normals (v, 3)."""

    vertices_m: Array
    faces: Array
    normals: Array


def directions(n: int) -> tuple[Array, Array]:
    """Evenly spread unit vectors (n, 3) by the golden angle, and their solid angles
    (n,) [sr], which are equal."""
    k = np.arange(n) + 0.5
    polar, turn = np.arccos(1.0 - 2.0 * k / n), np.pi * (1.0 + np.sqrt(5.0)) * k
    u = np.c_[np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)]
    return u, np.full(n, 4.0 * np.pi / n)


def ellipsoid_radius(u: Array, halves_m: Array) -> Array:
    """Distance from the centre to the ellipsoid with half axes (3,) [m] along unit
    directions u (n, 3): (n,) [m]."""
    return 1.0 / np.linalg.norm(u / halves_m, axis=1)


def union_radius(u: Array, centres_m: Array, radii_m: Array) -> Array:
    """Distance from the origin to the farthest point of the balls along unit directions
    u (n, 3): (n,) [m], 0 if none is met."""
    along = u @ centres_m.T
    inside = along**2 - np.sum(centres_m**2, axis=1) + radii_m**2
    far = np.where(inside >= 0.0, along + np.sqrt(np.maximum(inside, 0.0)), 0.0)
    return np.maximum(far.max(axis=1), 0.0)


def is_star_shaped(centres_m: Array, radii_m: Array, rays: int = 500) -> bool:
    """Whether every ray from the origin leaves the union of balls once only, as far as
    `rays` directions tell."""
    u, _ = directions(rays)
    along = u @ centres_m.T
    inside = along**2 - np.sum(centres_m**2, axis=1) + radii_m**2
    root = np.sqrt(np.maximum(inside, 0.0))
    near = np.where(inside > 0.0, along - root, np.inf)
    far = np.where(inside > 0.0, along + root, -np.inf)
    order = np.argsort(near, axis=1)
    near, far = np.take_along_axis(near, order, 1), np.take_along_axis(far, order, 1)
    reached = np.maximum.accumulate(
        np.concatenate([np.zeros((rays, 1)), far], axis=1), axis=1
    )[:, :-1]
    gap = (near > reached + 1e-12) & np.isfinite(near)
    return not gap.any() and bool((far.max(axis=1) > 0.0).all())


@lru_cache(maxsize=8)
def _unit_sphere(level: int) -> tuple[Array, Array]:
    """Icosahedron with every face cut in four `level` times: unit vertices and
    20·4^level faces."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=level)
    return np.array(ball.vertices), np.array(ball.faces, dtype=np.int32)


def ellipsoid_mesh(halves_m: Array, level: int = 2) -> Mesh:
    """Smooth mesh of 20·4^level faces about the origin, enlarged so that it encloses
    the ellipsoid's volume; level 0 to 5.

    Flat faces inside the curved surface would enclose 3.6 % (level 2) or 13 % (level 1)
    too little, and look as much smaller."""
    unit, faces = _unit_sphere(_checked(level))
    unit = unit * (4.0 * np.pi / 3.0 / enclosed_volume(unit, faces)) ** (1 / 3)
    normals = unit / halves_m
    return Mesh(
        unit * halves_m, faces, normals / np.linalg.norm(normals, axis=1)[:, None]
    )


def union_mesh(centres_m: Array, radii_m: Array, level: int = 2) -> Mesh:
    """Mesh of the union of balls; level 0 to 5.

    A union that every ray from the origin leaves once: 20·4^level faces, closed, with
    the surface of the outermost ball. Any other: each ball's own mesh of 20·4^level
    faces less the faces that lie wholly inside other balls; this looks right but is not
    closed."""
    unit, faces = _unit_sphere(_checked(level))
    if is_star_shaped(centres_m, radii_m):
        points = unit * union_radius(unit, centres_m, radii_m)[:, None]
        ball = np.argmin(
            np.linalg.norm(points[:, None] - centres_m, axis=2) - radii_m, axis=1
        )
        return Mesh(points, faces, (points - centres_m[ball]) / radii_m[ball][:, None])
    points, kept = [], []
    for i, (centre, radius) in enumerate(zip(centres_m, radii_m)):
        own = centre + radius * unit
        others = np.arange(len(radii_m)) != i
        hidden = (
            np.linalg.norm(own[:, None] - centres_m[others], axis=2) < radii_m[others]
        ).any(axis=1)
        kept.append(faces[~hidden[faces].all(axis=1)] + i * len(unit))
        points.append(own)
    return Mesh(np.vstack(points), np.vstack(kept), np.tile(unit, (len(radii_m), 1)))


def face_count(level: int) -> int:
    """Faces of a mesh of that level, 20·4^level; level 0 to 5."""
    return 20 * 4 ** _checked(level)


def crosses(points: Array, faces: Array) -> Array:
    """Of each face its normal times twice its area (f, 3)."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def area(points: Array, faces: Array) -> float:
    """Surface of a mesh [m²]."""
    return float(np.linalg.norm(crosses(points, faces), axis=1).sum() / 2.0)


def enclosed_volume(points: Array, faces: Array) -> float:
    """Volume inside a closed mesh by the divergence theorem, Σ a·(b×c)/6 [m3]."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def _checked(level: int) -> int:
    if not 0 <= level <= 5:
        raise ValueError(f"level = {level}: must be 0 to 5 (20 to 20,480 faces)")
    return level
