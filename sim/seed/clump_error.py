"""How far a clump of balls is from the shape that it stands for: surface, volume,
moments of inertia."""

from dataclasses import dataclass

import numpy as np

from benchtwin.sim.seed.shape import Shape
from benchtwin.sim.seed.solid import union_of_balls

Array = np.ndarray
CHECKED_POINTS = 4000  # of the surface, where the error is taken


@dataclass(frozen=True, eq=False)
class ClumpError:
    """How far a clump's surface and solid are from the shape's, all without dimension.

    surface_rms, surface_max: distance between the surfaces over the shape's area, over
    its mean radius; surface_mean: positive where the balls stand out. Where they do it
    is the way out along the shape's normal, elsewhere the shortest way to a ball.
    volume: of the union over the shape's, less 1; moments (3,): principal moments
    likewise, in the shape's axes; centre: distance of the centres of mass over the mean
    radius. The last three are what is put right by giving the seed the shape's own."""

    surface_rms: float
    surface_mean: float
    surface_max: float
    volume: float
    moments: Array
    centre: float


def clump_error(shape: Shape, centres_m: Array, radii_m: Array) -> ClumpError:
    """A clump (n, 3), (n,) [m] in the shape's frame against the shape."""
    points, normals = shape.points(CHECKED_POINTS)
    gap = -surface_gap(points, normals, centres_m, radii_m) / shape.mean_radius_m
    balls, whole = union_of_balls(centres_m, radii_m), shape.solid
    axes = shape.principal()[1]
    moments = [np.diag(axes.T @ body.inertia(1.0) @ axes) for body in (balls, whole)]
    return ClumpError(
        surface_rms=float(np.sqrt(np.mean(gap**2))),
        surface_mean=float(gap.mean()),
        surface_max=float(np.abs(gap).max()),
        volume=balls.volume_m3 / whole.volume_m3 - 1.0,
        moments=moments[0] / moments[1] - 1.0,
        centre=float(np.linalg.norm(balls.centre_m - whole.centre_m))
        / shape.mean_radius_m,
    )


def surface_gap(points: Array, normals: Array, centres: Array, radii: Array) -> Array:
    """How far points (k, 3) lie outside the balls; inside, minus the way out along
    their normals (k, 3), through ball after ball."""
    outside = (np.linalg.norm(points[:, None] - centres, axis=2) - radii).min(axis=1)
    out = np.zeros(len(points))
    inside = np.flatnonzero(outside < 0.0)
    offset = points[inside][:, None] - centres
    along = np.einsum("kij,kj->ki", offset, normals[inside])
    root = along**2 - np.sum(offset**2, axis=2) + radii**2
    enter = np.where(root > 0, -along - np.sqrt(np.maximum(root, 0)), np.inf)
    leave = np.where(root > 0, -along + np.sqrt(np.maximum(root, 0)), -np.inf)
    way = np.zeros(len(inside))
    for _ in range(len(radii)):
        further = np.where(enter <= way[:, None] + 1e-12, leave, -np.inf).max(axis=1)
        way = np.maximum(way, further)
    out[inside] = way
    return np.where(outside < 0.0, -out, outside)
