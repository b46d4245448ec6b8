"""Pieces of a rig as meshes: slabs and prisms with flat faces."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from benchtwin.sim.motion import Part
from benchtwin.sim.seed.surface import Mesh

if TYPE_CHECKING:
    import trimesh


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
    """A convex outline of points (x, z) [m], drawn out from y = front_m to back_m."""
    import trimesh

    corners = [(x, y, z) for x, z in outline for y in (front_m, back_m)]
    return Part(name, _shaded(trimesh.convex.convex_hull(corners)))


def ring(
    name: str,
    inside_m: float,
    outside_m: float,
    front_m: float,
    back_m: float,
    finish: str,
) -> Part:
    """A tube about the y axis between two radii, from y = front_m to back_m [m]."""
    import trimesh

    tube = trimesh.creation.annulus(inside_m, outside_m, back_m - front_m, sections=96)
    turned = tube.vertices[:, [0, 2, 1]] + [0.0, (front_m + back_m) / 2, 0.0]
    return Part(name, _shaded(trimesh.Trimesh(turned, tube.faces[:, ::-1])), finish)


def _shaded(mesh: "trimesh.Trimesh") -> Mesh:
    """With normals that change at edges and turn round what is curved."""
    smooth = mesh.smooth_shaded
    faces = np.array(smooth.faces, np.int32)
    return Mesh(np.array(smooth.vertices), faces, np.array(smooth.vertex_normals))
