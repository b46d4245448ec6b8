"""A grain's edge to a fraction of a pixel: where the picture crosses half height between ground and grain."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy import ndimage

REACH_PX = 5.0  # the edge is sought this far to both sides of the mask's outline
STEP_PX = 0.25
LEVEL_SD = 0.05  # how well "half height" is known, as a share of the height (shading, gloss, shadow)


@dataclass(frozen=True)
class Edge:
    """Edge points (n, 2) [px] in order around the grain; `sd_px` of one point after smoothing; `level_px`: how far the
    edge moves per `LEVEL_SD` of height; `lost`: share of points at which no edge was found; `hidden`: of points that a
    neighbour covers, completed by an ellipse."""

    points: np.ndarray
    sd_px: float
    level_px: float
    lost: float
    hidden: float


def find_edge(height: np.ndarray, outline: np.ndarray, free: np.ndarray) -> Edge | None:
    """Refine a mask's `outline` (n, 2) [px] on the relief `height` (ground 0, grains about 1).

    Along each normal the crossing nearest to the outline of half of (ground beside it + grain inside it) is taken; the
    moves are smoothed along the outline over about a tenth of the grain's radius. The picture's own blur leaves a
    straight edge where it is and draws one of radius R in by about σ²/(2R). None when too little is free.
    """
    if free.sum() < 12:
        return None
    base = _smooth_closed(outline, 3.0)
    normal = _normals(base)
    offsets = np.arange(-REACH_PX, REACH_PX + STEP_PX / 2, STEP_PX)
    place = base[:, None] + offsets[None, :, None] * normal[:, None]
    profile = ndimage.map_coordinates(height, [place[..., 1], place[..., 0]], order=1, mode="nearest")
    inner = ndimage.median_filter(profile[:, offsets < -REACH_PX + 1.5].mean(1), size=_odd(len(base) / 8), mode="wrap")
    outer = float(np.median(profile[free][:, offsets > REACH_PX - 1.5]))
    moves = {level: _crossing(profile, offsets, outer + level * (inner - outer)) for level in (0.5 - LEVEL_SD, 0.5, 0.5 + LEVEL_SD)}
    good = np.isfinite(moves[0.5]) & free
    if good.sum() < 12:
        return None
    width = max(1.0, 0.1 * np.sqrt(len(base) ** 2 / (4 * np.pi**2)))
    move, sd = _smooth_known(moves[0.5], good, width)
    both = np.isfinite(moves[0.5 - LEVEL_SD]) & np.isfinite(moves[0.5 + LEVEL_SD]) & good
    level_px = float(np.median(np.abs(moves[0.5 - LEVEL_SD] - moves[0.5 + LEVEL_SD])[both])) / 2 if both.any() else 0.5
    points = base + move[:, None] * normal
    points, hidden = _complete(points, free)
    return Edge(points, sd, level_px, float(1 - good.sum() / free.sum()), hidden)


def _crossing(profile: np.ndarray, offsets: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Offset at which each profile falls through its level, nearest to 0; NaN where it does not."""
    above = profile > level[:, None]
    falls = above[:, :-1] & ~above[:, 1:]
    away = np.where(falls, np.abs(offsets[:-1] + STEP_PX / 2), np.inf)
    at = away.argmin(1)
    rows = np.arange(len(profile))
    before, after = profile[rows, at], profile[rows, at + 1]
    found = offsets[at] + STEP_PX * (before - level) / np.where(before > after, before - after, 1)
    return np.where(falls.any(1), found, np.nan)


def _smooth_known(move: np.ndarray, good: np.ndarray, width: float) -> tuple[np.ndarray, float]:
    """Gaussian mean of the known moves along the closed outline (twice, the second time without outliers) and its sd."""
    use = good.copy()
    for _ in range(2):
        weight = ndimage.gaussian_filter1d(use.astype(float), width, mode="wrap")
        smooth = ndimage.gaussian_filter1d(np.where(use, move, 0.0), width, mode="wrap") / np.maximum(weight, 1e-6)
        rest = np.abs(np.where(good, move, 0) - smooth)[good]
        spread = max(1.4826 * float(np.median(rest)), 0.02)
        use = good & (np.abs(np.where(good, move, np.inf) - smooth) < 4 * spread)
    smooth = np.where(weight > 0.02, smooth, 0.0)
    # Neighbouring points share the blur: about every second is independent.
    return smooth, float(spread * np.sqrt(2 / (2 * np.sqrt(np.pi) * width)))


def _complete(points: np.ndarray, free: np.ndarray) -> tuple[np.ndarray, float]:
    """Replace the points on a cut by the ellipse through the free ones."""
    if free.all():
        return points, 0.0
    for _ in range(3):  # twice without points that stand off the ellipse: the neck to a neighbour
        (cx, cy), axes, angle = cv2.fitEllipseDirect(points[free].astype(np.float32))
        turn, semi = np.radians(angle), np.maximum(np.asarray(axes) / 2, 0.5)
        x, y = points[:, 0] - cx, points[:, 1] - cy
        along, across = x * np.cos(turn) + y * np.sin(turn), -x * np.sin(turn) + y * np.cos(turn)
        off = np.abs(np.hypot(along / semi[0], across / semi[1]) - 1) * np.sqrt(semi.prod())
        near = off < max(1.0, 4 * 1.4826 * float(np.median(off[free])))
        free = free & near if (free & near).sum() >= 12 else free
    direction = np.arctan2(across / semi[1], along / semi[0])
    # All of the hidden arc, not only the cut's few points: fill the largest gap in direction evenly.
    angles = np.sort(np.mod(direction[free], 2 * np.pi))
    gaps = np.diff(np.concatenate([angles, angles[:1] + 2 * np.pi]))
    fill = [a + g * np.linspace(0, 1, int(g / 0.03) + 2)[1:-1] for a, g in zip(angles, gaps) if g > 0.12]
    hidden = float(sum(g for g in gaps if g > 0.12) / (2 * np.pi))
    t = np.concatenate(fill) if fill else np.empty(0)
    along, across = semi[0] * np.cos(t), semi[1] * np.sin(t)
    arc = np.stack([cx + along * np.cos(turn) - across * np.sin(turn), cy + along * np.sin(turn) + across * np.cos(turn)], -1)
    every = np.concatenate([points[free], arc])
    order = np.argsort(np.arctan2(every[:, 1] - cy, every[:, 0] - cx))
    return every[order], hidden


def _smooth_closed(outline: np.ndarray, width: float) -> np.ndarray:
    """Smooth the stair-case of pixels; a circle of radius R would shrink by width²/(2R), which the crossing undoes."""
    return ndimage.gaussian_filter1d(outline, width, axis=0, mode="wrap")


def _normals(points: np.ndarray) -> np.ndarray:
    """Outward unit normals of a closed outline, whichever way it runs."""
    along = np.roll(points, -2, 0) - np.roll(points, 2, 0)
    normal = np.stack([along[:, 1], -along[:, 0]], -1) / np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    x, y = points.T
    signed = float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
    return normal if signed > 0 else -normal


def _odd(value: float) -> int:
    return 2 * max(1, int(value / 2)) + 1
