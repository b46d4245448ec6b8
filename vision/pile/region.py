"""The heap as one textured thing before several backgrounds: the triangle whose colours and texture differ most from what surrounds
it, then its outline by graph cut.

Where one smooth light lies on the background, boundary.py is far more precise; this finds which part of a picture is seeds where cloth,
wood, a horizon or a shelf stands behind them. (Rother, Kolmogorov & Blake, ACM Trans. Graphics 23 (2004) 309 for the cut.)
"""

from dataclasses import dataclass

import cv2
import numpy as np

from vision.pile.image import shrink

SEARCH_PX, CUT_PX = 96, 480  # longest side of the pictures on which the triangle is sought, and its outline cut
WORDS = 20  # kinds of colour and texture that a picture is described by
SHELL = 0.45  # how far beyond the triangle its surroundings reach, of its height and half widths
SLOPES = (0.2, 1.3)  # rise : run of a heap's flanks
TRIES, ROUNDS, KEPT = 6000, 5, 24


@dataclass(frozen=True)
class Region:
    """Which pixels of the small picture (`factor` full px each) are seeds, and how well they differ from what is around (0–1)."""

    mask: np.ndarray
    factor: float
    contrast: float
    triangle: np.ndarray  # apex x, apex y, foot y, width to the left, to the right, in small px


def describe(small: np.ndarray) -> np.ndarray:
    """Colour and texture at every pixel, float32 (h, w, 6): L, a, b, and logs of local contrast, of isotropy, of dark gaps."""
    rgb = np.ascontiguousarray(small[..., :3] if small.shape[2] >= 3 else np.repeat(small, 3, axis=2)) / np.float32(255)
    lab = cv2.cvtColor(rgb, cv2.COLOR_RGB2LAB)
    light = cv2.GaussianBlur(lab[..., 0], (0, 0), 0.7)
    reach = small.shape[1] / 120
    mean = cv2.GaussianBlur(light, (0, 0), reach)
    contrast = np.sqrt(np.clip(cv2.GaussianBlur(light**2, (0, 0), reach) - mean**2, 0, None))
    gx, gy = cv2.Sobel(light, cv2.CV_32F, 1, 0) / 8, cv2.Sobel(light, cv2.CV_32F, 0, 1) / 8
    xx, yy, xy = (cv2.GaussianBlur(g, (0, 0), reach) for g in (gx * gx, gy * gy, gx * gy))
    weaker = (xx + yy) / 2 - np.sqrt(((xx - yy) / 2) ** 2 + xy**2)  # of the structure tensor: nil along an edge or a stripe
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * round(reach) + 1,) * 2)
    gaps = cv2.GaussianBlur(cv2.morphologyEx(light, cv2.MORPH_BLACKHAT, disc), (0, 0), reach)
    texture = [np.log(1 + contrast), np.log(1 + 2 * np.sqrt(np.clip(weaker, 0, None))), np.log(1 + gaps)]
    return np.dstack([cv2.GaussianBlur(lab, (0, 0), 1.0) / 20, *(2 * t for t in texture)]).astype(np.float32)


