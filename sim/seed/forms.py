"""Closed meshes made of rings of vertices, and the body over an outline: vertices [m]
and faces."""

import math

import numpy as np

from benchtwin.sim.seed.surface import enclosed_volume

Array = np.ndarray
Surface = tuple[Array, Array]

# vertices round a ring, rings from pole to pole: flat faces miss a unit sphere by 0.1 %
AROUND, RINGS = (96, 32)
MOST_OUTLINE = 128


def over_outline(outline_m: Array, thickness_m: float) -> Surface:
    """See `Shape.from_outline`."""
    if (
        outline_m.ndim != 2
        or outline_m.shape[1] != 2
        or len(outline_m) < 8
        or not np.isfinite(outline_m).all()
    ):
        raise ValueError(
            f"outline_m has the shape {outline_m.shape}: 8 or more points (x, y) are"
            " needed, all of them finite"
        )
    if not 0.0 < thickness_m < math.inf:
        raise ValueError(f"thickness_m = {thickness_m:g}: must be above 0")
    if np.array_equal(outline_m[0], outline_m[-1]):
        outline_m = outline_m[:-1]
    area, centre = _area_and_centroid(outline_m)
    if area < 0:
        outline_m, area = outline_m[::-1], -area
    rim = _thin_outline(outline_m - centre)
    ahead = np.roll(rim, -1, axis=0)
    if (rim[:, 0] * ahead[:, 1] - rim[:, 1] * ahead[:, 0] <= 0).any():
        raise ValueError(
            "outline_m: a ray from its centroid crosses it more than once; such an"
            " outline has no thickness over it"
        )
    rim = rim * math.sqrt(area / _area_and_centroid(rim)[0])
    polar = np.linspace(-np.pi / 2, np.pi / 2, RINGS + 1)[1:-1]
    vertices, faces = rings(np.cos(polar), np.sin(polar), -1.0, 1.0, rim)
    vertices[:, 2] *= thickness_m / 2.0
    return enlarge_to_volume(vertices, faces, 2.0 / 3.0 * area * thickness_m)


def _thin_outline(rim: Array) -> Array:
    """At most MOST_OUTLINE of the points, evenly along the outline."""
    if len(rim) <= MOST_OUTLINE:
        return rim
    closed = np.vstack([rim, rim[:1]])
    way = np.concatenate(
        [[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))]
    )
    at = np.linspace(0.0, way[-1], MOST_OUTLINE, endpoint=False)
    return np.stack([np.interp(at, way, closed[:, k]) for k in range(2)], axis=1)


def _area_and_centroid(points: Array) -> tuple[float, Array]:
    """Of a polygon (n, 2); the area is negative if it runs clockwise."""
    ahead = np.roll(points, -1, axis=0)
    cross = points[:, 0] * ahead[:, 1] - points[:, 1] * ahead[:, 0]
    area = float(cross.sum() / 2.0)
    if not abs(area) > 0:
        raise ValueError("outline_m: it encloses no area")
    return area, cross @ (points + ahead) / (6.0 * area)


def rings(
    radius: Array, z: Array, bottom: float, top: float, unit: Array | None = None
) -> Surface:
    """Rings of `unit` (m, 2) times radius at heights z, closed by a point at the bottom
    and one at the top, on the z axis."""
    if unit is None:
        turn = np.linspace(0.0, 2 * np.pi, AROUND, endpoint=False)
        unit = np.c_[np.cos(turn), np.sin(turn)]
    height = np.broadcast_to(z[:, None, None], (len(z), len(unit), 1))
    rows = np.concatenate([radius[:, None, None] * unit, height], axis=2)
    return join_rings(rows, np.array([0.0, 0.0, bottom]), np.array([0.0, 0.0, top]))


def join_rings(rows: Array, first: Array, last: Array) -> Surface:
    """Rows (k, m, 3) of vertices, each a ring counter-clockwise as seen from `last`,
    joined, and closed by the two points."""
    k, m = rows.shape[:2]
    number = np.arange(k * m).reshape(k, m)
    here, beside = number[:-1], np.roll(number, -1, axis=1)[:-1]
    above, above_beside = number[1:], np.roll(number, -1, axis=1)[1:]
    sides = [
        np.stack([here, beside, above_beside], axis=-1),
        np.stack([here, above_beside, above], axis=-1),
    ]
    ring, around = number[0], np.roll(number[0], -1)
    low = np.stack([np.full(m, k * m), around, ring], axis=-1)
    high = np.stack(
        [np.full(m, k * m + 1), number[-1], np.roll(number[-1], -1)], axis=-1
    )
    faces = np.concatenate([side.reshape(-1, 3) for side in sides] + [low, high])
    return np.vstack([rows.reshape(-1, 3), first, last]), faces


def enlarge_to_volume(vertices: Array, faces: Array, volume_m3: float) -> Surface:
    """Scale the vertices so that the flat faces enclose the curved form's volume (by
    tenths of a percent)."""
    return vertices * (volume_m3 / enclosed_volume(vertices, faces)) ** (1 / 3), faces
