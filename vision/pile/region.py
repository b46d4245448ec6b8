"""The heap as one textured thing before several backgrounds: the triangle whose colours and texture differ most from what surrounds
it, then its outline by graph cut.

Where one smooth light lies on the background, boundary.py is far more precise; this finds which part of a picture is seeds where cloth,
wood, a horizon or a shelf stands behind them. (Rother, Kolmogorov & Blake, ACM Trans. Graphics 23 (2004) 309 for the cut.)
"""

from dataclasses import dataclass

import cv2
import numpy as np

from vision.pile.image import as_float, shrink

SEARCH_PX, SEEK_PX, CUT_PX = 96, 480, 480  # longest side: of the grid of triangles, of the picture described, of the close-up cut
WORDS = 20  # kinds of colour and texture that a picture is described by
SHELL = 0.45  # how far beyond the triangle its surroundings reach, of its height and half widths
SLOPES = (0.2, 1.3)  # rise : run of a heap's flanks
LOCAL = 0.08  # of the close-up's width: how far away colours count for what is seeds and what is not
RIVAL = 0.9  # of the best triangle's score: another one beside it is as likely the heap
FORM = 0.55  # of mask and triangle together that both cover: less is no heap
GRAINY = 1.7  # texture of the least grainy tenth of seeds (plain paper and its noise have 0 to 0.9, seeds in focus 2 to 5)
TRIES, ROUNDS, KEPT = 6000, 5, 24


@dataclass(frozen=True)
class Region:
    """Which pixels are seeds: mask of a close-up whose px are `factor` full px each and whose corner is `origin` in the picture.

    grown: the same by texture, a little too large; likeness: 1 where the inside is surely seeds, grainy all over and more so than
    around it, and of a heap's form; lower where less;
    contrast: how well colours and texture differ from those around (0–1); triangle: apex x, apex y, foot y, width to the left, to the
    right, in px of the picture; rival: the triangle of another part of it that looks as much like a heap.
    """

    mask: np.ndarray
    grown: np.ndarray
    likeness: float
    factor: float
    origin: tuple[int, int]
    contrast: float
    triangle: np.ndarray
    rival: np.ndarray | None


def describe(small: np.ndarray) -> np.ndarray:
    """Colour and texture at every pixel, float32 (h, w, 6): L, a, b, and logs of local contrast, of isotropy, of dark gaps."""
    lab = cv2.cvtColor(_coloured(small), cv2.COLOR_RGB2LAB)
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
    centres = cv2.kmeans(some, min(count, len(some)), np.zeros((len(some), 1), np.int32), stop, 1, cv2.KMEANS_PP_CENTERS)[2]
    distance = (centres**2).sum(axis=1) - 2 * flat @ centres.T
    return distance.argmin(axis=1).reshape(features.shape[:2])


def find_region(image: np.ndarray) -> Region | None:
    """The seeds in `image`; None where nothing triangular differs from its surroundings."""
    small, factor = shrink(image, SEEK_PX)
    features = describe(small)
    kinds = words(features, WORDS)
    triangle, contrast, rival = _best_triangle(kinds, features, max(1.0, max(kinds.shape) / SEARCH_PX))
    if triangle is None:
        return None
    rough = _cut(small, features, kinds, triangle)
    box, zoom = _close_up(image.shape, (triangle + 0.5) * factor)
    (x0, y0, x1, y1), triangle = box, triangle * factor
    close = cv2.resize(image[y0:y1, x0:x1], None, fx=1 / zoom, fy=1 / zoom, interpolation=cv2.INTER_AREA)
    scale = factor / zoom
    shift = [(0.5 * factor - 0.5 - corner) / zoom for corner in (x0, y0)]
    where = np.array([[scale, 0, shift[0]], [0, scale, shift[1]]], np.float32)
    grown = cv2.warpAffine(rough.astype(np.uint8), where, close.shape[1::-1], flags=cv2.INTER_NEAREST)
    inner = (triangle - [x0, y0, y0, 0, 0]) / zoom
    lab = cv2.cvtColor(_coloured(as_float(close)), cv2.COLOR_RGB2LAB)
    mask = _heap_of(_sharpened(lab, grown, 4 * factor / zoom), inner)
    if mask is None:
        return None
    grainy = cv2.warpAffine(features[..., 4], where, close.shape[1::-1])
    likeness = _likeness(mask, grainy, inner, 4 * factor / zoom)
    return Region(mask, grown > 0, likeness, zoom, (x0, y0), contrast, triangle, None if rival is None else rival * factor)


