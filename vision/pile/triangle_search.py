"""Where in a picture is the heap? The triangle whose colours and texture differ most
from its surroundings.

Random triangles are scored by integral images of the pixels' clusters; the best are
refined by small random moves. A triangle is (apex x, apex y, foot y, width to the left,
width to the right) [px]."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from scipy.special import rel_entr

# how far the surroundings reach beyond the triangle, of its height and half widths
SHELL = 0.45
SLOPES = (0.2, 1.3)  # rise : run of a heap's flanks
# of the best score: another triangle with more beside it may as well be the heap
RIVAL = 0.9


@dataclass(frozen=True)
class Score:
    """How a triangle's evidence is counted: seeds are grainy, by that weight; a heap is
    large, by that power of its pixels."""

    grainy: float
    large: float


# grainy seeds before whatever there is; what is large and of one colour, glaring or not
SCORES = (Score(1.0, 0.05), Score(0.0, 0.5))
TRIES, ROUNDS, KEPT = 6000, 5, 24
NO_SIDE = 0.5  # px: the width to a side on which the heap leans on a wall


@dataclass(frozen=True)
class Found:
    """The best triangle (None: nothing differs) and its score; its rival, if there is
    one."""

    triangle: np.ndarray | None = None
    score: float = 0.0
    rival: np.ndarray | None = None


@dataclass(frozen=True)
class _Layers:
    """sums (h + 1, columns, clusters): pixels of each cluster above each row, in some
    of a picture's `width` columns, whose middles are x; left (h + 1, columns + 1,
    clusters): those in all columns to the left."""

    sums: np.ndarray
    x: np.ndarray
    width: int

    @cached_property
    def left(self) -> np.ndarray:
        return np.pad(np.cumsum(self.sums, axis=1), ((0, 0), (1, 0), (0, 0)))

    @property
    def height(self) -> int:
        return self.sums.shape[0] - 1


def best_triangle(
    clusters: np.ndarray, texture: np.ndarray, coarse: float, by: Score
) -> Found:
    """The best triangle in px of `clusters`. clusters (h, w): each pixel's cluster;
    texture (h, w); coarse: by how much the picture is reduced for the search; by: how
    its evidence is counted."""
    height, width = (max(8, round(n / coarse)) for n in clusters.shape)
    members = [(clusters == k).astype(np.float32) for k in range(clusters.max() + 1)]
    layers = [
        cv2.resize(m, (width, height), interpolation=cv2.INTER_AREA) for m in members
    ]
    sums = np.zeros((height + 1, width, len(layers)), np.float32)
    np.cumsum(np.dstack(layers), axis=0, out=sums[1:])
    x = np.arange(width) + 0.5
    whole = _Layers(sums, x, width)
    half = _Layers(np.ascontiguousarray(sums[:, ::2]), x[::2], width)  # of the columns
    of_cluster = np.bincount(clusters.ravel(), texture.ravel()) / np.maximum(
        np.bincount(clusters.ravel()), 1
    )
    of_cluster = of_cluster / max(of_cluster.max(), 1e-6)
    rng = np.random.default_rng(0)
    rise = rng.uniform(0.08, 0.8, TRIES) * height
    foot = rng.uniform(0.3, 1.0, TRIES) * height
    left, right = (rise / rng.uniform(*SLOPES, TRIES) for _ in "lr")
    wall = rng.integers(0, 6, TRIES)  # a third lean on a wall
    left[wall == 0], right[wall == 1] = NO_SIDE, NO_SIDE
    triangles = np.c_[
        rng.uniform(0.02, 0.98, TRIES) * width, foot - rise, foot, left, right
    ]
    score = _score(half, triangles, of_cluster, by)
    best, high = _refine_best(whole, triangles, score, of_cluster, by, rng)
    if not high > 0:
        return Found()
    beside = (triangles[:, 0] + triangles[:, 4] < best[0] - best[3]) | (
        triangles[:, 0] - triangles[:, 3] > best[0] + best[4]
    )
    rival, second = (best, 0.0)
    if beside.any() and score[beside].max() > RIVAL * score.max():
        rival, second = _refine_best(
            whole, triangles[beside], score[beside], of_cluster, by, rng
        )
    return Found(best * coarse, high, rival * coarse if second > RIVAL * high else None)


def _refine_best(
    layers: _Layers,
    triangles: np.ndarray,
    score: np.ndarray,
    texture: np.ndarray,
    by: Score,
    rng: np.random.Generator,
) -> tuple[np.ndarray, float]:
    """The best of the triangles after small moves of the best few, and its score."""
    for step in 0.1 * 0.6 ** np.arange(ROUNDS):
        best = triangles[np.argsort(score)[-KEPT:]]
        size = np.c_[best[:, 3] + best[:, 4], best[:, 2] - best[:, 1]]
        moves = (
            rng.normal(0, step, (40, len(best), 5))
            * np.c_[size[:, 0], size[:, 1], size[:, 1], size[:, 0], size[:, 0]]
        )
        moves[:, :, 3:][:, best[:, 3:] <= NO_SIDE] = 0
        triangles = np.concatenate([best[None], best + moves]).reshape(-1, 5)
        triangles[:, 3:] = np.maximum(triangles[:, 3:], NO_SIDE)
        score = _score(layers, triangles, texture, by)
    return triangles[int(score.argmax())], float(score.max())


def _score(
    layers: _Layers, triangles: np.ndarray, texture: np.ndarray, by: Score
) -> np.ndarray:
    """How much each triangle looks like a heap: contrast to its surroundings, evenness,
    texture; −1 where its form is no heap's."""
    height, width = layers.height, layers.width
    x, top, foot, left, right = triangles.T
    rise = foot - top
    slopes = [
        np.where(side <= NO_SIDE, 9.0, rise / np.maximum(side, 1e-3))
        for side in (left, right)
    ]
    steep = np.minimum(*slopes)
    gentle = rise / np.maximum(left, right)
    ok = (
        (gentle > SLOPES[0])
        & (steep < SLOPES[1])
        & (top > 0.02 * height)
        & (foot <= height)
        & (rise > 0.06 * height)
    )
    ok &= (x - left > -0.15 * width) & (x + right < 1.15 * width)
    out = np.full(len(triangles), -1.0)
    for some in np.array_split(np.flatnonzero(ok), max(1, ok.sum() // 1500)):
        inside, around = _histograms(layers, triangles[some])
        core = _pixels_inside(layers, *_inner_half(triangles[some]).T)
        alike = jensen_shannon(core, np.maximum(inside - core, 0.0))
        grainy = _normalised(inside) @ texture - 0.5 * _normalised(around) @ texture
        differs = jensen_shannon(inside, around) - alike
        size = inside.sum(axis=1) ** by.large
        out[some] = (differs + by.grainy * grainy) * size
    return out


def _inner_half(triangles: np.ndarray) -> np.ndarray:
    """The inner half (by area) of the triangles."""
    x, top, foot, left, right = triangles.T
    rise, centre = foot - top, x + (right - left) / 3
    new = 0.7 * (x - centre) + centre
    return np.c_[new, top + 0.2 * rise, top + 0.9 * rise, 0.7 * left, 0.7 * right]


def _normalised(counts: np.ndarray) -> np.ndarray:
    return counts / np.maximum(counts.sum(axis=1, keepdims=True), 1e-9)


def _histograms(
    layers: _Layers, triangles: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of pixels of each cluster in the triangles and in the shells around them,
    (m, clusters) each."""
    x, top, foot, left, right = triangles.T
    rise = foot - top
    inside = _pixels_inside(layers, x, top, foot, left, right)
    wide = SHELL * (left + right) / 2
    below = foot + SHELL * rise / 2
    outside = _pixels_inside(
        layers, x, top - SHELL * rise, below, left + wide, right + wide
    )
    return inside, np.maximum(outside - inside, 0.0)


def _pixels_inside(layers: _Layers, x, top, foot, left, right) -> np.ndarray:
    """Numbers of pixels of each cluster in triangles, (m, clusters)."""
    off = layers.x - x[:, None]
    share = np.clip(
        1 - np.where(off < 0, -off / left[:, None], off / right[:, None]), 0, 1
    )
    upper = np.clip(
        np.rint(foot[:, None] - (foot - top)[:, None] * share), 0, layers.height
    ).astype(int)
    lower = np.clip(np.rint(foot), 0, layers.height).astype(int)
    inside = share > 0
    first, count = inside.argmax(axis=1), inside.sum(axis=1)
    upper = np.where(inside, np.minimum(upper, lower[:, None]), 0)
    above = layers.sums[upper, np.arange(layers.x.size)].sum(axis=1)
    below = layers.left[lower, first + count] - layers.left[lower, first]
    return np.maximum(below - above, 0.0)  # of sums that are rounded


def jensen_shannon(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Jensen–Shannon divergence of two histograms, 0 (alike) to 1 (nothing in
    common)."""
    p, q = _normalised(a), _normalised(b)
    both = rel_entr(p, (p + q) / 2) + rel_entr(q, (p + q) / 2)
    return both.sum(axis=1) / 2 / np.log(2)
