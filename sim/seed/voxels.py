"""Voxels of a grain, as computed tomography gives them, to a closed surface: marching
cubes (Lewiner et al. 2003)."""

import numpy as np
from scipy import ndimage

from benchtwin.sim.seed.shape import open_edges, thinned
from benchtwin.sim.seed.surface import enclosed_volume

Array = np.ndarray

SMOOTHING = 0.8  # standard deviation [voxels]
LEAST_VOXELS = 200
MOST_FACES = 20_000


def closed_surface(
    filled: Array, pitch_m: float
) -> tuple[Array, Array, tuple[str, ...]]:
    """Vertices [m], faces and notes of the largest piece's surface; voxel (i, j, k) has
    its centre at pitch_m · (i, j, k).

    Voids inside are filled. The surface is smoothed by about a voxel and encloses the
    voxels' volume. ValueError for fewer than 200 voxels in one piece, or a pitch that
    is not positive."""
    from skimage.measure import marching_cubes  # slow to load

    filled = np.asarray(filled, bool)
    if filled.ndim != 3:
        raise ValueError(f"voxels must lie in three dimensions, not {filled.ndim}")
    if not 0.0 < pitch_m < np.inf:
        raise ValueError(f"pitch_m = {pitch_m:g}: must be above 0")
    label, pieces = ndimage.label(filled)
    size = np.bincount(label.ravel())[1:]
    if not len(size) or size.max() < LEAST_VOXELS:
        raise ValueError(
            f"the largest piece has {size.max() if len(size) else 0} voxels:"
            f" {LEAST_VOXELS} at least"
        )
    body = ndimage.binary_fill_holes(label == 1 + int(np.argmax(size)))
    notes = [f"the largest of {pieces} pieces was taken"] if pieces > 1 else []
    void = int(body.sum() - size.max())
    notes += [f"voids of {void} voxels were filled"] if void else []
    corner = np.array(
        [span.start for span in ndimage.find_objects(body.astype(int))[0]]
    )
    body = body[ndimage.find_objects(body.astype(int))[0]]
    pad = int(np.ceil(4 * SMOOTHING)) + 1
    field = ndimage.gaussian_filter(np.pad(body, pad).astype(float), SMOOTHING)
    vertices, faces, *_ = marching_cubes(field, 0.5)
    vertices, faces = vertices.astype(float), faces.astype(np.int64)
    if open_edges(faces):
        raise ValueError(
            "the voxels touch each other in edges and corners only: smooth them, or"
            " scan finer"
        )
    if len(faces) > MOST_FACES:
        notes.append(f"thinned from {len(faces):,} to {MOST_FACES:,} faces")
        vertices, faces = thinned(vertices, faces, MOST_FACES)
    vertices, middle = vertices + corner - pad, vertices.mean(axis=0) + corner - pad
    vertices = middle + (vertices - middle) * (
        body.sum() / abs(enclosed_volume(vertices - middle, faces))
    ) ** (1 / 3)
    return vertices * pitch_m, faces, tuple(notes)
