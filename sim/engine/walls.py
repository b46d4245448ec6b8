"""Walls as people describe them: planes, rectangles, cylinders, triangle meshes, balls;
fixed, sliding or turning."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchtwin.sim.engine.surfaces import (
    BALL,
    CYLINDER,
    PARALLELOGRAM,
    PLANE,
    ROW,
    SLIDE,
    TRIANGLE,
    TURN,
)
from benchtwin.sim.laws.law import Chosen, Law
from benchtwin.sim.material import Material

Vector = tuple[float, float, float]
# kinds (n), rows (n, ROW), corners (n, 3)
Primitives = tuple[list[int], np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Slide:
    """Translation along `direction` (made a unit vector) by the value [m] of a law of
    kind "motion"."""

    law: Chosen
    direction: Vector


@dataclass(frozen=True)
class Turn:
    """Rotation about the axis through `pivot` along `axis`, by the value [rad] of a law
    of kind "motion"; right-handed."""

    law: Chosen
    pivot: Vector
    axis: Vector


@dataclass(frozen=True)
class Plane:
    """Infinite plane; seeds are on the side to which `normal` points. Solid behind: a
    ball is always pushed that way."""

    name: str
    material: Material
    point: Vector = (0.0, 0.0, 0.0)
    normal: Vector = (0.0, 0.0, 1.0)
    moves: tuple[Slide | Turn, ...] = ()

    def primitives(self) -> Primitives:
        row = _rows(self.point, unit("normal", self.normal), (0.0, 0.0, 0.0))
        return ([PLANE], row, np.full((1, 3), -1))


@dataclass(frozen=True)
class Rectangle:
    """Thin rectangle from `corner` along the perpendicular edges `a` and `b`, felt on
    both sides and at its edges.

    Rectangles know nothing of each other: a ball over the seam of two that lie in one
    plane is pushed by both. Make such a floor of one rectangle, or of a mesh."""

    name: str
    material: Material
    corner: Vector
    a: Vector
    b: Vector
    moves: tuple[Slide | Turn, ...] = ()

    def primitives(self) -> Primitives:
        a, b = np.asarray(self.a, float), np.asarray(self.b, float)
        if not abs(a @ b) < 1e-9 * np.linalg.norm(a) * np.linalg.norm(b):
            raise ValueError(
                f"wall {self.name!r}: edges a = {self.a} and b = {self.b} must be"
                " perpendicular and longer than 0"
            )
        return [PARALLELOGRAM], _rows(self.corner, a, b), np.full((1, 3), -1)


@dataclass(frozen=True)
class Cylinder:
    """Thin open tube of a radius about the axis from `start` to `end`, felt from
    inside, outside and at its rims."""

    name: str
    material: Material
    start: Vector
    end: Vector
    radius: float
    moves: tuple[Slide | Turn, ...] = ()

    def primitives(self) -> Primitives:
        axis = np.asarray(self.end, float) - np.asarray(self.start, float)
        if not (self.radius > 0 and np.linalg.norm(axis) > 0):
            raise ValueError(
                f"wall {self.name!r}: radius = {self.radius} m and the axis' length"
                " must be > 0"
            )
        rows = _rows(self.start, axis, (0.0, 0.0, 0.0))
        rows[:, 9] = self.radius
        return [CYLINDER], rows, np.full((1, 3), -1)


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles, felt from both sides: vertices (n, 3) [m] and faces (m, 3). Triangles
    that share a vertex must share its number."""

    name: str
    material: Material
    vertices: np.ndarray = field(repr=False)
    faces: np.ndarray = field(repr=False)
    moves: tuple[Slide | Turn, ...] = ()

    @classmethod
    def from_file(
        cls,
        path: Path | str,
        name: str,
        material: Material,
        *,
        scale: float = 1.0,
        moves: tuple[Slide | Turn, ...] = (),
    ) -> "Mesh":
        """Read STL, PLY, OBJ … through trimesh, joining vertices that coincide; `scale`
        1e-3 for files in millimetres."""
        import trimesh

        mesh = trimesh.load(path, force="mesh")
        return cls.from_trimesh(mesh, name, material, scale=scale, moves=moves)

    @classmethod
    def from_trimesh(
        cls,
        mesh: Any,
        name: str,
        material: Material,
        *,
        scale: float = 1.0,
        moves: tuple[Slide | Turn, ...] = (),
    ) -> "Mesh":
        """The surface of a trimesh."""
        mesh = mesh.copy()
        mesh.merge_vertices(merge_tex=True, merge_norm=True)
        mesh.update_faces(mesh.nondegenerate_faces())
        vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
        return cls(name, material, vertices * scale, faces, moves)

    def primitives(self) -> Primitives:
        vertices, faces = np.asarray(self.vertices, float), np.asarray(self.faces)
        if faces.ndim != 2 or faces.shape[1] != 3 or not len(faces):
            raise ValueError(
                f"wall {self.name!r}: faces must be (m, 3) with m ≥ 1, not"
                f" {faces.shape}"
            )
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise ValueError(
                f"wall {self.name!r}: faces name vertices outside 0 …"
                f" {len(vertices) - 1}"
            )
        p, q, r = (vertices[faces[:, k]] for k in range(3))
        area = 0.5 * np.linalg.norm(np.cross(q - p, r - p), axis=1)
        if not np.all(area > 0):  # NaN vertices fail here too
            raise ValueError(
                f"wall {self.name!r}: triangle {int(np.argmin(np.nan_to_num(area)))}"
                " has no area"
            )
        return [TRIANGLE] * len(faces), _rows(p, q - p, r - p), faces


