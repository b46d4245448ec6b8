"""Geometry of closed outlines: Feret diameters, centroid, area, agreement with an ellipse, solidity."""

import cv2
import numpy as np


def feret(points: np.ndarray) -> tuple[float, float, float]:
    """Largest and smallest Feret diameter of `points` (n, 2), and the direction of the largest [deg, −90 to 90].

    Exact for polygons: the smallest is perpendicular to a side of the hull, the largest joins two corners.
    """
    hull = cv2.convexHull(points.astype(np.float32))[:, 0].astype(float)
    side = np.roll(hull, -1, 0) - hull
    side = side[np.hypot(*side.T) > 1e-9]
    normal = np.stack([-side[:, 1], side[:, 0]], -1) / np.hypot(*side.T)[:, None]
    across = normal[:, :1] * hull[:, 0] + normal[:, 1:] * hull[:, 1]
    apart = hull[:, None] - hull[None]
    distance = np.hypot(apart[..., 0], apart[..., 1])
    i, j = np.unravel_index(int(distance.argmax()), distance.shape)
    angle = float(np.degrees(np.arctan2(apart[i, j, 1], apart[i, j, 0])))
    return float(distance[i, j]), float(np.ptp(across, axis=1).min()), (angle + 90) % 180 - 90


def centroid(points: np.ndarray) -> tuple[tuple[float, float], float]:
    """Centroid and area of a closed polygon."""
    origin = points.mean(0)
    (x, y), (xn, yn) = (points - origin).T, (np.roll(points, -1, 0) - origin).T
    cross = x * yn - xn * y
    area = float(cross.sum()) / 2
    if abs(area) < 1e-9:
        return (float(origin[0]), float(origin[1])), 0.0
    return (
        float(origin[0] + ((x + xn) * cross).sum() / (6 * area)),
        float(origin[1] + ((y + yn) * cross).sum() / (6 * area)),
    ), abs(area)


def ellipse_agreement(points: np.ndarray) -> float:
    """Agreement of the outline with a fitted ellipse: 1 − 2 · mean relative difference of the radii."""
    (cx, cy), axes, angle = cv2.fitEllipseDirect(points.astype(np.float32))
    turn = np.radians(angle)
    x, y = points[:, 0] - cx, points[:, 1] - cy
    depth = np.hypot(
        (x * np.cos(turn) + y * np.sin(turn)) / (axes[0] / 2), (-x * np.sin(turn) + y * np.cos(turn)) / (axes[1] / 2)
    )
    return float(1 - 2 * np.mean(np.abs(depth - 1)))


def solidity(patch: np.ndarray) -> float:
    """Area over that of the convex hull."""
    return cv2.contourArea(patch) / max(cv2.contourArea(cv2.convexHull(patch)), 1.0)
