"""Geometry of closed outlines: Feret diameters, centroid, ellipse, elliptic Fourier
terms, a standard pose.

x(t) = Σ ax_h cos 2πht + bx_h sin 2πht, y(t) = Σ ay_h cos 2πht + by_h sin 2πht, t from 0
to 1 along the outline, h = 1, 2, …

Source: Kuhl, Giardina, Comput. Graph. Image Process. 18 (1982) 236-258.
"""

import cv2
import numpy as np

Array = np.ndarray
HARMONICS = 12  # that an edge known to a tenth of a pixel resolves on a seed of 60 px


def feret(points: np.ndarray) -> tuple[float, float, float]:
    """Largest and smallest Feret diameter of `points` (n, 2), and the direction of the
    largest [deg, −90 to 90]. Exact for polygons: the smallest is perpendicular to a
    side of the hull, the largest joins two corners."""
    hull = cv2.convexHull(points.astype(np.float32))[:, 0].astype(float)
    side = np.roll(hull, -1, 0) - hull
    side = side[np.hypot(*side.T) > 1e-9]
    normal = np.stack([-side[:, 1], side[:, 0]], -1) / np.hypot(*side.T)[:, None]
    across = normal[:, :1] * hull[:, 0] + normal[:, 1:] * hull[:, 1]
    apart = hull[:, None] - hull[None]
    distance = np.hypot(apart[..., 0], apart[..., 1])
    i, j = np.unravel_index(int(distance.argmax()), distance.shape)
    angle = float(np.degrees(np.arctan2(apart[i, j, 1], apart[i, j, 0])))
    narrow = float(np.ptp(across, axis=1).min())
    return (float(distance[i, j]), narrow, (angle + 90) % 180 - 90)


def centroid(points: np.ndarray) -> tuple[tuple[float, float], float]:
    """Centroid and area of a closed polygon."""
    origin = points.mean(0)
    of = cv2.moments((points - origin).astype(np.float32))
    area = max(of["m00"], 1e-9)
    x, y = origin + np.array([of["m10"], of["m01"]]) / area
    return (float(x), float(y)), of["m00"]


def about_ellipse(
    points: np.ndarray, fitted: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Of points (n, 2): along and across the axes of the ellipse through those that are
    `fitted` (n,), in semi-axes (n, 2); and that ellipse: middle, semi-axes, axes as
    columns (2, 2)."""
    middle, axes, angle = cv2.fitEllipseDirect(points[fitted].astype(np.float32))
    cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turned, semi = np.array([[cos, -sin], [sin, cos]]), np.maximum(axes, 1.0) / 2
    return (points - middle) @ turned / semi, np.array(middle), semi, turned


def ellipse_agreement(points: np.ndarray) -> float:
    """Agreement of the outline with a fitted ellipse: 1 − 2 · mean relative difference
    of the radii."""
    place, *_ = about_ellipse(points, np.ones(len(points), bool))
    return float(1 - 2 * np.mean(np.abs(np.hypot(*place.T) - 1)))


def solidity(patch: np.ndarray) -> float:
    """Area over that of the convex hull."""
    return cv2.contourArea(patch) / max(cv2.contourArea(cv2.convexHull(patch)), 1.0)


def fourier_terms(points: Array, harmonics: int = HARMONICS) -> Array:
    """(harmonics, 4): ax, bx, ay, by of a closed polygon (n, 2), in its unit."""
    step = np.roll(points, -1, 0) - points
    length = np.maximum(np.hypot(*step.T), 1e-12)
    end = np.cumsum(length)
    h = np.arange(1, harmonics + 1)[:, None]
    angle = 2 * np.pi * h * np.concatenate([[0.0], end]) / end[-1]
    along = step / length[:, None] * end[-1] / (2 * np.pi**2)
    ax, ay = (np.diff(np.cos(angle)) / h**2 @ along).T
    bx, by = (np.diff(np.sin(angle)) / h**2 @ along).T
    return np.column_stack([ax, bx, ay, by])


def from_fourier_terms(of: Array, count: int) -> Array:
    """Outline (count, 2) with these Fourier terms (h, 4), about the centroid of its
    area."""
    angle = 2 * np.pi * np.outer(np.arange(count) / count, np.arange(1, len(of) + 1))
    cos, sin = np.cos(angle), np.sin(angle)
    points = np.column_stack(
        [cos @ of[:, 0] + sin @ of[:, 1], cos @ of[:, 2] + sin @ of[:, 3]]
    )
    return points - np.array(centroid(points)[0])


def aligned_outline(points: Array, count: int = 256) -> Array:
    """The outline in a standard pose, (count, 2) at even steps: centroid at 0, length
    along x, counter-clockwise from +x, y up. It is rotated by half a turn and mirrored
    (a seed lies on either side) so that its third moments along x and y are not
    negative: the blunter end is at +x. points (n, 2): y down, as in a picture."""
    flat = points * [1.0, -1.0]
    flat = flat - np.array(centroid(flat)[0])
    turn = np.radians(feret(flat)[2])
    flat = flat @ np.array(
        [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    )
    third = cv2.moments(flat.astype(np.float32))
    flat = flat * [-1.0 if third[f"mu{k}"] < 0 else 1.0 for k in ("30", "03")]
    if (
        np.sum(
            flat[:, 0] * np.roll(flat[:, 1], -1) - flat[:, 1] * np.roll(flat[:, 0], -1)
        )
        < 0
    ):
        flat = flat[::-1]
    crossing = np.flatnonzero(
        (flat[:, 1] <= 0) & (np.roll(flat[:, 1], -1) > 0) & (flat[:, 0] > 0)
    )
    length = -(int(crossing[-1]) + 1) if len(crossing) else -int(flat[:, 0].argmax())
    flat = np.roll(flat, length, axis=0)
    along = np.concatenate(
        [[0.0], np.cumsum(np.hypot(*(np.roll(flat, -1, 0) - flat).T))]
    )
    closed, at = np.vstack([flat, flat[:1]]), np.arange(count) / count * along[-1]
    return np.column_stack([np.interp(at, along, closed[:, k]) for k in range(2)])
