"""Sub-pixel outline of a grain: where the picture crosses the level half-way between
background and grain."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from benchtwin.bench.robust import robust_sd
from benchtwin.vision.shape.outline import about_ellipse

STEP_PX = 0.25
SMOOTH_RAD = 0.12
# above and below half height, between which the edge's blur is measured
LEVEL_STEP = 0.15
# error of the half-height level, of the height (shading, gloss, shadow)
LEVEL_SD = 0.05


@dataclass(frozen=True)
class Edge:
    """Edge points (n, 2) [px] in order around the grain.

    sd_px: of one point after smoothing; level_px: shift of the edge for an error
    LEVEL_SD of the level. lost, hidden, rim: shares of the points without an edge,
    covered by a neighbour (completed by an ellipse), and beside which something is
    brighter than the grain. softness: width of the softest tenth of the edge over that
    of the sharpest fifth (1.0–1.6 for seeds alone, about 2 where a shadow joins one).
    rim_drop: height of the middle less that of the rim, relative. lean: change of the
    edge's width with the direction of its normal (x, y), over its mean."""

    points: np.ndarray
    sd_px: float
    level_px: float
    lost: float
    hidden: float
    rim: float
    softness: float
    rim_drop: float
    lean: tuple[float, float]


def find_edge(height: np.ndarray, outline: np.ndarray, free: np.ndarray) -> Edge | None:
    """Refine a mask's `outline` (n, 2) [px] on the relief `height` (background 0,
    grains about 1); None where too little is free.

    Along each normal the crossing of the level half-way between the background outside
    and the grain inside is found, twice: from the mask's outline, and from the smooth
    outline that this gives. Shifts are smoothed over SMOOTH_RAD of the circumference.
    Blur of sd σ shrinks an edge of radius R by about σ²/(2R), which is corrected."""
    if free.sum() < 12:
        return None
    base = ndimage.gaussian_filter1d(outline, 2.0, axis=0, mode="wrap")
    normal = _normals(base)
    shifts = _edge_shifts(height, base, normal, free, 1.35)[0.5]
    good = np.isfinite(shifts) & free
    if good.sum() < 12:
        return None
    shift, _ = _smooth_known(shifts, good, 1.0)
    base, hidden = _resample(base + shift[:, None] * normal, good)
    if hidden.mean() > 0.75:
        return None
    normal, seen = _normals(base), ~hidden
    blur = _blur(_edge_shifts(height, base, normal, seen, 1.35), seen)
    shifts = _edge_shifts(height, base, normal, seen, blur)
    good = np.isfinite(shifts[0.5]) & seen
    if good.sum() < 12:
        return None
    width = SMOOTH_RAD * len(base) / (2 * np.pi)
    shift, sd = _smooth_known(shifts[0.5], good, width)
    # shrinkage due to blur
    shift += 0.5 * blur**2 * np.clip(_curvature(base, width), 0, 0.5)
    # Changes of the background along the edge (shadows) add a third of their size to
    # the error of the level.
    level_px = float(
        np.hypot(LEVEL_SD, shifts["uneven"] / 3) * np.sqrt(2 * np.pi) * blur
    )
    core = ndimage.map_coordinates(
        height, ((base + base.mean(0)) / 2).T[::-1], order=1, mode="nearest"
    )
    rim = float((shifts["peak"][seen] > 1.2 * np.median(core)).mean())
    rim_drop = 1 - shifts["inner"] / max(float(np.median(core)), 0.1)
    level_px *= 1 + 4 * max(rim_drop - 0.1, 0.0)  # a dark rim makes the level uncertain
    edge_width = (shifts[0.5 - LEVEL_STEP] - shifts[0.5 + LEVEL_STEP])[good]
    lean = _lean(edge_width, normal[good])
    softness = ndimage.median_filter(
        np.nan_to_num(edge_width, nan=4.0), size=_odd(len(edge_width) / 12), mode="wrap"
    )
    softness = float(
        np.percentile(softness, 90) / max(np.percentile(softness, 20), 0.3)
    )
    return Edge(
        base + shift[:, None] * normal,
        sd,
        level_px,
        float(1 - good.sum() / seen.sum()),
        float(hidden.mean()),
        rim,
        softness,
        rim_drop,
        lean,
    )


