"""Silhouettes of one seed in a film → an ellipse of constant axes, and its pose in each frame."""

import math
from dataclasses import replace

import numpy as np

from vision.motion.detect import Silhouette
from vision.motion.ellipse_fit import Ellipse, EllipsePose, fit_ellipse

RESTING_PX = 0.3  # a smaller step from frame to frame is rest
CLEAN = 0.08  # relative deviation from the seed's area, within which a silhouette shows the seed alone
AREA_SCATTER, MOST_DEVIATING = 0.01, 0.05  # scatter of areas, and share of deviating ones, above which centroids are biased
STATED_MARGIN = 0.05  # of a stated area: no seed is exactly an ellipse
LEAST_ROWS = 8
BLURS_PX = (0.45, 0.6, 0.8, 1.1, 1.5)  # sds of blur that are tried
LEAST_EDGE = 0.5  # share of the ellipse's edge that must agree in one frame
MOST_AREA = 2.2  # of the seed's area: the seed, its mirror image and some shadow
LEAST_MEDIAN_EDGE = 0.75  # median share of the edge, below which no ellipse of constant axes is what moves


def fit_ellipses(shapes: list[Silhouette], stated_px: tuple[float, float]) -> list[EllipsePose | None] | None:
    """Pose of the ellipse in each frame, None where too little of its edge is seen.

    stated_px: least and greatest area of the stated seed. None as a whole where the silhouettes' centroids are unbiased, or no ellipse
    of constant axes fits.
    """
    x, y, area = np.array([(s.x, s.y, s.area) for s in shapes]).T
    if len(shapes) < 2 * LEAST_ROWS or _steady(area):
        return None
    vx, vy = np.gradient(x), np.gradient(y)
    speed = np.hypot(vx, vy)
    ellipse, clean = _estimate_ellipse(shapes, speed, stated_px)
    if clean.sum() < LEAST_ROWS or min(ellipse.a, ellipse.b) < 2:
        return None
    directions = [(u / max(s, 1e-9), v / max(s, 1e-9)) if s > RESTING_PX else (1.0, 0.0) for u, v, s in zip(vx, vy, speed)]
    streak = _exposure(shapes, directions, speed, ellipse, clean) * speed
    start_poses = [_start_poses(s, ellipse, k, bool(c)) for s, k, c in zip(shapes, streak, clean)]
    sample = np.flatnonzero(clean)[np.linspace(0, clean.sum() - 1, min(12, clean.sum())).astype(int)]

    def best_pose(k: int, blur_px: float) -> EllipsePose | None:
        found = [fit_ellipse(ellipse, shapes[k].patch, start, directions[k], blur_px) for start in start_poses[k]]
        return max((pose for pose in found if pose is not None), key=_edge_share, default=None)

    blur = max(BLURS_PX, key=lambda blur_px: sum(_edge_share(best_pose(k, blur_px)) for k in sample))
    poses = [best_pose(k, blur) for k in range(len(shapes))]
    if np.median([_edge_share(poses[k]) for k in np.flatnonzero(clean)]) < LEAST_MEDIAN_EDGE:
        return None
    most = MOST_AREA * math.pi * ellipse.a * ellipse.b
    return [pose if _edge_share(pose) >= LEAST_EDGE and a < most else None for pose, a in zip(poses, area)]


def _steady(area: np.ndarray) -> bool:
    """Whether the areas scatter so little that the silhouettes show the whole seed and nothing else."""
    padded = np.pad(area, 2, mode="reflect")
    off = np.abs(area / np.median(np.lib.stride_tricks.sliding_window_view(padded, 5), axis=1) - 1)
    deviating = np.abs(area / np.median(area) - 1) > MOST_DEVIATING
    return 1.4826 * float(np.median(off)) < AREA_SCATTER and float(deviating.mean()) < MOST_DEVIATING


def _estimate_ellipse(shapes: list[Silhouette], speed: np.ndarray, stated_px: tuple[float, float]) -> tuple[Ellipse, np.ndarray]:
    """Axes of the ellipse from the slowest frames that show the seed alone, and which frames (n,) do."""
    area, cut = np.array([s.area for s in shapes]), np.array([s.cut for s in shapes])
    used = (speed > RESTING_PX) & ~cut
    used = used if used.sum() >= LEAST_ROWS else ~cut
    typical = float(np.median(area[used])) if used.any() else 0.0
    typical = float(np.clip(typical, stated_px[0] * (1 - STATED_MARGIN), stated_px[1] * (1 + STATED_MARGIN)))
    clean = (np.abs(area / max(typical, 1e-9) - 1) < CLEAN) & ~cut
    calm = np.flatnonzero(clean)[np.argsort(speed[clean])][: max(LEAST_ROWS, int(clean.sum()) // 3)]
    ratio = [math.sqrt(max(_principal_moments(shapes[i])[0], 1e-9) / max(_principal_moments(shapes[i])[1], 1e-9)) for i in calm]
    stretch = float(np.median(ratio)) if ratio else 1.0
    radius = math.sqrt(typical / math.pi)
    return Ellipse(radius * math.sqrt(stretch), radius / math.sqrt(stretch)), clean


def _principal_moments(shape: Silhouette) -> tuple[float, float]:
    """Greatest and least second moment about the centroid."""
    middle, half = (shape.xx + shape.yy) / 2, math.hypot((shape.xx - shape.yy) / 2, shape.xy)
    return middle + half, middle - half


def _orientation(shape: Silhouette) -> float:
    return 0.5 * math.atan2(2 * shape.xy, shape.xx - shape.yy)


def _exposure(shapes, directions, speed: np.ndarray, ellipse: Ellipse, clean: np.ndarray) -> float:
    """Exposure time as a share of the frame interval: motion blur of length L adds L²/12 to the moment along the motion."""
    fast = np.flatnonzero(clean & (speed > 0.3 * ellipse.a))
    if len(fast) < 4:
        return 0.0
    shares = []
    for i in fast:
        s, (p, q) = shapes[i], directions[i]
        along, across = s.xx * p * p + 2 * s.xy * p * q + s.yy * q * q, s.xx * q * q - 2 * s.xy * p * q + s.yy * p * p
        own = across if ellipse.round else ellipse.a * ellipse.b / 4
        shares.append(math.sqrt(max(12 * (along - own), 0.0)) / speed[i])
    return float(np.clip(np.median(shares), 0.0, 1.0))


def _start_poses(shape: Silhouette, ellipse: Ellipse, streak: float, clean: bool) -> list[EllipsePose]:
    """First guesses of the pose: about the centroid, and below the top of the silhouette, which no shadow reaches."""
    first = EllipsePose(shape.x, shape.y, _orientation(shape), float(streak), 0.0, 0.0)
    if clean:
        return [first]
    rows = np.flatnonzero((shape.patch.coverage > 0.5).sum(axis=1) > ellipse.b / 2)
    top = shape.patch.y0 + (float(rows[0]) if len(rows) else 0.0)
    return [first, replace(first, y=top + ellipse.b + streak / 2)]


def _edge_share(pose: EllipsePose | None) -> float:
    return 0.0 if pose is None else pose.edge_share
