"""Silhouettes of one seed in a film → an ellipse of constant axes, and its pose in each
frame.

A shadow or a mirror image at the seed's foot enlarges what is seen, and before a
background of its own colour a part of its rim is missing. Both shift the centroid. The
ellipse, blurred along its path by the exposure, is placed where most of its edge agrees
with the edge seen; the rest of the edge has no weight (Cauchy weights)."""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import median_filter

from benchtwin.bench.robust import robust_sd
from benchtwin.vision.motion.detect import Patch, Silhouette

RESTING_PX = 0.3  # a smaller step from frame to frame is rest
# relative deviation from the seed's area, within which a silhouette shows the seed
# alone
CLEAN = 0.08
# scatter of areas, and share of deviating ones, above which centroids are biased
AREA_SCATTER = 0.01
MOST_DEVIATING = 0.05
STATED_MARGIN = 0.05  # of a stated area: no seed is exactly an ellipse
LEAST_ROWS = 8
BLURS_PX = (0.45, 0.6, 0.8, 1.1, 1.5)  # sds of blur that are tried
LEAST_EDGE = 0.5  # share of the ellipse's edge that must agree in one frame
MOST_AREA = 2.2  # of the seed's area: the seed, its mirror image and some shadow
# median share of the edge, below which no ellipse of constant axes is what moves
LEAST_MEDIAN_EDGE = 0.75
INSTANTS = np.array([-0.9, -0.45, 0.0, 0.45, 0.9]) / 2  # of an exposure
COVERAGE_SD = 0.05  # of pixels that show only the seed and its background
CAUCHY = 2.4  # scale of the weights, in sds
STEPS = 10
NEAR_PX = 2.5  # beyond the outline, within which pixels are used
ROUND = 1.06  # ratio of axes below which an ellipse has no orientation


@dataclass(frozen=True)
class Ellipse:
    """Semi-axes [px] of the outline, a ≥ b."""

    a: float
    b: float

    @property
    def round(self) -> bool:
        return self.a < ROUND * self.b


@dataclass(frozen=True)
class EllipsePose:
    """The ellipse in one frame, px of the picture, y down. x, y: centre; turn:
    orientation [rad, clockwise]; streak: length of the motion blur; sd: of x and of y,
    each. edge_share: share of its edge that agrees with the edge seen."""

    x: float
    y: float
    turn: float
    streak: float
    sd: float
    edge_share: float


def ellipse_coverage(
    ellipse: Ellipse,
    u: np.ndarray,
    v: np.ndarray,
    turn: float,
    streak: tuple[float, float],
    blur_px: float,
) -> np.ndarray:
    """Coverage of pixels at (u, v) from the centre; streak: motion during the exposure
    (x, y); blur_px: sd of the blur."""
    out = np.zeros(u.shape)
    c, s = np.cos(turn), np.sin(turn)
    shares = INSTANTS if np.hypot(*streak) > 0.5 else INSTANTS[2:3]
    for share in shares:
        x, y = u - share * streak[0], v - share * streak[1]
        p, q = (x * c + y * s) / ellipse.a, (y * c - x * s) / ellipse.b
        g = np.hypot(p, q)
        away = g * (g - 1) / np.maximum(np.hypot(p / ellipse.a, q / ellipse.b), 1e-6)
        # the logistic curve next to the normal one
        out += 1 / (1 + np.exp(np.clip(1.702 * away / blur_px, -30, 30)))
    return out / len(shares)


