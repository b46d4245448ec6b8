"""Meshes of seeds for drawing: their level of detail, and the scale that keeps the true
silhouette."""

import numpy as np

from benchtwin.sim.seed import Seed
from benchtwin.sim.seed.surface import Mesh, area


def level_for(radius_px: float, seeds: int) -> int:
    """Subdivision level (2 to 4) for seeds of `radius_px`: flat faces miss the outline
    by radius·δ²/8 at most, δ an edge's angle.

    Below 0.1 px is fine enough; of more than 100 seeds level 3 is, 0.2 % of the radius:
    their number counts, not each outline."""
    finest = 4 if seeds <= 100 else 3
    levels = range(2, finest)
    enough = (k for k in levels if radius_px * (1.1 / 2**k) ** 2 / 8.0 < 0.1)
    return next(enough, finest)


def silhouette_true(seed: Seed, level: int, of: str) -> Mesh:
    """The seed's mesh, scaled so that its mean silhouette is the seed's: by Cauchy's
    theorem a quarter of its surface.

    A seed that stands for a shape is drawn as that shape, whatever `of` says: that is
    what is photographed."""
    if seed.shape is not None:
        mesh = seed.mesh(level)
        larger = np.sqrt(seed.shape.area_m2 / area(mesh.vertices_m, mesh.faces))
        return Mesh(mesh.vertices_m * larger, mesh.faces, mesh.normals)
    mesh, exact = seed.mesh(level, of=of), seed.mesh(5, of=of)
    scale = np.sqrt(
        area(exact.vertices_m, exact.faces) / area(mesh.vertices_m, mesh.faces)
    )
    normals = mesh.normals
    # lit as the smooth seed that the balls stand for: their seams are no part of a bean
    if seed.dimensions_m is not None:
        normals = mesh.vertices_m / seed.dimensions_m**2
        normals = normals / np.linalg.norm(normals, axis=1)[:, None]
    return Mesh(mesh.vertices_m * scale, mesh.faces, normals)


def flat(mesh: Mesh) -> Mesh:
    """Give every face its own corners and normal, so that edges are drawn sharp."""
    corners = mesh.vertices_m[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-30)[:, None]
    triangles = np.arange(3 * len(corners)).reshape(-1, 3)
    return Mesh(corners.reshape(-1, 3), triangles, np.repeat(normals, 3, axis=0))
