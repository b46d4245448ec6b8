"""The meshes that are drawn: cut finely enough for their size in the picture, and as large as their silhouette is in truth."""

import numpy as np

from sim.seed import Seed
from sim.seed.surface import Mesh

Array = np.ndarray


def level_for(radius_px: float) -> int:
    """How finely a seed is cut: flat faces leave its outline by radius·δ²/8 at most, δ the angle an edge subtends."""
    for level in (2, 3, 4):
        if radius_px * (1.1 / 2**level) ** 2 / 8.0 < 0.1:
            return level
    return 4 if radius_px < 60.0 else 3


def silhouette_true(seed: Seed, level: int, of: str) -> Mesh:
    """The seed's mesh, scaled so that its mean silhouette is the seed's: by Cauchy's theorem a quarter of its surface."""
    mesh, exact = seed.mesh(level, of=of), seed.mesh(5, of=of)
    scale = np.sqrt(area(exact) / area(mesh))
    return Mesh(mesh.vertices_m * scale, mesh.faces, mesh.normals)


def area(mesh: Mesh) -> float:
    """Surface of a mesh [m²]."""
    a, b, c = (mesh.vertices_m[mesh.faces[:, i]] for i in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def flat(mesh: Mesh) -> Mesh:
    """Every face with corners and a normal of its own, so that edges are sharp."""
    corners = mesh.vertices_m[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-30)[:, None]
    return Mesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3), np.repeat(normals, 3, axis=0))