def fit_ellipse(
    ellipse: Ellipse,
    patch: Patch,
    start: EllipsePose,
    direction: tuple[float, float],
    blur_px: float,
) -> EllipsePose | None:
    """The ellipse where most of its edge agrees with the edge seen; None where it
    agrees nowhere. start: first guess; direction: of the motion, unit vector, y down.
    Iteratively reweighted least squares."""
    rows, columns = (np.asarray(k, float) for k in np.indices(patch.coverage.shape))
    u: np.ndarray = columns + patch.x0 - start.x
    v: np.ndarray = rows + patch.y0 - start.y
    along = u * direction[0] + v * direction[1]
    near: np.ndarray = (
        np.hypot(u - direction[0] * along, v - direction[1] * along)
        < ellipse.a + NEAR_PX + 2
    )
    near &= np.abs(along) < ellipse.a + start.streak / 2 + NEAR_PX + 2
    near = near & np.isfinite(patch.error) & (np.hypot(u, v) > ellipse.b / 2)
    if near.sum() < 12:
        return None
    u, v, coverage = u[near], v[near], patch.coverage[near].astype(float)
    sd = np.hypot(patch.error[near].astype(float), COVERAGE_SD)
    free = [0, 1, *([] if ellipse.round else [2]), *([3] if start.streak > 0.5 else [])]
    p = np.array([0.0, 0.0, start.turn, start.streak])

    def model(p: np.ndarray) -> np.ndarray:
        streak = (direction[0] * p[3], direction[1] * p[3])
        return ellipse_coverage(ellipse, u - p[0], v - p[1], p[2], streak, blur_px)

    steps = np.array([0.1, 0.1, 0.02, 0.2])
    scale = 3.0  # of the Cauchy weights: wide at first
    for _ in range(STEPS):
        now = model(p)
        off = (coverage - now) / sd
        weight = 1 / (1 + (off / (CAUCHY * scale)) ** 2) / sd
        slope = np.column_stack(
            [(model(p + steps[k] * np.eye(4)[k]) - now) / steps[k] for k in free]
        )
        left, right = slope * weight[:, None], (coverage - now) * weight
        normal = left.T @ left + 1e-6 * np.eye(len(free))
        move = np.linalg.solve(normal, left.T @ right)
        limit = np.array([1.5, 1.5, 0.15, 2.0])[free]
        move = np.clip(move, -limit, limit)
        p[free] += move
        p[3] = float(np.clip(p[3], 0.0, 3 * ellipse.a + 2 * start.streak))
        if scale == 1.0 and np.abs(move[:2]).max() < 2e-3:
            break
        scale = max(1.0, scale / 1.5)
    edge = np.hypot(slope[:, 0], slope[:, 1])
    edge_share = float(
        (edge * (np.abs(off) < 2 * CAUCHY)).sum() / max(edge.sum(), 1e-9)
    )
    if np.hypot(p[0], p[1]) > ellipse.a:
        return None
    noise = max(1.0, robust_sd(off[edge > 0.3 * edge.max()]))
    inverse = np.linalg.inv(normal)
    error = noise * float(np.sqrt((inverse[0, 0] + inverse[1, 1]) / 2))
    return EllipsePose(
        start.x + p[0], start.y + p[1], float(p[2]), float(p[3]), error, edge_share
    )


def fit_ellipses(
    shapes: list[Silhouette], stated_px: tuple[float, float]
) -> list[EllipsePose | None] | None:
    """Pose of the ellipse in each frame, None where too little of its edge is seen.
    stated_px: least and greatest area of the stated seed. None as a whole where the
    silhouettes' centroids are unbiased, or no ellipse of constant axes fits."""
    x, y, area = np.array([(s.x, s.y, s.area) for s in shapes]).T
    if len(shapes) < 2 * LEAST_ROWS or _steady(area):
        return None
    vx, vy = np.gradient(x), np.gradient(y)
    speed = np.hypot(vx, vy)
    ellipse, clean = _estimate_ellipse(shapes, speed, stated_px)
    if clean.sum() < LEAST_ROWS or min(ellipse.a, ellipse.b) < 2:
        return None
    directions = [
        (u / max(s, 1e-9), v / max(s, 1e-9)) if s > RESTING_PX else (1.0, 0.0)
        for u, v, s in zip(vx, vy, speed)
    ]
    streak = _exposure(shapes, directions, speed, ellipse, clean) * speed
    start_poses = [
        _start_poses(s, ellipse, k, bool(c)) for s, k, c in zip(shapes, streak, clean)
    ]
    sample = np.flatnonzero(clean)[
        np.linspace(0, clean.sum() - 1, min(12, clean.sum())).astype(int)
    ]

    def best_pose(k: int, blur_px: float) -> EllipsePose | None:
        found = [
            fit_ellipse(ellipse, shapes[k].patch, start, directions[k], blur_px)
            for start in start_poses[k]
        ]
        return max(
            (pose for pose in found if pose is not None), key=_edge_share, default=None
        )

    blur = max(
        BLURS_PX,
        key=lambda blur_px: sum(_edge_share(best_pose(k, blur_px)) for k in sample),
    )
    poses = [best_pose(k, blur) for k in range(len(shapes))]
    if (
        np.median([_edge_share(poses[k]) for k in np.flatnonzero(clean)])
        < LEAST_MEDIAN_EDGE
    ):
        return None
    most = MOST_AREA * math.pi * ellipse.a * ellipse.b
    return [
        pose if _edge_share(pose) >= LEAST_EDGE and a < most else None
        for pose, a in zip(poses, area)
    ]