def _heap_of(mask: np.ndarray, triangle: np.ndarray) -> np.ndarray | None:
    """The one piece that fills most of the triangle, thin lines and single seeds beside it cut off, its gaps filled."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (max(3, round(0.1 * (triangle[2] - triangle[1]))) | 1,) * 2)
    count, labels = cv2.connectedComponents(cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, disc), connectivity=4)
    inside = np.bincount(labels[_drawn(mask.shape, triangle, 0.0)], minlength=count)
    inside[0] = 0
    if count < 2 or not inside.max():
        return None
    whole = np.zeros(mask.shape, np.uint8)
    contours = cv2.findContours((labels == inside.argmax()).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    cv2.drawContours(whole, contours, -1, 1, cv2.FILLED)
    return whole.astype(bool)


def _likeness(mask: np.ndarray, grainy: np.ndarray, triangle: np.ndarray, halo: float) -> float:
    """How much nine tenths of the inside are grainier than most of what lies around it, and its form a heap's: 1 is enough."""
    discs = [cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * round(r * halo) + 1,) * 2) for r in (2.0, 1.5, 6.0)]
    seeds = mask.astype(np.uint8)
    core = cv2.erode(seeds, discs[0]) > 0
    around = (cv2.dilate(seeds, discs[2]) > 0) & (cv2.dilate(seeds, discs[1]) == 0)
    form = _drawn(mask.shape, triangle, 0.0)
    if not core.any() or not around.any():
        return 0.0
    inside, outside = float(np.percentile(grainy[core], 10)), float(np.median(grainy[around]))
    covered = float((mask & form).sum() / (mask | form).sum())
    return min(covered / FORM, inside / GRAINY, (inside - outside) / (GRAINY / 2))


def _close_up(shape: tuple[int, ...], triangle: np.ndarray) -> tuple[tuple[int, int, int, int], float]:
    """The part of the picture about the triangle (x0, y0, x1, y1), and by how much it is shrunk to be cut."""
    x, top, foot, left, right = triangle
    wide, tall = 0.35 * (left + right), 0.6 * (foot - top)
    x0, x1 = (int(np.clip(v, 0, shape[1])) for v in (x - left - wide, x + right + wide))
    y0, y1 = (int(np.clip(v, 0, shape[0])) for v in (top - tall, foot + tall))
    return (x0, y0, x1, y1), max(1.0, max(x1 - x0, y1 - y0) / CUT_PX)


def _sharpened(lab: np.ndarray, grown: np.ndarray, halo: float) -> np.ndarray:
    """The rough outline, up to `halo` px too far out where texture was averaged, cut anew by colour, sharp and local."""
    disc = [cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * round(r * halo) + 1,) * 2) for r in (2.0, 0.5)]
    core, reach = cv2.erode(grown, disc[0]), cv2.dilate(grown, disc[1])
    odds = _local_odds(words(lab, 2 * WORDS), core > 0, reach == 0)
    sure, likely = (core > 0) & (odds > 0.4), (grown > 0) & (odds > 0.5)
    mask = np.where(sure, cv2.GC_FGD, np.where(reach == 0, cv2.GC_BGD, np.where(likely, cv2.GC_PR_FGD, cv2.GC_PR_BGD)))
    picture = np.dstack([255 * odds, 2.55 * lab[..., 0], 128 + lab[..., 1:] @ _chroma(lab, core > 0, reach == 0)])
    return _grabbed(picture, mask, rounds=3)


def _grabbed(picture: np.ndarray, mask: np.ndarray, rounds: int) -> np.ndarray:
    """The graph cut of a picture whose pixels are marked as sure or probable seeds and surroundings; no seeds where either lacks."""
    seeds = np.isin(mask, (cv2.GC_FGD, cv2.GC_PR_FGD))
    if not seeds.any() or seeds.all():
        return np.zeros(mask.shape, bool)
    mask = np.ascontiguousarray(mask, dtype=np.uint8)
    cv2.setRNGSeed(1)
    models = np.zeros((1, 65)), np.zeros((1, 65))
    cv2.grabCut(picture.clip(0, 255).astype(np.uint8), mask, (0, 0, 1, 1), *models, rounds, cv2.GC_INIT_WITH_MASK)
    return np.isin(mask, (cv2.GC_FGD, cv2.GC_PR_FGD))


