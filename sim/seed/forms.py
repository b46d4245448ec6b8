"""Closed meshes of parametrised seed forms, each scaled to enclose its closed-form
volume: vertices [m] and faces."""

import math

import numpy as np
from benchtwin.sim.seed.surface import ellipsoid_mesh, enclosed_volume
from scipy.special import beta, erf

Array = np.ndarray
Surface = tuple[Array, Array]

# vertices round a ring, rings from pole to pole: flat faces miss a unit sphere by 0.1 %
AROUND, RINGS = (96, 32)
LEAST_EXPONENT, MOST_EXPONENT = 0.1, 2.0
MOST_OUTLINE = 128


def ellipsoid(length_m: float, width_m: float, thickness_m: float) -> Surface:
    """See `Shape.ellipsoid`."""
    mesh = ellipsoid_mesh(_halves(length_m, width_m, thickness_m), level=4)
    return mesh.vertices_m, mesh.faces


def flattened_ellipsoid(
    length_m: float, width_m: float, thickness_m: float, flat_at: float
) -> Surface:
    """See `Shape.flattened_ellipsoid`; a ring of vertices runs along the edge, further
    ones across the flat."""
    halves = _halves(length_m, width_m, thickness_m)
    if not 0.0 < flat_at < 1.0:
        raise ValueError(f"flat_at = {flat_at:g}: must be above 0 and below 1")
    rim = math.sqrt(1.0 - flat_at**2)
    # from the edge up to the pole, z = -sin
    cap = np.linspace(math.asin(flat_at), -math.pi / 2, RINGS)[:-1]
    z = np.concatenate([np.full(8, -flat_at), -np.sin(cap[1:])])
    radius = np.concatenate([np.linspace(1 / 8, 1.0, 8) * rim, np.cos(cap[1:])])
    vertices, faces = _rings(radius, z, -flat_at, 1.0)
    volume = math.pi * (2.0 / 3.0 + flat_at - flat_at**3 / 3.0)
    return _enlarge_to_volume(vertices * halves, faces, volume * float(np.prod(halves)))


def superquadric(
    length_m: float,
    width_m: float,
    thickness_m: float,
    across: float,
    along: float,
    taper: float,
) -> Surface:
    """See `Shape.superquadric`."""
    halves = _halves(length_m, width_m, thickness_m)
    for name, value in (("across", across), ("along", along)):
        if not LEAST_EXPONENT <= value <= MOST_EXPONENT:
            raise ValueError(
                f"{name} = {value:g}: must be {LEAST_EXPONENT:g} to {MOST_EXPONENT:g}"
            )
    if not abs(taper) <= 0.9:
        raise ValueError(f"taper = {taper:g}: must be -0.9 to 0.9")
    radius, z = _superellipse(
        np.linspace(-np.pi / 2, np.pi / 2, RINGS + 1)[1:-1], across
    )
    turn = np.linspace(0.0, 2 * np.pi, AROUND, endpoint=False)
    unit = np.stack(_superellipse(turn, along), axis=1)
    vertices, faces = _rings(radius, z, -1.0, 1.0, unit)
    vertices = vertices * halves
    volume = (
        2.0
        * across
        * along
        * beta(across / 2 + 1, across)
        * beta(along / 2, along / 2)
        * float(np.prod(halves))
    )
    vertices, faces = _enlarge_to_volume(vertices, faces, volume)
    vertices[:, 1] *= 1.0 + taper * vertices[:, 0] / halves[0]
    return vertices, faces


def _superellipse(angle: Array, exponent: float) -> tuple[Array, Array]:
    """Points of |x|^(2/e) + |y|^(2/e) = 1 in the directions `angle`, which spread
    evenly where cos^e, sin^e would crowd."""
    c, s = np.cos(angle), np.sin(angle)
    far = (np.abs(c) ** (2 / exponent) + np.abs(s) ** (2 / exponent)) ** (-exponent / 2)
    return far * c, far * s