def _steady(area: np.ndarray) -> bool:
    """Whether the areas scatter so little that the silhouettes show the whole seed and
    nothing else."""
    off = np.abs(area / median_filter(area, 5, mode="mirror") - 1)
    deviating = np.abs(area / np.median(area) - 1) > MOST_DEVIATING
    return robust_sd(off) < AREA_SCATTER and float(deviating.mean()) < MOST_DEVIATING


def _estimate_ellipse(
    shapes: list[Silhouette], speed: np.ndarray, stated_px: tuple[float, float]
) -> tuple[Ellipse, np.ndarray]:
    """Axes of the ellipse from the slowest frames that show the seed alone, and which
    frames (n,) do."""
    area, cut = np.array([s.area for s in shapes]), np.array([s.cut for s in shapes])
    used = (speed > RESTING_PX) & ~cut
    used = used if used.sum() >= LEAST_ROWS else ~cut
    typical = float(np.median(area[used])) if used.any() else 0.0
    least, most = stated_px[0] * (1 - STATED_MARGIN), stated_px[1] * (1 + STATED_MARGIN)
    typical = float(np.clip(typical, least, most))
    clean = (np.abs(area / max(typical, 1e-9) - 1) < CLEAN) & ~cut
    calm = np.flatnonzero(clean)[np.argsort(speed[clean])][
        : max(LEAST_ROWS, int(clean.sum()) // 3)
    ]
    xx, yy, xy = _moments(shapes)[:, calm]
    # greatest and least second moment about the centroid
    middle, half = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    ratio = np.sqrt(np.maximum(middle + half, 1e-9) / np.maximum(middle - half, 1e-9))
    stretch = float(np.median(ratio)) if calm.size else 1.0
    radius = math.sqrt(typical / math.pi)
    return Ellipse(radius * math.sqrt(stretch), radius / math.sqrt(stretch)), clean


def _moments(shapes: list[Silhouette]) -> np.ndarray:
    """Second moments xx, yy, xy (3, n) about the centroids."""
    return np.array([(s.xx, s.yy, s.xy) for s in shapes]).T


def _exposure(
    shapes, directions, speed: np.ndarray, ellipse: Ellipse, clean: np.ndarray
) -> float:
    """Exposure time as a share of the frame interval: motion blur of length L adds
    L²/12 to the moment along the motion."""
    fast = np.flatnonzero(clean & (speed > 0.3 * ellipse.a))
    if len(fast) < 4:
        return 0.0
    (xx, yy, xy), (p, q) = _moments(shapes)[:, fast], np.array(directions)[fast].T
    along = xx * p * p + 2 * xy * p * q + yy * q * q
    across = xx * q * q - 2 * xy * p * q + yy * p * p
    still = across if ellipse.round else ellipse.a * ellipse.b / 4
    shares = np.sqrt(np.maximum(12 * (along - still), 0.0)) / speed[fast]
    return float(np.clip(np.median(shares), 0.0, 1.0))


def _start_poses(
    shape: Silhouette, ellipse: Ellipse, streak: float, clean: bool
) -> list[EllipsePose]:
    """First guesses of the pose: about the centroid, and below the top of the
    silhouette, which no shadow reaches."""
    turn = 0.5 * math.atan2(2 * shape.xy, shape.xx - shape.yy)
    first = EllipsePose(shape.x, shape.y, turn, float(streak), 0.0, 0.0)
    if clean:
        return [first]
    rows = np.flatnonzero((shape.patch.coverage > 0.5).sum(axis=1) > ellipse.b / 2)
    top = shape.patch.y0 + (float(rows[0]) if len(rows) else 0.0)
    return [first, replace(first, y=top + ellipse.b + streak / 2)]


def _edge_share(pose: EllipsePose | None) -> float:
    return 0.0 if pose is None else pose.edge_share
