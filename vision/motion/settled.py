"""Silhouettes of one film → the constant outline that all of them show, and where it lies in each frame."""

import math
from dataclasses import replace

import numpy as np

from vision.motion.detect import Silhouette
from vision.motion.outline import Body, Laid, lay

STILL_PX = 0.3  # a step of less in a frame is rest
CLEAN = 0.08  # an area this near to the body's is the body alone
SCATTER, ODD = 0.01, 0.05  # of areas about their neighbours', above which the centroid goes with what else is seen; share of odd ones
STATED_MARGIN = 0.05  # of a stated area: no seed is quite an ellipse
LEAST_ROWS = 8
SOFT_PX = (0.45, 0.6, 0.8, 1.1, 1.5)  # sds of blur that are tried
LEAST_MET = 0.5  # of the outline's edge in one frame
MOST_SEEN = 2.2  # of the body's area: it, its mirror image and some shadow
SUITS = 0.75  # of the edge, usually: below it no constant ellipse is what moves


def settle(shapes: list[Silhouette], stated_px: tuple[float, float]) -> tuple[list[Laid | None], Body] | None:
    """The outline in each frame (None where too little of it is seen), and its axes.

    stated_px: least and greatest area it can have. None where the silhouettes' own centroids are good, or no constant ellipse suits them.
    """
    x, y, area = np.array([(s.x, s.y, s.area) for s in shapes]).T
    if len(shapes) < 2 * LEAST_ROWS or _steady(area):
        return None
    vx, vy = np.gradient(x), np.gradient(y)
    speed = np.hypot(vx, vy)
    body, clean = _learn(shapes, speed, stated_px)
    if clean.sum() < LEAST_ROWS or min(body.a, body.b) < 2:
        return None
    ways = [(u / max(s, 1e-9), v / max(s, 1e-9)) if s > STILL_PX else (1.0, 0.0) for u, v, s in zip(vx, vy, speed)]
    streak = _exposure(shapes, ways, speed, body, clean) * speed
    starts = [_starts(s, body, k, bool(c)) for s, k, c in zip(shapes, streak, clean)]
    sample = np.flatnonzero(clean)[np.linspace(0, clean.sum() - 1, min(12, clean.sum())).astype(int)]
    soft = max(SOFT_PX, key=lambda soft: sum(_met(_best(body, shapes[i], starts[i], ways[i], soft)) for i in sample))
    laid = [_best(body, s, start, way, soft) for s, start, way in zip(shapes, starts, ways)]
    if np.median([_met(laid[i]) for i in np.flatnonzero(clean)]) < SUITS:
        return None
    most = MOST_SEEN * math.pi * body.a * body.b
    return [one if one is not None and one.met >= LEAST_MET and a < most else None for one, a in zip(laid, area)], body


def _steady(area: np.ndarray) -> bool:
    """Whether the areas follow their neighbours so closely that nothing else than the body is seen, nor any of it missed."""
    padded = np.pad(area, 2, mode="reflect")
    off = np.abs(area / np.median(np.lib.stride_tricks.sliding_window_view(padded, 5), axis=1) - 1)
    return 1.4826 * float(np.median(off)) < SCATTER and float((np.abs(area / np.median(area) - 1) > ODD).mean()) < ODD


def _learn(shapes: list[Silhouette], speed: np.ndarray, stated_px: tuple[float, float]) -> tuple[Body, np.ndarray]:
    """The body's axes from the slowest of the frames that show it alone, and which frames show it alone."""
    area, cut = np.array([s.area for s in shapes]), np.array([s.cut for s in shapes])
    used = (speed > STILL_PX) & ~cut
    used = used if used.sum() >= LEAST_ROWS else ~cut
    usual = float(np.median(area[used])) if used.any() else 0.0
    usual = float(np.clip(usual, stated_px[0] * (1 - STATED_MARGIN), stated_px[1] * (1 + STATED_MARGIN)))
    clean = (np.abs(area / max(usual, 1e-9) - 1) < CLEAN) & ~cut
    calm = np.flatnonzero(clean)[np.argsort(speed[clean])][: max(LEAST_ROWS, int(clean.sum()) // 3)]
    ratio = [math.sqrt(max(_along(shapes[i])[0], 1e-9) / max(_along(shapes[i])[1], 1e-9)) for i in calm]
    stretch = float(np.median(ratio)) if ratio else 1.0
    radius = math.sqrt(usual / math.pi)
    return Body(radius * math.sqrt(stretch), radius / math.sqrt(stretch)), clean


def _along(shape: Silhouette) -> tuple[float, float]:
    """Greatest and least second moment."""
    middle, half = (shape.xx + shape.yy) / 2, math.hypot((shape.xx - shape.yy) / 2, shape.xy)
    return middle + half, middle - half


def _turn(shape: Silhouette) -> float:
    return 0.5 * math.atan2(2 * shape.xy, shape.xx - shape.yy)


def _exposure(shapes, ways, speed: np.ndarray, body: Body, clean: np.ndarray) -> float:
    """Share of a frame that the shutter is open for: streaks are that share of the way, and add length² / 12 to a moment along it."""
    fast = np.flatnonzero(clean & (speed > 0.3 * body.a))
    if len(fast) < 4:
        return 0.0
    shares = []
    for i in fast:
        s, (p, q) = shapes[i], ways[i]
        along, across = s.xx * p * p + 2 * s.xy * p * q + s.yy * q * q, s.xx * q * q - 2 * s.xy * p * q + s.yy * p * p
        own = across if body.round else body.a * body.b / 4
        shares.append(math.sqrt(max(12 * (along - own), 0.0)) / speed[i])
    return float(np.clip(np.median(shares), 0.0, 1.0))


def _starts(shape: Silhouette, body: Body, streak: float, clean: bool) -> list[Laid]:
    """Where the outline may lie: about the centroid, or hanging from the top of what is seen, which no shadow reaches."""
    first = Laid(shape.x, shape.y, _turn(shape), float(streak), 0.0, 0.0)
    if clean:
        return [first]
    rows = np.flatnonzero((shape.patch.coverage > 0.5).sum(axis=1) > body.b / 2)
    top = shape.patch.y0 + (float(rows[0]) if len(rows) else 0.0)
    return [first, replace(first, y=top + body.b + streak / 2)]


def _best(body: Body, shape: Silhouette, starts: list[Laid], way: tuple[float, float], soft: float) -> Laid | None:
    found = [lay(body, shape.patch, start, way, soft) for start in starts]
    return max((one for one in found if one is not None), key=_met, default=None)


def _met(laid: Laid | None) -> float:
    return 0.0 if laid is None else laid.met