def _lean(width: np.ndarray, normal: np.ndarray) -> tuple[float, float]:
    """Least squares of the edge's width (n,) on its normals (n, 2), over its mean."""
    known = np.isfinite(width)
    most = np.percentile(width[known], 95) if known.any() else 1.0
    columns = np.column_stack([np.ones(known.sum()), normal[known]])
    mean, x, y = np.linalg.lstsq(columns, np.minimum(width[known], most), rcond=None)[0]
    return float(x / max(mean, 0.3)), float(y / max(mean, 0.3))


def _edge_shifts(
    height: np.ndarray,
    base: np.ndarray,
    normal: np.ndarray,
    free: np.ndarray,
    blur: float,
) -> dict:
    """Outward shifts [px] of each point to where the relief crosses half height and the
    two levels beside it, by level. Background and grain are sampled at 2.3 to 3.3 times
    the `blur` (sd of the edge, px) from the edge, since a grain's rim is darker than
    its middle. "peak": largest value just inside; "uneven": sd of the background along
    the edge, of the grain's height."""
    reach = max(3.6 * blur, 4.0)
    offsets = np.arange(-reach, reach + STEP_PX / 2, STEP_PX)
    place = base[:, None] + offsets[None, :, None] * normal[:, None]
    profile = ndimage.map_coordinates(
        height, [place[..., 1], place[..., 0]], order=1, mode="nearest"
    )
    beside = (np.abs(offsets) > 2.3 * blur) & (np.abs(offsets) < 3.3 * blur)
    inner, outer = (
        profile[:, beside & side].mean(1) for side in (offsets < 0, offsets > 0)
    )
    inner = ndimage.median_filter(inner, size=_odd(len(base) / 8), mode="wrap")
    typical = np.median(outer[free])
    # A shadow lowers the background locally (for light grains), a neighbour raises it:
    # only the first is used.
    known = np.where(free, outer, typical)
    size = _odd(len(base) / 12)
    outer = np.minimum(ndimage.median_filter(known, size=size, mode="wrap"), typical)
    shifts = {
        k: _crossing(profile, offsets, outer + k * (inner - outer))
        for k in (0.5 - LEVEL_STEP, 0.5, 0.5 + LEVEL_STEP)
    }
    uneven = float(np.std(outer[free]) / max(np.median(inner - outer), 0.05))
    peak = profile[:, offsets < 0].max(1)
    inside = float(np.median(inner[free]))
    return {**shifts, "peak": peak, "uneven": uneven, "inner": inside}


def _blur(shifts: dict, seen: np.ndarray) -> float:
    """sd [px] of the edge's blur from the distance of two levels: for a Gaussian edge,
    level step × √(2π) × sd."""
    edge_width = (shifts[0.5 - LEVEL_STEP] - shifts[0.5 + LEVEL_STEP])[seen]
    edge_width = edge_width[np.isfinite(edge_width)]
    if len(edge_width) < 8:
        return 1.35
    return float(
        np.clip(np.median(edge_width) / (2 * LEVEL_STEP * np.sqrt(2 * np.pi)), 1.0, 4.0)
    )


def _curvature(points: np.ndarray, width: float) -> np.ndarray:
    """Smoothed curvature 1/R [1/px] of a closed outline; positive where convex."""
    first, second = (
        ndimage.gaussian_filter1d(points, max(width, 1), axis=0, order=k, mode="wrap")
        for k in (1, 2)
    )
    speed = np.maximum(np.hypot(*first.T), 1e-6)
    turn = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / speed**3
    return turn if turn.sum() > 0 else -turn


