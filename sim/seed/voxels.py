"""Voxels of a grain, as computed tomography gives them, to a closed surface: naive
surface nets (Gibson 1998)."""

import numpy as np
from scipy import ndimage

from benchtwin.sim.seed.shape import open_edges, thinned
from benchtwin.sim.seed.surface import enclosed_volume

Array = np.ndarray

# Standard deviation [voxels], and how often voxels that touch in an edge only are
# joined by those beside the edge, before: the first at which no edge of the surface has
# four faces.
SMOOTHING = ((0.8, 0), (1.2, 1), (1.2, 2), (1.8, 3))
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
    for smoothing, joinings in SMOOTHING:
        pad = int(np.ceil(4 * smoothing)) + 1
        padded = np.pad(body, pad)
        for _ in range(joinings):
            padded = _joined_at_edges(padded)
        vertices, faces = _surface_net(
            ndimage.gaussian_filter(padded.astype(float), smoothing) - 0.5
        )
        if len(faces) and not open_edges(faces):
            break
    else:
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


def _joined_at_edges(body: Array) -> Array:
    """With all four voxels round an edge filled where only two across from each other
    are."""
    body = body.copy()
    for i, j in ((0, 1), (0, 2), (1, 2)):
        four = []
        for low_i in (slice(None, -1), slice(1, None)):
            for low_j in (slice(None, -1), slice(1, None)):
                place = [slice(None)] * 3
                place[i], place[j] = low_i, low_j
                four.append(tuple(place))
        a, b, c, d = (body[place] for place in four)
        across = (a & d & ~b & ~c) | (b & c & ~a & ~d)
        for part in four:
            body[part] |= across
    return body


def _surface_net(field: Array) -> tuple[Array, Array]:
    """One vertex in each cell that the level 0 passes, in the middle of its crossings;
    a square of four round each crossed edge."""
    inside = field > 0
    cells = tuple(n - 1 for n in field.shape)
    total, count = np.zeros((*cells, 3)), np.zeros(cells)
    quads = []
    number = np.full(cells, -1, np.int64)
    crossings = []
    for axis in range(3):
        near, far = _ends(field, axis)
        crossed = np.argwhere((near > 0) != (far > 0))
        a, b = near[tuple(crossed.T)], far[tuple(crossed.T)]
        place = crossed.astype(float)
        place[:, axis] += a / (a - b)
        others = [k for k in range(3) if k != axis]
        around = []
        for step in ((0, 0), (1, 0), (1, 1), (0, 1)):
            cell = crossed.copy()
            cell[:, others[0]] -= step[0]
            cell[:, others[1]] -= step[1]
            np.add.at(total, tuple(cell.T), place)
            np.add.at(count, tuple(cell.T), 1)
            around.append(cell)
        crossings.append((around, inside[tuple(crossed.T)], axis))
    there = count > 0
    number[there] = np.arange(int(there.sum()))
    vertices = total[there] / count[there][:, None]
    for around, leaving, axis in crossings:
        quad = np.stack([number[tuple(cell.T)] for cell in around], axis=1)
        turn = leaving if axis == 1 else ~leaving  # seen from outside counter-clockwise
        quad[turn] = quad[turn][:, ::-1]
        quads += [quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]]
    return vertices, np.concatenate(quads)


def _ends(field: Array, axis: int) -> tuple[Array, Array]:
    """Values at both ends of each grid edge along an axis, indexed by its lower end."""
    first, last = [slice(None)] * 3, [slice(None)] * 3
    first[axis], last[axis] = slice(None, -1), slice(1, None)
    return field[tuple(first)], field[tuple(last)]
