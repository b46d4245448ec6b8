"""Volume, centre and second moments of what a clump encloses: the union of its balls,
each point counted once."""

from dataclasses import dataclass

import numpy as np

from benchtwin.bench.ellipsoid import ellipsoid_volume

Array = np.ndarray

# An arc's integrands are trigonometric polynomials of degree 5: 24 Gauss points do a
# whole turn to 1e-15.
_ARC_NODES, _ARC_WEIGHTS = np.polynomial.legendre.leggauss(24)
_SLICE_NODES, _SLICE_WEIGHTS = np.polynomial.legendre.leggauss(10)
# Between two radical planes the profile squared is a quadratic: its moments have degree
# 4, three points are exact.
_PROFILE_NODES, _PROFILE_WEIGHTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True, eq=False)
class Solid:
    """Volume [m3], centre [m] (3,), and second moment S = ∫ (x-c)(x-c)ᵀ dV [m5] (3, 3)
    of a homogeneous body."""

    volume_m3: float
    centre_m: Array
    second_m5: Array

    def inertia(self, density_kg_m3: float) -> Array:
        """Inertia tensor about the centre, ρ (tr S · 1 - S) [kg m2] (3, 3)."""
        return density_kg_m3 * (np.trace(self.second_m5) * np.eye(3) - self.second_m5)


def ellipsoid(length_m: float, width_m: float, thickness_m: float) -> Solid:
    """Ellipsoid with its axes along x, y, z: V = π L W T / 6, S_ii = V a_i²/5, a_i the
    half axes; any positive sizes [m].

    >>> round(ellipsoid(2.0, 2.0, 2.0).volume_m3, 6)
    4.18879
    """
    volume = ellipsoid_volume(length_m, width_m, thickness_m)
    halves = np.array([length_m, width_m, thickness_m]) / 2.0
    return Solid(volume, np.zeros(3), np.diag(volume * halves**2 / 5.0))


def principal(inertia: Array) -> tuple[Array, Array]:
    """Principal moments (3,) and axes (3, 3, columns, right-handed), kept along x, y, z
    as nearly as they can be."""
    off = inertia - np.diag(np.diag(inertia))
    if np.abs(off).max() <= 1e-9 * np.trace(inertia):
        return np.diag(inertia).copy(), np.eye(3)
    moments, axes = np.linalg.eigh(inertia)
    order, left = [], [0, 1, 2]
    for row in range(3):
        order.append(max(left, key=lambda column: abs(axes[row, column])))
        left.remove(order[-1])
    axes = axes[:, order]
    axes = axes * np.where(np.diag(axes) < 0.0, -1.0, 1.0)
    if np.linalg.det(axes) < 0.0:
        axes[:, 2] *= -1.0
    return moments[order], axes


def union_of_balls(centres_m: Array, radii_m: Array) -> Solid:
    """The union of balls with centres (n, 3) [m] and radii (n,) [m], each point counted
    once.

    Balls on one line: exact, the profile squared being a piecewise quadratic. Any
    others: slices across their longest extent, in each the union of discs by Green's
    theorem over the exposed arcs; relative error below 1e-5 up to 20 balls.

    >>> round(union_of_balls(np.zeros((1, 3)), np.ones(1)).volume_m3, 6)
    4.18879
    """
    scale = float(np.max(radii_m))
    origin = centres_m.mean(axis=0)
    centres, radii = (centres_m - origin) / scale, radii_m / scale
    _, _, turn = np.linalg.svd(centres, full_matrices=True)
    # rows: the frame, longest extent first; an odd flip is undone
    turn = turn * np.sign(np.linalg.det(turn))
    local = centres @ turn.T
    on_a_line = len(radii) == 1 or np.abs(local[:, 1:]).max() < 1e-12
    volume, first, second = (
        _on_a_line(local[:, 0], radii) if on_a_line else _by_slices(local, radii)
    )
    centre = first / volume
    about_centre = second - volume * np.outer(centre, centre)
    return Solid(
        float(volume) * scale**3,
        origin + scale * (turn.T @ centre),
        scale**5 * (turn.T @ about_centre @ turn),
    )


def _on_a_line(x: Array, radii: Array) -> tuple[float, Array, Array]:
    """Moments about the origin of balls at x (n,): ∫π p dx, ∫π p x dx, ∫π p x² dx and
    ∫(π/4) p² dx, p = max(r²-(x-x_i)²)."""
    # r²-(s-x_i)² + s² = bow + 2 x_i s: straight lines in s, whose upper hull is the
    # profile
    bow = radii**2 - x**2
    rise, gap = 2.0 * (x[:, None] - x[None, :]), bow[None, :] - bow[:, None]
    crossings = gap[np.abs(rise) > 1e-14] / rise[np.abs(rise) > 1e-14]
    edges = np.unique(np.concatenate([x - radii, x + radii, crossings]))
    edges = edges[(edges >= (x - radii).min()) & (edges <= (x + radii).max())]
    half, middle = np.diff(edges) / 2.0, (edges[1:] + edges[:-1]) / 2.0
    s = (middle[:, None] + half[:, None] * _PROFILE_NODES).ravel()
    weight = (half[:, None] * _PROFILE_WEIGHTS).ravel()
    profile = np.maximum((radii[:, None] ** 2 - (s - x[:, None]) ** 2).max(axis=0), 0.0)
    area = np.pi * profile * weight
    across = np.pi / 4.0 * np.sum(profile**2 * weight)
    return (
        float(area.sum()),
        np.array([area @ s, 0.0, 0.0]),
        np.diag([area @ s**2, across, across]),
    )