def _crossing(
    profile: np.ndarray, offsets: np.ndarray, level: np.ndarray
) -> np.ndarray:
    """Offset at which each profile falls through its level, nearest to 0; NaN where it
    does not."""
    above = profile > level[:, None]
    falls = above[:, :-1] & ~above[:, 1:]
    away = np.where(falls, np.abs(offsets[:-1] + STEP_PX / 2), np.inf)
    at = away.argmin(1)
    rows = np.arange(len(profile))
    before, after = profile[rows, at], profile[rows, at + 1]
    found = offsets[at] + STEP_PX * (before - level) / np.where(
        before > after, before - after, 1
    )
    return np.where(falls.any(1), found, np.nan)


def _smooth_known(
    shift: np.ndarray, good: np.ndarray, width: float
) -> tuple[np.ndarray, float]:
    """Gaussian mean of the known shifts along the closed outline (twice, the second
    time without outliers), and its sd."""
    use = good.copy()
    for _ in range(2):
        weight = ndimage.gaussian_filter1d(use.astype(float), width, mode="wrap")
        smooth = ndimage.gaussian_filter1d(
            np.where(use, shift, 0.0), width, mode="wrap"
        ) / np.maximum(weight, 1e-6)
        rest = np.abs(np.where(good, shift, 0) - smooth)[good]
        spread = max(robust_sd(rest), 0.02)
        use = good & (np.abs(np.where(good, shift, np.inf) - smooth) < 4 * spread)
    smooth = np.where(weight > 0.02, smooth, 0.0)
    # Neighbouring points share the blur: about every second is independent.
    return smooth, float(spread * np.sqrt(2 / (2 * np.sqrt(np.pi) * width)))


def _resample(points: np.ndarray, free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The outline at even steps of about a pixel around the ellipse through its free
    points, and a mask of the hidden points. Hidden points, without a free point nearby,
    are on the ellipse."""
    for _ in range(3):  # twice without points off the ellipse: the neck to a neighbour
        place, middle, semi, turned = about_ellipse(points, free)
        depth = np.hypot(*place.T)
        off = np.abs(depth - 1) * np.sqrt(semi.prod())
        near = off < max(1.0, 4 * robust_sd(off[free]))
        if not free.all() and (free & near).sum() >= 12:
            free = free & near
    direction = np.mod(np.arctan2(*place[free].T[::-1]), 2 * np.pi)
    order = np.argsort(direction)
    direction, depth = direction[order], depth[free][order]
    count = int(np.clip(2 * np.pi * np.sqrt((semi**2).mean()), 48, 1500))
    t = 2 * np.pi * np.arange(count) / count
    after = np.searchsorted(direction, t)
    ahead = np.concatenate([direction, direction[:1] + 2 * np.pi])[after]
    behind = np.concatenate([direction[-1:] - 2 * np.pi, direction])[after]
    hidden = ahead - behind > max(0.15, 3.5 / np.sqrt(semi.prod()))
    depth = np.where(hidden, 1.0, np.interp(t, direction, depth, period=2 * np.pi))
    depth = ndimage.gaussian_filter1d(
        depth, SMOOTH_RAD * count / (2 * np.pi), mode="wrap"
    )
    outline = (depth * np.stack([np.cos(t), np.sin(t)])).T * semi
    return outline @ turned.T + middle, hidden


def _normals(points: np.ndarray) -> np.ndarray:
    """Outward unit normals of a closed outline, whichever way it runs."""
    along = np.roll(points, -2, 0) - np.roll(points, 2, 0)
    normal = (
        np.stack([along[:, 1], -along[:, 0]], -1)
        / np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    )
    x, y = points.T
    signed = float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
    return normal if signed > 0 else -normal


def _odd(value: float) -> int:
    return 2 * max(1, int(value / 2)) + 1