@dataclass(frozen=True, eq=False)
class Balls:
    """Solid balls, as of a seed that is glued down: centres (n, 3) [m] and radii (n,)
    [m]. Those of one wall share the damping where one seed touches several of them, as
    balls of one seed do."""

    name: str
    material: Material
    centres: np.ndarray = field(repr=False)
    radii: np.ndarray = field(repr=False)
    moves: tuple[Slide | Turn, ...] = ()

    def primitives(self) -> Primitives:
        centres, radii = np.asarray(self.centres, float), np.asarray(self.radii, float)
        if centres.shape != (len(radii), 3) or not len(radii) or not (radii > 0).all():
            raise ValueError(
                f"wall {self.name!r}: centres {centres.shape} and radii {radii.shape}"
                " must be (n, 3) and (n,), radii > 0"
            )
        rows = _rows(centres, np.zeros_like(centres), np.zeros_like(centres))
        rows[:, 9] = radii
        return [BALL] * len(radii), rows, np.full((len(radii), 3), -1)


Wall = Plane | Rectangle | Cylinder | Mesh | Balls


def box(
    name: str, material: Material, low: Vector, high: Vector, *, lid: bool = False
) -> tuple[Rectangle, ...]:
    """Floor and four sides of a box, a rectangle each: `name`-floor, -left, -right,
    -front, -back, and -lid if asked for."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    if not (x1 > x0 and y1 > y0 and z1 > z0):
        raise ValueError(
            f"box {name!r}: high = {high} must exceed low = {low} along every axis"
        )
    x, y, z = (x1 - x0, 0.0, 0.0), (0.0, y1 - y0, 0.0), (0.0, 0.0, z1 - z0)
    sides = [
        ("floor", low, x, y),
        ("left", low, y, z),
        ("right", (x1, y0, z0), y, z),
        ("front", low, x, z),
        ("back", (x0, y1, z0), x, z),
    ]
    if lid:
        sides.append(("lid", (x0, y0, z1), x, y))
    return tuple(
        Rectangle(f"{name}-{side}", material, corner, a, b)
        for side, corner, a, b in sides
    )


def unit(what: str, vector: Vector) -> np.ndarray:
    """The vector over its length; ValueError names it as `what` where it has none."""
    v = np.asarray(vector, float)
    length = np.linalg.norm(v)
    if v.shape != (3,) or not (np.isfinite(length) and length > 0):
        raise ValueError(f"{what} = {vector} must be three finite numbers, not all 0")
    return v / length


def _rows(p, a, b) -> np.ndarray:
    p, a, b = (np.atleast_2d(np.asarray(v, float)) for v in (p, a, b))
    rows = np.zeros((len(p), ROW))
    rows[:, 0:3], rows[:, 3:6], rows[:, 6:9] = p, a, b
    if not np.isfinite(rows).all():
        raise ValueError("a wall's coordinates must be finite")
    return rows


@dataclass(frozen=True, eq=False)
class WallTables:
    """All walls as the kernels see them: a row a primitive, a row a move."""

    prim: np.ndarray
    kind: np.ndarray
    wall: np.ndarray
    corners: np.ndarray
    moves: np.ndarray
    move_numbers: np.ndarray
    motion_laws: tuple[Law, ...]  # each once; the last column of `moves` says which
    moving: np.ndarray


def tabulate(walls: tuple[Wall, ...]) -> WallTables:
    """Tables of all walls' primitives and moves; ValueError names the wall that is
    wrong."""
    prim, kind, owner, corners = [np.empty((0, ROW))], [], [], [np.empty((0, 3), int)]
    moves, numbers, laws = [], [], []
    vertices = 0
    for w, wall in enumerate(walls):
        kinds, rows, faces = wall.primitives()
        prim.append(rows)
        kind += kinds
        owner += [w] * len(kinds)
        corners.append(np.where(faces >= 0, faces + vertices, -1))
        vertices += max(int(faces.max()) + 1, 0)
        for move in wall.moves:
            if move.law.law.kind != "motion":
                raise ValueError(
                    f"wall {wall.name!r}: law {move.law.law.name!r} is of kind"
                    f" {move.law.law.kind!r}, not 'motion'"
                )
            along, pivot = (
                (move.direction, (0.0, 0.0, 0.0))
                if isinstance(move, Slide)
                else (move.axis, move.pivot)
            )
            direction = unit(f"wall {wall.name!r}: direction", along)
            law = move.law.law
            if law not in laws:
                laws.append(law)
            how = SLIDE if isinstance(move, Slide) else TURN
            moves.append([w, how, *direction, *pivot, laws.index(law)])
            numbers.append(move.law.numbers)
    width = max([len(row) for row in numbers], default=0)
    moving = {int(row[0]) for row in moves}
    return WallTables(
        prim=np.concatenate(prim),
        kind=np.array(kind, np.int64),
        wall=np.array(owner, np.int64),
        corners=np.concatenate(corners).astype(np.int64),
        moves=np.array(moves, float).reshape(len(moves), 9),
        move_numbers=np.array(
            [[*row, *[0.0] * (width - len(row))] for row in numbers], float
        ).reshape(len(moves), width),
        motion_laws=tuple(laws),
        moving=np.array([w in moving for w in owner], bool),
    )