def _by_slices(centres: Array, radii: Array) -> tuple[float, Array, Array]:
    """Moments about the origin from slices x = const, with panel ends where a ball or a
    crossing of two balls begins or ends."""
    crossings = _crossing_ends(centres, radii)
    edges = np.unique(
        np.concatenate([centres[:, 0] - radii, centres[:, 0] + radii, *crossings])
    )
    edges = edges[np.concatenate([[True], np.diff(edges) > 1e-12])]
    half, middle = np.diff(edges) / 2.0, (edges[1:] + edges[:-1]) / 2.0
    x = (middle[:, None] + half[:, None] * _SLICE_NODES).ravel()
    weight = (half[:, None] * _SLICE_WEIGHTS).ravel()
    # (slices, n)
    discs = np.sqrt(np.maximum(radii**2 - (x[:, None] - centres[:, 0]) ** 2, 0.0))
    area, y1, z1, yy, zz, yz = weight * sum(
        _exposed_arcs(i, discs, centres[:, 1:]) for i in range(len(radii))
    )
    first = np.array([area @ x, y1.sum(), z1.sum()])
    second = np.array(
        [
            [area @ x**2, y1 @ x, z1 @ x],
            [y1 @ x, yy.sum(), yz.sum()],
            [z1 @ x, yz.sum(), zz.sum()],
        ]
    )
    return float(area.sum()), first, second


def _crossing_ends(centres: Array, radii: Array) -> list[Array]:
    """Least and greatest x of the circle in which each two balls' surfaces cross."""
    i, j = np.triu_indices(len(radii), 1)
    between = centres[j] - centres[i]
    distance = np.linalg.norm(between, axis=1)
    cross = (distance < radii[i] + radii[j]) & (distance > np.abs(radii[i] - radii[j]))
    i, j, between, distance = i[cross], j[cross], between[cross], distance[cross]
    along = (distance**2 + radii[i] ** 2 - radii[j] ** 2) / (2.0 * distance)
    circle = np.sqrt(np.maximum(radii[i] ** 2 - along**2, 0.0))
    middle = centres[i, 0] + along * between[:, 0] / distance
    reach = circle * np.sqrt(np.maximum(1.0 - (between[:, 0] / distance) ** 2, 0.0))
    return [middle - reach, middle + reach]


def _exposed_arcs(i: int, discs: Array, yz: Array) -> Array:
    """Green's line integrals over the arcs of disc i that no other disc covers: (6,
    slices) = ∫1, y, z, y², z², yz."""
    radius = discs[:, i]
    start, stop, hidden = _covered_by_others(i, discs, yz)
    order = np.argsort(start, axis=1)
    start = np.take_along_axis(start, order, 1)
    stop = np.take_along_axis(stop, order, 1)
    reached = np.maximum.accumulate(
        np.concatenate([np.zeros((len(radius), 1)), stop], axis=1), axis=1
    )
    begin = reached
    end = np.concatenate([start, np.full((len(radius), 1), 2.0 * np.pi)], axis=1)
    row, column = np.nonzero((end > begin) & ~hidden[:, None] & (radius > 0.0)[:, None])
    half = (end[row, column] - begin[row, column]) / 2.0
    middle = (end[row, column] + begin[row, column]) / 2.0
    angle = middle[:, None] + half[:, None] * _ARC_NODES
    r = radius[row][:, None]
    y, z = yz[i, 0] + r * np.cos(angle), yz[i, 1] + r * np.sin(angle)
    dz, dy = r * np.cos(angle), -r * np.sin(angle)
    weight = half[:, None] * _ARC_WEIGHTS
    moments = [(y * dz - z * dy) / 2.0, y**2 * dz / 2.0, -(z**2) * dy / 2.0]
    moments += [y**3 * dz / 3.0, -(z**3) * dy / 3.0, y**2 * z * dz / 2.0]
    count = len(radius)
    return np.array(
        [np.bincount(row, (moment * weight).sum(axis=1), count) for moment in moments]
    )


def _covered_by_others(i: int, discs: Array, yz: Array) -> tuple[Array, Array, Array]:
    """Angular intervals of disc i's rim inside other discs, (slices, 2(n-1)) starts and
    stops; and where all of it is hidden."""
    others = np.array([j for j in range(discs.shape[1]) if j != i])
    radius, other = discs[:, [i]], discs[:, others]
    between = yz[others] - yz[i]
    distance = np.broadcast_to(np.hypot(between[:, 0], between[:, 1]), other.shape)
    # Two equal discs at one place hide each other: the first of them counts, or neither
    # would.
    same = (distance < 1e-14) & (np.abs(other - radius) < 1e-14)
    hidden = ((distance + radius <= other) & ~same | same & (others < i)).any(axis=1)
    cross = (
        (distance < radius + other)
        & (distance > np.abs(radius - other))
        & (other > 0.0)
    )
    cosine = (radius**2 + distance**2 - other**2) / np.where(
        cross, 2.0 * distance * radius, 1.0
    )
    half = np.where(cross, np.arccos(np.clip(cosine, -1.0, 1.0)), 0.0)
    start = np.mod(np.arctan2(between[:, 1], between[:, 0]) - half, 2.0 * np.pi)
    start = np.where(cross, start, 0.0)
    stop = start + 2.0 * half
    # An interval that runs past a whole turn covers the beginning too: hence each once
    # more, a turn earlier.
    return (
        np.hstack([start, start - 2.0 * np.pi]),
        np.hstack([stop, stop - 2.0 * np.pi]),
        hidden,
    )
