"""A closed triangle mesh as the shape of a seed: volume, centre and inertia by exact
integrals over what it encloses."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from benchtwin.sim.seed import forms
from benchtwin.sim.seed.solid import Solid, principal
from benchtwin.sim.seed.surface import Mesh, area, crosses, enclosed_volume

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Shape:
    """Vertices (v, 3) [m] and faces (f, 3), vertex numbers counter-clockwise from
    outside, of one closed surface in any frame.

    notes: what was done to a mesh that was read (holes closed, faces left out), a
    sentence each. Faces that all look inwards are turned. Raises ValueError for a
    surface that is not closed, encloses nothing, or has values that are not finite."""

    vertices_m: Array
    faces: Array
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        vertices = np.array(self.vertices_m, float).reshape(-1, 3)
        faces = np.array(self.faces, np.int64).reshape(-1, 3)
        if (
            not len(faces)
            or not np.isfinite(vertices).all()
            or faces.min() < 0
            or faces.max() >= len(vertices)
        ):
            raise ValueError(
                "vertices_m must be finite and faces must name three of them each"
            )
        if open_edges(faces):
            raise ValueError(
                f"the surface is not closed: {open_edges(faces)} edges do not lie"
                " between two faces that agree"
            )
        object.__setattr__(self, "vertices_m", vertices)
        object.__setattr__(self, "faces", faces)
        size = float(np.ptp(vertices, axis=0).max())
        if not abs(self.solid.volume_m3) > 1e-9 * size**3:
            raise ValueError("the surface encloses no volume")
        if self.solid.volume_m3 < 0:
            object.__setattr__(self, "faces", faces[:, ::-1].copy())
            self.__dict__.pop("solid")

    @classmethod
    def from_outline(cls, outline_m: Array, thickness_m: float) -> "Shape":
        """The body over an outline (n, 2) [m], x and y in order round it: z = ±T/2 √(1
        - ρ²), ρ the way out from the centre.

        The centre is the outline's centroid, ρ the fraction of the way to the outline:
        an ellipse gives the ellipsoid. V = 2/3 × area × T. ValueError for fewer than 8
        points, or an outline that a ray from the centre crosses twice."""
        return cls(*forms.over_outline(np.asarray(outline_m, float), thickness_m))

    @cached_property
    def solid(self) -> Solid:
        """Volume, centre and second moment by exact integrals over the mesh: of a
        tetrahedron from a point to each face."""
        origin = self.vertices_m.mean(axis=0)
        a, b, c = (self.vertices_m[self.faces[:, k]] - origin for k in range(3))
        # six times the tetrahedron's volume
        six = np.einsum("ij,ij->i", a, np.cross(b, c))
        volume, all_three = float(six.sum() / 6.0), a + b + c
        if volume == 0.0:
            return Solid(0.0, origin, np.zeros((3, 3)))
        centre = six @ all_three / 24.0 / volume
        second = (
            sum(np.einsum("i,ij,ik->jk", six, v, v) for v in (a, b, c, all_three))
            / 120.0
        )
        return Solid(
            volume, origin + centre, second - volume * np.outer(centre, centre)
        )

    @property
    def volume_m3(self) -> float:
        return self.solid.volume_m3

    @property
    def mean_radius_m(self) -> float:
        """Radius of the ball of the same volume [m]."""
        return float((3.0 * self.volume_m3 / (4.0 * np.pi)) ** (1 / 3))

    @property
    def area_m2(self) -> float:
        """Surface [m²]."""
        return area(self.vertices_m, self.faces)

    def moved(self, turn: Array, shift_m: Array) -> "Shape":
        """The shape turned by a rotation matrix (3, 3) and then shifted (3,) [m]."""
        return replace(
            self, vertices_m=self.vertices_m @ np.asarray(turn, float).T + shift_m
        )

    def scaled(self, factors: float | Array) -> "Shape":
        """The shape times one factor, or one each along x, y, z (3,), all positive."""
        scale = np.broadcast_to(np.asarray(factors, float), 3)
        if not (scale > 0).all():
            raise ValueError(f"factors = {factors}: must be positive")
        return replace(self, vertices_m=self.vertices_m * scale)

    def principal(self) -> tuple["Shape", Array, Array]:
        """The shape about its centre of mass along its principal axes, the longest
        extent along x, the shortest along z.

        Also the axes (3, 3) and the origin (3,): a point p of the given frame is at (p
        - origin) @ axes."""
        axes = principal(self.solid.inertia(1.0))[1]
        local = (self.vertices_m - self.solid.centre_m) @ axes
        extent = np.ptp(local, axis=0)
        # ties stay as they were given
        order = np.lexsort((np.arange(3), -np.round(extent / extent.max(), 6)))
        axes = axes[:, order]
        if np.linalg.det(axes) < 0:
            axes[:, 2] *= -1.0
        vertices_m = (self.vertices_m - self.solid.centre_m) @ axes
        return (replace(self, vertices_m=vertices_m), axes, self.solid.centre_m)

    @property
    def dimensions_m(self) -> Array:
        """Extent along each principal axis, longest first (3,) [m]: length, width,
        thickness."""
        return np.ptp(self.principal()[0].vertices_m, axis=0)

    def points(self, count: int) -> tuple[Array, Array]:
        """`count` points, each for the same share of the surface, and the normals of
        their faces: (count, 3) [m], (count, 3)."""
        normals = crosses(self.vertices_m, self.faces)
        areas = np.linalg.norm(normals, axis=1)
        share = np.cumsum(areas)
        face = np.searchsorted(share, (np.arange(count) + 0.5) / count * share[-1])
        a, b, c = (self.vertices_m[self.faces[face, k]] for k in range(3))
        s, t = np.mod(
            0.5 + np.outer([0.7548776662466927, 0.5698402909980532], np.arange(count)),
            1.0,
        )  # R2 sequence
        root = np.sqrt(s)[:, None]
        at = (1 - root) * a + root * (1 - t[:, None]) * b + root * t[:, None] * c
        return at, normals[face] / areas[face][:, None]

    def mesh(self, most_faces: int) -> Mesh:
        """What is drawn: the surface in at most so many faces where they do, with
        smooth normals; as it is if it has fewer."""
        vertices, faces = self.vertices_m, self.faces
        if len(faces) > most_faces:
            vertices, faces = thinned(vertices, faces, most_faces)
        normals, of_faces = np.zeros_like(vertices), crosses(vertices, faces)
        for k in range(3):
            np.add.at(normals, faces[:, k], of_faces)
        lengths = np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
        return Mesh(vertices, faces.astype(np.int32), normals / lengths)


def open_edges(faces: Array) -> int:
    """How many edges do not lie between exactly two faces that run along them in
    opposite directions."""
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    most = int(faces.max()) + 1
    there = np.unique(ends @ [most, 1], return_counts=True)
    back = np.unique(ends @ [1, most], return_counts=True)
    once = there[0][there[1] == 1], back[0][back[1] == 1]
    return len(np.setxor1d(*once)) + int((there[1] > 1).sum())


def thinned(vertices_m: Array, faces: Array, most_faces: int) -> tuple[Array, Array]:
    """A mesh of about `most_faces` faces by quadric error collapse (Garland & Heckbert
    1997), of the same volume."""
    import fast_simplification

    centre, size = vertices_m.mean(axis=0), float(np.ptp(vertices_m, axis=0).max())
    share = 1.0 - most_faces / len(faces)
    points, kept = fast_simplification.simplify(
        ((vertices_m - centre) / size).astype(np.float32), faces.astype(np.int32), share
    )
    points, kept = points.astype(float) * size, np.asarray(kept, np.int64)
    before, after = (
        enclosed_volume(v, f) for v, f in ((vertices_m - centre, faces), (points, kept))
    )
    return centre + points * (before / after) ** (1 / 3), kept
