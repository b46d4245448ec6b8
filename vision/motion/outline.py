"""A body of known and constant outline fitted to the pixels of each frame.

What a frame shows of a seed is its coverage of each pixel, right where nothing else changes: at its foot a shadow and a mirror image
cover the plate as well, and before a background of its own colour a part of its rim is missing. The centroid of what is seen goes
with them. The outline does not: an ellipse of constant axes, drawn out along its way by the time of exposure, is laid where most of
its edge meets the edge that is seen, and the rest of the edge counts for nothing (Cauchy weights).
"""

from dataclasses import dataclass

import numpy as np

INSTANTS = np.array([-0.9, -0.45, 0.0, 0.45, 0.9]) / 2  # of an exposure
TYPICAL = 0.05  # sd of a coverage that only the body and its background make
CAUCHY = 2.4  # sds beyond which an edge is another thing's
STEPS = 10
NEAR_PX = 2.5  # beyond the outline: pixels further off say nothing of it
ROUND = 1.06  # ratio of axes below which an ellipse has no direction
LEAST_EDGE = 0.5  # of the outline has to be met


@dataclass(frozen=True)
class Patch:
    """Coverage seen in the pixels about one thing, (h, w), and its sd (infinite where it cannot be told); x0, y0: the picture's column
    and row of the first pixel."""

    coverage: np.ndarray
    error: np.ndarray
    x0: int
    y0: int


@dataclass(frozen=True)
class Body:
    """Semi-axes [px] of the outline, a ≥ b."""

    a: float
    b: float

    @property
    def round(self) -> bool:
        return self.a < ROUND * self.b


@dataclass(frozen=True)
class Laid:
    """The outline laid into a frame: centre [px of the picture, y down], turn [rad, clockwise as seen], length of its streak [px], sd of
    the centre along each axis, share of its edge that is met."""

    x: float
    y: float
    turn: float
    streak: float
    sd: float
    met: float


def covered(body: Body, u: np.ndarray, v: np.ndarray, turn: float, streak: tuple[float, float], soft: float) -> np.ndarray:
    """Coverage of pixels at (u, v) from the centre; streak: (along x, along y) of its way during the exposure; soft: sd of the blur."""
    out = np.zeros(u.shape)
    c, s = np.cos(turn), np.sin(turn)
    shares = INSTANTS if np.hypot(*streak) > 0.5 else INSTANTS[2:3]
    for share in shares:
        x, y = u - share * streak[0], v - share * streak[1]
        p, q = (x * c + y * s) / body.a, (y * c - x * s) / body.b
        g = np.hypot(p, q)
        away = g * (g - 1) / np.maximum(np.hypot(p / body.a, q / body.b), 1e-6)
        out += 1 / (1 + np.exp(np.clip(1.702 * away / soft, -30, 30)))  # the logistic curve next to the normal one
    return out / len(shares)


def lay(body: Body, patch: Patch, start: Laid, way: tuple[float, float], soft: float) -> Laid | None:
    """The outline where most of its edge meets the edge seen; way: direction of motion (unit vector, y down). None where it meets none."""
    rows, columns = (np.asarray(k, float) for k in np.indices(patch.coverage.shape))
    u: np.ndarray = columns + patch.x0 - start.x
    v: np.ndarray = rows + patch.y0 - start.y
    near: np.ndarray = np.hypot(u - way[0] * (u * way[0] + v * way[1]), v - way[1] * (u * way[0] + v * way[1])) < body.a + NEAR_PX + 2
    near &= np.abs(u * way[0] + v * way[1]) < body.a + start.streak / 2 + NEAR_PX + 2
    near = near & np.isfinite(patch.error) & (np.hypot(u, v) > body.b / 2)
    if near.sum() < 12:
        return None
    u, v, seen = u[near], v[near], patch.coverage[near].astype(float)
    sd = np.hypot(patch.error[near].astype(float), TYPICAL)
    free = [0, 1, *([] if body.round else [2]), *([3] if start.streak > 0.5 else [])]
    p = np.array([0.0, 0.0, start.turn, start.streak])

    def model(p: np.ndarray) -> np.ndarray:
        return covered(body, u - p[0], v - p[1], p[2], (way[0] * p[3], way[1] * p[3]), soft)

    steps = np.array([0.1, 0.1, 0.02, 0.2])
    scale = 3.0  # from far and forgiving to close
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
        p[3] = float(np.clip(p[3], 0.0, 3 * body.a + 2 * start.streak))
        if scale == 1.0 and np.abs(move[:2]).max() < 2e-3:
            break
        scale = max(1.0, scale / 1.5)
    edge = np.hypot(slope[:, 0], slope[:, 1])
    met = float((edge * (np.abs(off) < 2 * CAUCHY)).sum() / max(edge.sum(), 1e-9))
    if np.hypot(p[0], p[1]) > body.a:
        return None
    noise = max(1.0, 1.4826 * float(np.median(np.abs(off[edge > 0.3 * edge.max()]))))
    inverse = np.linalg.inv(normal)
    error = noise * float(np.sqrt((inverse[0, 0] + inverse[1, 1]) / 2))
    return Laid(start.x + p[0], start.y + p[1], float(p[2]), float(p[3]), error, met)