def creased_ellipsoid(
    length_m: float,
    width_m: float,
    thickness_m: float,
    depth: float,
    half_width_deg: float,
) -> Surface:
    """See `Shape.creased_ellipsoid`; rings about the long axis, more vertices in the
    furrow."""
    halves = _halves(length_m, width_m, thickness_m)
    if not 0.0 <= depth <= 0.6:
        raise ValueError(f"depth = {depth:g}: must be 0 to 0.6 of the half thickness")
    if not 3.0 <= half_width_deg <= 40.0:
        raise ValueError(f"half_width_deg = {half_width_deg:g}: must be 3 to 40")
    w = math.radians(half_width_deg)
    fine = np.linspace(-3.5 * w, 3.5 * w, AROUND // 2 + 1)
    rest = np.linspace(3.5 * w, 2 * np.pi - 3.5 * w, AROUND // 2 + 1)
    psi = np.concatenate([fine[:-1], rest[:-1]])  # from -z, about x
    furrow = depth * np.exp(
        -(np.where(psi > np.pi, psi - 2 * np.pi, psi) ** 2) / (2 * w * w)
    )
    polar = np.linspace(np.pi, 0.0, RINGS + 1)[1:-1]
    far = 1.0 - np.sin(polar)[:, None] ** 2 * furrow
    x, across = far * np.cos(polar)[:, None], far * np.sin(polar)[:, None]
    rows = np.stack([x, across * np.sin(psi), -across * np.cos(psi)], axis=2)
    vertices, faces = _join_rings(rows, np.array([-1.0, 0, 0]), np.array([1.0, 0, 0]))
    return _enlarge_to_volume(
        vertices * halves, faces, float(np.prod(halves)) * creased_volume(depth, w)
    )


def creased_volume(depth: float, w: float) -> float:
    """∫ (1 - d sin²θ exp(-ψ²/2w²))³/3 dΩ, term by term: ∫ sin^(2k+1) = 2, 4/3, 16/15,
    32/35; the Gaussians by erf."""
    gauss = [2 * np.pi] + [
        w * math.sqrt(2 * np.pi / k) * erf(np.pi * math.sqrt(k / 2) / w)
        for k in (1, 2, 3)
    ]
    return sum(
        weight * (-depth) ** k * sine * g / 3
        for k, (weight, sine, g) in enumerate(zip((1, 3, 3, 1), SINES, gauss))
    )


SINES = (2.0, 4.0 / 3.0, 16.0 / 15.0, 32.0 / 35.0)


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
    vertices, faces = _rings(np.cos(polar), np.sin(polar), -1.0, 1.0, rim)
    vertices[:, 2] *= thickness_m / 2.0
    return _enlarge_to_volume(vertices, faces, 2.0 / 3.0 * area * thickness_m)


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


def _halves(length_m: float, width_m: float, thickness_m: float) -> Array:
    sizes = np.array([length_m, width_m, thickness_m], float)
    if not ((sizes > 0) & np.isfinite(sizes)).all():
        raise ValueError(
            f"length_m, width_m, thickness_m = {length_m:g}, {width_m:g},"
            f" {thickness_m:g}: must be above 0"
        )
    return sizes / 2.0


def _rings(
    radius: Array, z: Array, bottom: float, top: float, unit: Array | None = None
) -> Surface:
    """Rings of `unit` (m, 2) times radius at heights z, closed by a point at the bottom
    and one at the top, on the z axis."""
    if unit is None:
        turn = np.linspace(0.0, 2 * np.pi, AROUND, endpoint=False)
        unit = np.c_[np.cos(turn), np.sin(turn)]
    height = np.broadcast_to(z[:, None, None], (len(z), len(unit), 1))
    rows = np.concatenate([radius[:, None, None] * unit, height], axis=2)
    return _join_rings(rows, np.array([0.0, 0.0, bottom]), np.array([0.0, 0.0, top]))


def _join_rings(rows: Array, first: Array, last: Array) -> Surface:
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


def _enlarge_to_volume(vertices: Array, faces: Array, volume_m3: float) -> Surface:
    """Scale the vertices so that the flat faces enclose the curved form's volume (by
    tenths of a percent)."""
    return vertices * (volume_m3 / enclosed_volume(vertices, faces)) ** (1 / 3), faces