def words(features: np.ndarray, count: int) -> np.ndarray:
    """Every pixel's kind, 0 … count − 1 (h, w): k-means on a part of the pixels, nearest centre for all."""
    flat = features.reshape(-1, features.shape[2])
    cv2.setRNGSeed(1)
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 12, 0.01)
    some = np.ascontiguousarray(flat[:: max(1, len(flat) // 8000)])
    centres = cv2.kmeans(some, min(count, len(some)), None, stop, 1, cv2.KMEANS_PP_CENTERS)[2]
    distance = (centres**2).sum(axis=1) - 2 * flat @ centres.T
    return distance.argmin(axis=1).reshape(features.shape[:2])


def find_region(image: np.ndarray) -> Region | None:
    """The seeds in `image`; None where nothing triangular differs from its surroundings."""
    small, factor = shrink(image, CUT_PX)
    features = describe(small)
    kinds = words(features, WORDS)
    coarse = max(1.0, max(kinds.shape) / SEARCH_PX)
    triangle, contrast = _best_triangle(kinds, features, coarse)
    if triangle is None:
        return None
    mask = _cut(small, features, kinds, triangle)
    return None if mask is None else Region(mask, factor, contrast, triangle)


def _best_triangle(kinds: np.ndarray, features: np.ndarray, coarse: float) -> tuple[np.ndarray | None, float]:
    """Random triangles, the best refined: (apex x, apex y, foot y, left, right) in px of `kinds`, and its contrast."""
    height, width = (max(8, round(n / coarse)) for n in kinds.shape)
    layers = [cv2.resize((kinds == k).astype(np.float32), (width, height), interpolation=cv2.INTER_AREA) for k in range(kinds.max() + 1)]
    sums = np.zeros((height + 1, width, len(layers)), np.float32)
    np.cumsum(np.dstack(layers), axis=0, out=sums[1:])
    texture = np.bincount(kinds.ravel(), features[..., 4].ravel()) / np.maximum(np.bincount(kinds.ravel()), 1)
    texture = texture / max(texture.max(), 1e-6)
    rng = np.random.default_rng(0)
    tall = rng.uniform(0.08, 0.8, TRIES) * height
    foot = rng.uniform(0.3, 1.0, TRIES) * height
    left, right = (tall / rng.uniform(*SLOPES, TRIES) for _ in "lr")
    upright = rng.integers(0, 6, TRIES)  # a third lean on a wall
    left[upright == 0], right[upright == 1] = 0.5, 0.5
    tries = np.c_[rng.uniform(0.02, 0.98, TRIES) * width, foot - tall, foot, left, right]
    score = _score(sums, tries, texture)
    for step in 0.1 * 0.6 ** np.arange(ROUNDS):
        best = tries[np.argsort(score)[-KEPT:]]
        size = np.c_[best[:, 3] + best[:, 4], best[:, 2] - best[:, 1]]
        moves = rng.normal(0, step, (40, KEPT, 5)) * np.c_[size[:, 0], size[:, 1], size[:, 1], size[:, 0], size[:, 0]]
        moves[:, :, 3:][:, best[:, 3:] <= 0.5] = 0
        tries = np.concatenate([best[None], best + moves]).reshape(-1, 5)
        tries[:, 3:] = np.maximum(tries[:, 3:], 0.5)
        score = _score(sums, tries, texture)
    at = int(score.argmax())
    if not score[at] > 0:
        return None, 0.0
    inside, around = _histograms(sums, tries[at : at + 1])
    return tries[at] * coarse, float(_apart(inside, around)[0])


def _score(sums: np.ndarray, tries: np.ndarray, texture: np.ndarray) -> np.ndarray:
    """How much the surroundings' mixture of kinds differs from the triangle's, times the triangle's area; −1: no heap."""
    height, width = sums.shape[0] - 1, sums.shape[1]
    x, top, foot, left, right = tries.T
    rise = foot - top
    steep = np.minimum(*(np.where(side <= 0.5, 9.0, rise / np.maximum(side, 1e-3)) for side in (left, right)))
    gentle = rise / np.maximum(left, right)
    ok = (gentle > SLOPES[0]) & (steep < SLOPES[1]) & (top > 0.02 * height) & (foot <= height) & (rise > 0.06 * height)
    ok &= (x - left > -0.15 * width) & (x + right < 1.15 * width)
    out = np.full(len(tries), -1.0)
    for some in np.array_split(np.flatnonzero(ok), max(1, ok.sum() // 1500)):
        inside, around = _histograms(sums, tries[some])
        core = _count(sums, *_shrunk(tries[some]).T)
        alike = _apart(core, np.maximum(inside - core, 0.0))
        grainy = _share(inside) @ texture - _share(around) @ texture
        out[some] = (_apart(inside, around) - alike + 0.5 * grainy) * inside.sum(axis=1) ** 0.15
    return out


def _shrunk(tries: np.ndarray) -> np.ndarray:
    """The inner half (by area) of the triangles."""
    x, top, foot, left, right = tries.T
    rise, centre = foot - top, x + (right - left) / 3
    new = 0.7 * (x - centre) + centre
    return np.c_[new, top + 0.2 * rise, top + 0.9 * rise, 0.7 * left, 0.7 * right]


def _share(counts: np.ndarray) -> np.ndarray:
    return counts / np.maximum(counts.sum(axis=1, keepdims=True), 1e-9)


def _histograms(sums: np.ndarray, tries: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How many pixels of each kind lie in the triangles and in the shells around them, (m, kinds) each."""
    x, top, foot, left, right = tries.T
    rise = foot - top
    inside = _count(sums, x, top, foot, left, right)
    wide = SHELL * (left + right) / 2
    outside = _count(sums, x, top - SHELL * rise, foot + SHELL * rise / 2, left + wide, right + wide)
    return inside, np.maximum(outside - inside, 0.0)


def _count(sums, x, top, foot, left, right) -> np.ndarray:
    height, columns = sums.shape[0] - 1, np.arange(sums.shape[1]) + 0.5
    off = columns - x[:, None]
    share = np.clip(1 - np.where(off < 0, -off / left[:, None], off / right[:, None]), 0, 1)
    upper = np.clip(np.rint(foot[:, None] - (foot - top)[:, None] * share), 0, height).astype(int)
    lower = np.broadcast_to(np.clip(np.rint(foot), 0, height).astype(int)[:, None], upper.shape)
    upper = np.minimum(upper, lower)
    at = np.arange(sums.shape[1])
    return (sums[lower, at] - sums[upper, at]).sum(axis=1)


def _apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Jensen–Shannon divergence of two histograms, 0 (alike) to 1 (nothing in common)."""
    p, q = _share(a), _share(b)
    m = (p + q) / 2
    with np.errstate(divide="ignore", invalid="ignore"):
        kl = [np.where(h > 0, h * np.log2(h / m), 0.0).sum(axis=1) for h in (p, q)]
    return (kl[0] + kl[1]) / 2


def _cut(small: np.ndarray, features: np.ndarray, kinds: np.ndarray, triangle: np.ndarray) -> np.ndarray | None:
    """The outline by graph cut, on a picture of colour and of how much more often a pixel's kind lies inside than outside."""
    core, body, shell = (_drawn(kinds.shape, triangle, grow) for grow in (-0.35, 0.0, 0.8))
    mask = np.where(core, cv2.GC_FGD, np.where(body, cv2.GC_PR_FGD, np.where(shell, cv2.GC_PR_BGD, cv2.GC_BGD))).astype(np.uint8)
    near = _drawn(kinds.shape, triangle, 1.5)
    inside = np.bincount(kinds[body], minlength=WORDS) / max(body.sum(), 1) + 1e-3
    outside = np.bincount(kinds[near & ~body], minlength=WORDS) / max((near & ~body).sum(), 1) + 1e-3
    odds = np.clip(np.log(inside / outside) / 6 + 0.5, 0, 1)[kinds]
    odds = cv2.GaussianBlur(odds.astype(np.float32), (0, 0), 1.0)
    colour = features[..., :3] * 20
    within = np.cov(colour[body].T) + np.cov(colour[near & ~body].T) + np.eye(3)
    axis = np.linalg.solve(within, colour[body].mean(axis=0) - colour[near & ~body].mean(axis=0))
    along = colour @ (axis / max(np.linalg.norm(axis), 1e-9)).astype(np.float32)
    low, high = np.percentile(along, [1, 99])
    picture = np.dstack([255 * odds, 255 * np.clip((along - low) / max(high - low, 1.0), 0, 1), colour[..., 0] * 2.55])
    cv2.setRNGSeed(1)
    cv2.grabCut(picture.clip(0, 255).astype(np.uint8), mask, None, np.zeros((1, 65)), np.zeros((1, 65)), 4, cv2.GC_INIT_WITH_MASK)
    seeds = np.isin(mask, (cv2.GC_FGD, cv2.GC_PR_FGD)).astype(np.uint8)
    return seeds.astype(bool)


def _drawn(shape: tuple[int, ...], triangle: np.ndarray, grow: float) -> np.ndarray:
    """The triangle grown by that share of its height and half widths about itself, as a mask."""
    x, top, foot, left, right = triangle
    rise, wide = foot - top, grow * (left + right) / 2
    points = [(x - left - wide, foot + grow * rise / 2), (x, top - grow * rise), (x + right + wide, foot + grow * rise / 2)]
    if grow > 0:  # flanks may bulge
        points[1:2] = [(x - 0.3 * left - wide / 2, top - grow * rise), (x + 0.3 * right + wide / 2, top - grow * rise)]
    mask = np.zeros(shape[:2], np.uint8)
    cv2.fillPoly(mask, [np.array(points).round().astype(np.int32)], 1)
    return mask.astype(bool)