def _coloured(small: np.ndarray) -> np.ndarray:
    """Float RGB 0–1, whatever the channels."""
    return np.ascontiguousarray(small if small.shape[2] == 3 else np.repeat(small[..., :1], 3, axis=2), dtype=np.float32) / 255


def _chroma(lab: np.ndarray, seeds: np.ndarray, others: np.ndarray) -> np.ndarray:
    """The direction in a, b from what is around towards the seeds."""
    off = lab[seeds, 1:].mean(axis=0) - lab[others, 1:].mean(axis=0) if seeds.any() and others.any() else np.ones(2)
    return (off / max(float(np.linalg.norm(off)), 1e-6)).astype(np.float32)


def _local_odds(kinds: np.ndarray, seeds: np.ndarray, others: np.ndarray) -> np.ndarray:
    """How much more often a pixel's colour is met among the seeds than among the surroundings nearest to it, 0 to 1."""
    size = (max(4, kinds.shape[1] // 4), max(4, kinds.shape[0] // 4))
    near = LOCAL * max(size)

    def density(where: np.ndarray, sigma: float) -> np.ndarray:
        return cv2.GaussianBlur(cv2.resize(where.astype(np.float32), size, interpolation=cv2.INTER_AREA), (0, 0), sigma)

    whole = [density(where, near) + 1e-6 for where in (seeds, others)]
    odds = np.zeros(kinds.shape, np.float32)
    for k in range(kinds.max() + 1):
        here = kinds == k
        inside, outside = (density(here & where, near) / total for where, total in zip((seeds, others), whole))
        log = cv2.resize(np.log((inside + 0.003) / (outside + 0.003)), kinds.shape[1::-1])
        odds[here] = log[here]
    return np.clip(cv2.GaussianBlur(odds, (0, 0), 0.7) / 8 + 0.5, 0, 1)


def _best_triangle(kinds: np.ndarray, features: np.ndarray, coarse: float):
    """Random triangles, the best refined: (apex x, apex y, foot y, left, right) in px of `kinds`, its contrast, and its rival."""
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
    best, high = _refined(sums, tries, score, texture, rng)
    if not high > 0:
        return None, 0.0, None
    beside = (tries[:, 0] + tries[:, 4] < best[0] - best[3]) | (tries[:, 0] - tries[:, 3] > best[0] + best[4])
    rival, second = (best, 0.0)
    if beside.any() and score[beside].max() > RIVAL * score.max():
        rival, second = _refined(sums, tries[beside], score[beside], texture, rng)
    contrast = float(_apart(*_histograms(sums, best[None]))[0])
    return best * coarse, contrast, rival * coarse if second > RIVAL * high else None


def _refined(sums: np.ndarray, tries: np.ndarray, score: np.ndarray, texture: np.ndarray, rng) -> tuple[np.ndarray, float]:
    """The best of the triangles after small moves of the best few, and its score."""
    for step in 0.1 * 0.6 ** np.arange(ROUNDS):
        best = tries[np.argsort(score)[-KEPT:]]
        size = np.c_[best[:, 3] + best[:, 4], best[:, 2] - best[:, 1]]
        moves = rng.normal(0, step, (40, len(best), 5)) * np.c_[size[:, 0], size[:, 1], size[:, 1], size[:, 0], size[:, 0]]
        moves[:, :, 3:][:, best[:, 3:] <= 0.5] = 0
        tries = np.concatenate([best[None], best + moves]).reshape(-1, 5)
        tries[:, 3:] = np.maximum(tries[:, 3:], 0.5)
        score = _score(sums, tries, texture)
    return tries[int(score.argmax())], float(score.max())


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
        grainy = _share(inside) @ texture - 0.5 * _share(around) @ texture
        out[some] = (_apart(inside, around) - alike + grainy) * inside.sum(axis=1) ** 0.05
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


def _cut(small: np.ndarray, features: np.ndarray, kinds: np.ndarray, triangle: np.ndarray) -> np.ndarray:
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
    return _grabbed(picture, mask, rounds=2)


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
