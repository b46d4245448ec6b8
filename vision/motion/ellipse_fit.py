"""Robust fit of an ellipse with known axes to the pixels that a seed covers in one frame.

A shadow or a mirror image at the seed's foot enlarges what is seen, and before a background of its own colour a part of its rim is
missing. Both shift the centroid. The ellipse, blurred along its path by the exposure, is placed where most of its edge agrees with
the edge seen; the rest of the edge has no weight (Cauchy weights).
"""

from dataclasses import dataclass

import numpy as np

INSTANTS = np.array([-0.9, -0.45, 0.0, 0.45, 0.9]) / 2  # of an exposure
COVERAGE_SD = 0.05  # of pixels that show only the seed and its background
CAUCHY = 2.4  # scale of the weights, in sds
STEPS = 10
NEAR_PX = 2.5  # beyond the outline, within which pixels are used
ROUND = 1.06  # ratio of axes below which an ellipse has no orientation


@dataclass(frozen=True)
class Patch:
    """Coverage of the pixels about one thing, (h, w), and its sd (infinite where it is unknown); x0, y0: column and row of the first."""

    coverage: np.ndarray
    error: np.ndarray
    x0: int
    y0: int


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
    """The ellipse in one frame, px of the picture, y down.

    x, y: centre; turn: orientation [rad, clockwise]; streak: length of the motion blur; sd: of x and of y, each.
    edge_share: share of its edge that agrees with the edge seen.
    """

    x: float
    y: float
    turn: float
    streak: float
    sd: float
    edge_share: float


def ellipse_coverage(
    ellipse: Ellipse, u: np.ndarray, v: np.ndarray, turn: float, streak: tuple[float, float], blur_px: float
) -> np.ndarray:
    """Coverage of pixels at (u, v) from the centre; streak: motion during the exposure (x, y); blur_px: sd of the blur."""
    out = np.zeros(u.shape)
    c, s = np.cos(turn), np.sin(turn)
    shares = INSTANTS if np.hypot(*streak) > 0.5 else INSTANTS[2:3]
    for share in shares:
        x, y = u - share * streak[0], v - share * streak[1]
        p, q = (x * c + y * s) / ellipse.a, (y * c - x * s) / ellipse.b
        g = np.hypot(p, q)
        away = g * (g - 1) / np.maximum(np.hypot(p / ellipse.a, q / ellipse.b), 1e-6)
        out += 1 / (1 + np.exp(np.clip(1.702 * away / blur_px, -30, 30)))  # the logistic curve next to the normal one
    return out / len(shares)


def fit_ellipse(
    ellipse: Ellipse, patch: Patch, start: EllipsePose, direction: tuple[float, float], blur_px: float
) -> EllipsePose | None:
    """The ellipse where most of its edge agrees with the edge seen; None where it agrees nowhere.

    start: first guess; direction: of the motion, unit vector, y down. Iteratively reweighted least squares.
    """
    rows, columns = (np.asarray(k, float) for k in np.indices(patch.coverage.shape))
    u: np.ndarray = columns + patch.x0 - start.x
    v: np.ndarray = rows + patch.y0 - start.y
    along = u * direction[0] + v * direction[1]
    near: np.ndarray = np.hypot(u - direction[0] * along, v - direction[1] * along) < ellipse.a + NEAR_PX + 2
    near &= np.abs(along) < ellipse.a + start.streak / 2 + NEAR_PX + 2
    near = near & np.isfinite(patch.error) & (np.hypot(u, v) > ellipse.b / 2)
    if near.sum() < 12:
        return None
    u, v, seen = u[near], v[near], patch.coverage[near].astype(float)
    sd = np.hypot(patch.error[near].astype(float), COVERAGE_SD)
    free = [0, 1, *([] if ellipse.round else [2]), *([3] if start.streak > 0.5 else [])]
    p = np.array([0.0, 0.0, start.turn, start.streak])

    def model(p: np.ndarray) -> np.ndarray:
        return ellipse_coverage(ellipse, u - p[0], v - p[1], p[2], (direction[0] * p[3], direction[1] * p[3]), blur_px)

    steps = np.array([0.1, 0.1, 0.02, 0.2])
    scale = 3.0  # of the Cauchy weights: wide at first
    for _ in range(STEPS):
        now = model(p)
        off = (seen - now) / sd
        weight = 1 / (1 + (off / (CAUCHY * scale)) ** 2) / sd
        slope = np.column_stack([(model(p + steps[k] * np.eye(4)[k]) - now) / steps[k] for k in free])
        left, right = slope * weight[:, None], (seen - now) * weight
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
    edge_share = float((edge * (np.abs(off) < 2 * CAUCHY)).sum() / max(edge.sum(), 1e-9))
    if np.hypot(p[0], p[1]) > ellipse.a:
        return None
    noise = max(1.0, 1.4826 * float(np.median(np.abs(off[edge > 0.3 * edge.max()]))))
    inverse = np.linalg.inv(normal)
    error = noise * float(np.sqrt((inverse[0, 0] + inverse[1, 1]) / 2))
    return EllipsePose(start.x + p[0], start.y + p[1], float(p[2]), float(p[3]), error, edge_share)
