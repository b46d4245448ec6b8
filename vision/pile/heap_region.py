"""Segments a heap by colour and texture, where cloth, wood, a horizon or a shelf is
behind it.

Every pixel is described by colour and texture. The triangle that differs most from its
surroundings (`triangle_search`) is the first guess of a heap. Then, on a close-up, the
colours of the seeds and of what surrounds them are learnt about each place, and the
heap is cut anew: the surface and the foot for which these colours are most likely, with
the shortest border, found for all columns at once by dynamic programming. A cut starts
from the one before until it settles. Where seeds and surroundings are alike it may
settle elsewhere by what it started from. It is therefore made several times, each from
a triangle and from clusters of its own; the heap is what most cuts contain, and how far
they differ is how well it is known. Its edges are then read off the full picture by
`surface.subpixel_edge`."""

from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np
from scipy.cluster.vq import vq

from benchtwin.bench.language import tr
from benchtwin.vision.pile.surface import as_float, binarise, shrink
from benchtwin.vision.pile.triangle_search import (
    NO_SIDE,
    SCORES,
    Found,
    Score,
    best_triangle,
    jensen_shannon,
)

AREA = cv2.INTER_AREA
TEXTURE = 4  # of the features: how grainy, whatever the direction
# longest side: for the triangles, for colour and texture among which they are sought;
# of the close-up of a cut
SEARCH_PX = 96
FEATURES_PX = 480
CUT_PX = 480
CUTS = 5  # odd: most of them is a majority
BY_COLOUR = -1  # the number of the cut that starts from colours
MOST_ROUNDS, SETTLED = 9, 0.003  # of a cut; share of it that a round still changes
# times the reach of texture: that far about a cut's border the next one may lie
FREE = 2.0
EDGE = 5.0  # of a border's px where nothing changes, as log odds of a pixel
# of a triangle's sides, sd: as much as the triangle moves when the picture is cropped
MOVED = 0.05
SOME = 4000  # pixels that are clustered; the others go to the nearest
REACHES = 120  # of the picture's width: over which texture is averaged
CLUSTERS = 20  # of colour and texture
# of the close-up's width: radius within which colours of seeds and surroundings are
# compared
LOCAL = 0.08
CELL_PX = 8  # px of the close-up in which those colours are counted
LEAST_SHARE = 0.003  # of a cluster among them: less tells nothing
TURNED = {  # by quarter turns anticlockwise that put it right
    1: "turned to the right by 90°",
    2: "upside down",
    3: "turned to the left by 90°",
}
CLEARLY = 1.1  # times the score: of path-traced heaps, the right way up has 1.14 to 1.8
LEAST_WHOLE = 0.98  # of the picture's width: a close-up that shows all of it
HALF = np.array([0.5, 0.5, 0.5, 0.0, 0.0])  # of a px, of places in a reduced picture
LEAST_OVERLAP = 0.55  # of mask and triangle, intersection over union: less is no heap
# of the least textured tenth of seeds (plain paper and its noise have 0 to 0.9, seeds
# in focus 2 to 5)
SEED_TEXTURE = 1.7
# between the colours above and below its surface; of what shows no texture of seeds
LEAST_CONTRAST, NO_SEEDS = 0.5, 0.5
GLARE = 95.0  # lightness L*, of 100: brighter is overexposed


@dataclass(frozen=True)
class Start:
    """What every cut starts from: a close-up about a triangle in it, whose px are
    `zoom` full px each and whose corner is `origin` in the picture; features (h, w, 6)
    and lab (h, w, 3) of it."""

    features: np.ndarray
    lab: np.ndarray
    triangle: np.ndarray
    zoom: float
    origin: tuple[int, int]

    @property
    def halo(self) -> float:
        """px over which texture was averaged."""
        return texture_reach(self.features)

    @cached_property
    def colours(self) -> np.ndarray:
        """Each pixel's cluster of colours, (h, w)."""
        return cluster_pixels(self.lab, 2 * CLUSTERS, np.random.default_rng(0))

    @property
    def glare(self) -> np.ndarray:
        """Where the light is too bright to tell a texture, (h, w)."""
        return self.lab[..., 0] > GLARE

    @property
    def in_picture(self) -> np.ndarray:
        """The triangle in px of the picture."""
        x0, y0 = self.origin
        return self.triangle * self.zoom + [x0, y0, y0, 0, 0]

    @cached_property
    def border_costs(self) -> tuple[np.ndarray, np.ndarray]:
        """Of a border between a pixel and the next one to the right (h, w − 1), below
        (h − 1, w): less where the colour changes."""
        changes = [np.square(np.diff(self.lab, axis=a)).sum(axis=2) for a in (1, 0)]
        usual = sum(float(change.mean()) for change in changes) + 1e-6
        across, down = (EDGE * np.exp(-change / usual) for change in changes)
        return across, down

    def clearest(self) -> np.ndarray:
        """The heap by the cut that starts from the triangle itself or, where that shows
        no seeds, from its colours, whichever has the clearer surface."""
        one = self.cut(0)
        if _confidence(one, self) >= 1:
            return one
        other = self.cut(BY_COLOUR)
        return max(one, other, key=lambda mask: _contrast(mask, self))

    def _of_its_colours(self, triangle: np.ndarray) -> np.ndarray:
        """What is nearer to a triangle's colours than to its surroundings', by Otsu's
        threshold along the line from these to those."""
        inside = _triangle_mask(self.lab.shape, triangle)
        if inside.all() or not inside.any():
            return inside
        along = self.lab @ (
            self.lab[inside].mean(axis=0) - self.lab[~inside].mean(axis=0)
        )
        return _heap_component(along > binarise(along)[0], triangle)

    def cut(self, number: int) -> np.ndarray:
        """The heap (mask of the close-up) by one cut, empty where there is none. Cut 0
        starts from the triangle itself, cut BY_COLOUR from its colours, others from
        triangles near it."""
        rng = np.random.default_rng(max(number, 0))
        _, top, foot, *wide = self.triangle
        size = np.array([sum(wide), foot - top, foot - top, *[sum(wide)] * 2])
        moved = self.triangle + (number > 0) * MOVED * rng.normal(size=5) * size
        moved[3:] = np.where(self.triangle[3:] <= NO_SIDE, NO_SIDE, moved[3:])
        moved[3:] = np.maximum(moved[3:], NO_SIDE)
        clusters = cluster_pixels(self.lab, 2 * CLUSTERS, rng)
        if number == BY_COLOUR:
            heap = self._of_its_colours(moved)
        else:
            heap = _triangle_mask(self.lab.shape, moved)
        for _ in range(MOST_ROUNDS):
            before = heap
            found = _cut_about(before, self, clusters)
            heap = _heap_component(found, moved)
            if (heap ^ before).sum() <= SETTLED * before.sum():
                break
        return heap


@dataclass(frozen=True)
class Seen:
    """Each pixel's cluster and texture (h, w) in the reduced picture."""

    clusters: np.ndarray
    texture: np.ndarray

    def turned(self, quarters: int, by: Score = SCORES[0]) -> Found:
        """The triangle that looks most like a heap after so many quarter turns."""
        clusters, texture = (
            np.ascontiguousarray(np.rot90(half, quarters))
            for half in (self.clusters, self.texture)
        )
        coarse = max(1.0, max(clusters.shape) / SEARCH_PX)
        return best_triangle(clusters, texture, coarse, by)

    @cached_property
    def upright(self) -> Found:
        return self.turned(0)

    @cached_property
    def way_up(self) -> str:
        """How the picture lies, if another way up it looks more like a heap, else
        ""."""
        best = max(TURNED, key=lambda quarters: self.turned(quarters).score)
        more = self.turned(best).score > CLEARLY * self.upright.score
        return tr(TURNED[best]) if more else ""


@dataclass(frozen=True)
class Region:
    """The pixels of a heap in the close-up `start`.

    first (h, w): the heap by the clearest cut. confidence: 1 or more where the inside
    has the texture of seeds all over, more than around it, and a heap's form; NO_SEEDS
    where only form and colours are a heap's. rival: triangle [px of the picture] of
    another part that looks as much like a heap, None where there is none."""

    first: np.ndarray
    confidence: float
    start: Start
    seen: Seen
    rival: np.ndarray | None = None

    @property
    def evidence(self) -> float:
        """What speaks for it, to compare with other regions of the same picture: sure
        seeds, else the colours that differ along its surface."""
        if self.confidence >= 1:
            return np.inf
        wide = self.start.zoom * float(self.first.any(axis=0).sum())
        return min(self.confidence, 0.0) + wide * _contrast(self.first, self.start)

    @cached_property
    def weights(self) -> np.ndarray:
        """How likely each cut is: of seeds all alike; of what shows none, by the
        colours that differ along its surface, 2 to the power of the bits that places as
        far apart as texture reaches tell."""
        told = np.array([_contrast(cut, self.start) for cut in self.cuts])
        places = self.first.any(axis=0).sum() / self.start.halo
        likely = 2.0 ** ((self.confidence < 1) * places * (told - told.max()))
        return likely / likely.sum()

    @cached_property
    def cuts(self) -> tuple[np.ndarray, ...]:
        """The heap by every cut that finds one."""
        again = [self.start.cut(number) for number in range(1, CUTS)]
        return (self.first, *(mask for mask in again if mask.any()))

    @property
    def agreed(self) -> np.ndarray:
        """What is more likely a part of the heap than not."""
        return np.tensordot(self.weights, np.array(self.cuts), 1) > 0.5


def texture_reach(pixels: np.ndarray) -> float:
    """px over which texture is averaged."""
    return pixels.shape[1] / REACHES


def pixel_features(small: np.ndarray) -> np.ndarray:
    """Colour and texture at every pixel, float32 (h, w, 6): L, a, b, and logs of local
    contrast, isotropy and dark gaps."""
    lab = cv2.cvtColor(_as_rgb(small), cv2.COLOR_RGB2LAB)
    light = cv2.GaussianBlur(lab[..., 0], (0, 0), 0.7)
    reach = texture_reach(small)
    mean = cv2.GaussianBlur(light, (0, 0), reach)
    contrast = np.sqrt(
        np.clip(cv2.GaussianBlur(light**2, (0, 0), reach) - mean**2, 0, None)
    )
    gx = cv2.Sobel(light, cv2.CV_32F, 1, 0) / 8
    gy = cv2.Sobel(light, cv2.CV_32F, 0, 1) / 8
    xx, yy, xy = (
        cv2.GaussianBlur(g, (0, 0), reach) for g in (gx * gx, gy * gy, gx * gy)
    )
    # eigenvalue of the structure tensor: 0 along an edge or a stripe
    weaker = (xx + yy) / 2 - np.sqrt(((xx - yy) / 2) ** 2 + xy**2)
    disc = _disc(2 * round(reach) + 1)
    gaps = cv2.GaussianBlur(
        cv2.morphologyEx(light, cv2.MORPH_BLACKHAT, disc), (0, 0), reach
    )
    finer = np.log(1 + 2 * np.sqrt(np.clip(weaker, 0, None)))
    texture = [np.log(1 + contrast), finer, np.log(1 + gaps)]
    return np.dstack(
        [cv2.GaussianBlur(lab, (0, 0), 1.0) / 20, *(2 * t for t in texture)]
    ).astype(np.float32)


def cluster_pixels(
    features: np.ndarray, count: int, rng: np.random.Generator
) -> np.ndarray:
    """Every pixel's cluster, 0 … count − 1, (h, w): k-means on some of the pixels,
    nearest centre for all."""
    flat = features.reshape(-1, features.shape[2])
    cv2.setRNGSeed(int(rng.integers(1, 2**31 - 1)))
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 12, 0.01)
    some = np.ascontiguousarray(flat[rng.integers(0, len(flat), SOME)])
    of_some = np.zeros((SOME, 1), np.int32)
    centres = cv2.kmeans(some, count, of_some, stop, 1, cv2.KMEANS_PP_CENTERS)[2]
    return vq(flat, centres)[0].reshape(features.shape[:2])


def find_region(image: np.ndarray) -> Region | None:
    """The seeds in `image`, the surest of what is found by each way to count evidence;
    None where nothing triangular differs from its surroundings."""
    small, factor = shrink(image, FEATURES_PX)
    features = pixel_features(small)
    clusters = cluster_pixels(features, CLUSTERS, np.random.default_rng(0))
    seen = Seen(clusters, features[..., TEXTURE])
    best = None
    for by in SCORES:
        found = seen.upright if by == SCORES[0] else seen.turned(0, by)
        if found.triangle is None:
            continue
        region = _region(image, small, factor, seen, found.triangle)
        if found.rival is not None:
            other = _region(image, small, factor, seen, found.rival)
            if other.confidence >= min(region.confidence, 1.0):
                region = replace(region, rival=other.start.in_picture)
        if best is None or region.evidence > best.evidence:
            best = region
        if best.confidence >= 1:
            break
    return best


def _region(
    image: np.ndarray,
    small: np.ndarray,
    factor: float,
    seen: Seen,
    triangle: np.ndarray,
) -> Region:
    """The region cut about a triangle that was found, first in the reduced picture,
    then in a close-up."""
    start = _start(small, triangle, CUT_PX / 2)
    first = start.clearest()
    if _confidence(first, start) < 1:  # of what is no seeds, too
        grainy = start.features[..., TEXTURE] > SEED_TEXTURE
        first = _heap_component(first & (grainy | start.glare), start.triangle)
    if _confidence(first, start) >= NO_SEEDS:
        start = replace(start, triangle=_triangle_of(first, start.triangle))
    start = _start(image, (start.in_picture + HALF) * factor, CUT_PX)
    mask = start.clearest()
    whole = start.lab.shape[1] * start.zoom > LEAST_WHOLE * image.shape[1]
    if mask[:, [0, -1]].any() and not whole:  # it goes on beside the close-up
        start = replace(start, triangle=_triangle_of(mask, start.triangle))
        start = _start(image, start.in_picture, CUT_PX)
        mask = start.clearest()
    return Region(mask, _confidence(mask, start), start, seen)


def _start(image: np.ndarray, triangle: np.ndarray, longest_px: float) -> Start:
    """A close-up of the triangle [px of the picture], and some of what is about it."""
    x, top, foot, left, right = triangle
    wide, tall = 0.35 * (left + right), 0.6 * (foot - top)
    height, width = image.shape[:2]
    x0, x1 = (int(np.clip(v, 0, width)) for v in (x - left - wide, x + right + wide))
    y0, y1 = (int(np.clip(v, 0, height)) for v in (top - tall, foot + tall))
    zoom = max(1.0, max(x1 - x0, y1 - y0) / longest_px)
    close = cv2.resize(
        image[y0:y1, x0:x1], None, fx=1 / zoom, fy=1 / zoom, interpolation=AREA
    )
    pixels = as_float(close)
    lab = cv2.cvtColor(_as_rgb(pixels), cv2.COLOR_RGB2LAB)
    inside = (triangle - [x0, y0, y0, 0, 0]) / zoom
    return Start(pixel_features(pixels), lab, inside, zoom, (x0, y0))


def _triangle_of(mask: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    """The triangle about a heap's mask; it leans where the one that it was found from
    does."""
    columns = np.flatnonzero(mask.any(axis=0))
    top = mask[:, columns].argmax(axis=0)
    foot = np.median(mask.shape[0] - mask[::-1, columns].argmax(axis=0))
    high = columns[top <= top.min() + 0.1 * (foot - top.min())]
    apex = float(np.median(high))
    sides = np.array([apex - columns[0], columns[-1] - apex])
    leans = triangle[3:] <= NO_SIDE
    sides = np.maximum(np.where(leans, NO_SIDE, sides), NO_SIDE)
    return np.array([apex, top.min(), foot, *sides])


def _heap_component(mask: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    """The connected part that fills most of the triangle, without thin lines and single
    seeds beside it, its gaps filled; empty where there is none."""
    disc = _disc(max(3, round(0.1 * (triangle[2] - triangle[1]))) | 1)
    count, labels = cv2.connectedComponents(
        cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, disc), connectivity=4
    )
    inside = np.bincount(labels[_triangle_mask(mask.shape, triangle)], minlength=count)
    inside[0] = 0
    whole = np.zeros(mask.shape, np.uint8)
    if count < 2 or not inside.max():
        return whole.astype(bool)
    heap = (labels == inside.argmax()).astype(np.uint8)
    contours = cv2.findContours(heap, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    cv2.drawContours(whole, contours, -1, 1, cv2.FILLED)
    return whole.astype(bool)


def _confidence(mask: np.ndarray, start: Start) -> float:
    """How sure it is that a mask is a heap of seeds; 1 is enough.

    The least of what its form and its texture say: overlap with the triangle, texture
    of the inside, and its texture over the surroundings'. What has no texture to be
    seen is a heap by its form and colours, which must differ across its surface, to
    less than 1."""
    halo = start.halo
    discs = [_disc(2 * round(r * halo) + 1) for r in (2.0, 1.5, 6.0)]
    texture, seeds = start.features[..., TEXTURE], mask.astype(np.uint8)
    core = cv2.erode(seeds, discs[0]) > 0
    around = (cv2.dilate(seeds, discs[2]) > 0) & (cv2.dilate(seeds, discs[1]) == 0)
    if not core.any() or not around.any():
        return 0.0
    whole = _triangle_mask(mask.shape, start.triangle)
    form = (mask & whole).sum() / (mask | whole).sum() / LEAST_OVERLAP
    told = core & ~start.glare if (core & ~start.glare).any() else core
    inside = float(np.percentile(texture[told], 10))
    more = (inside - float(np.median(texture[around]))) / (SEED_TEXTURE / 2)
    seedlike = min(form, inside / SEED_TEXTURE, more)
    return max(
        seedlike, min(form, _contrast(mask, start) / LEAST_CONTRAST, 1) * NO_SEEDS
    )


def _contrast(mask: np.ndarray, start: Start) -> float:
    """By how much the colours beside a mask's upper border differ, 0 (alike) to 1."""
    disc, seeds = _disc(2 * round(FREE * 2 * start.halo) + 1), mask.astype(np.uint8)
    if not mask.any():
        return 0.0
    above = np.cumsum(seeds, axis=0) == 0
    sides = (
        mask & (cv2.erode(seeds, disc) == 0),
        above & (cv2.dilate(seeds, disc) > 0),
    )
    inside, outside = (
        np.bincount(start.colours[side], minlength=2 * CLUSTERS)[None] for side in sides
    )
    return float(jensen_shannon(inside, outside)[0])


def _cut_about(guess: np.ndarray, start: Start, clusters: np.ndarray) -> np.ndarray:
    """The heap by the colours that a guess has about each place, inside and beyond it,
    near the guess's border."""
    disc = _disc(2 * round(FREE * start.halo) + 1)
    core, reach = (f(guess.astype(np.uint8), disc) > 0 for f in (cv2.erode, cv2.dilate))
    found = np.zeros(guess.shape, bool)
    if not core.any() or reach.all():
        return found
    (top, bottom), (left, right) = (
        np.flatnonzero(reach.any(axis=axis))[[0, -1]] for axis in (1, 0)
    )
    rows, columns = slice(top, bottom + 1), slice(left, right + 1)
    odds = np.where(reach, _local_odds(clusters, core, ~reach), -np.inf)
    across, down = start.border_costs
    found[rows, columns] = _column_cut(
        odds[rows, columns],
        across[rows, left:right],
        down[top:bottom, columns],
        max(1, int(guess[rows].sum(axis=1).argmax())),
    )
    return found


def _column_cut(
    odds: np.ndarray, across: np.ndarray, down: np.ndarray, middle: int
) -> np.ndarray:
    """The most likely heap that is whole in every column and reaches up and down from
    row `middle`. odds (h, w): logarithms, of every pixel; across (h, w − 1), down
    (h − 1, w): what a border costs between a pixel and the next."""
    above, below = np.s_[middle - 1 :: -1], np.s_[middle:]
    upper = _extent(odds[above], across[above], down[: middle - 1][::-1])
    lower = _extent(odds[below], across[below], down[middle:])
    rows = np.arange(len(odds))[:, None]
    return (rows >= middle - upper) & (rows < middle + lower)


def _extent(odds: np.ndarray, across: np.ndarray, down: np.ndarray) -> np.ndarray:
    """How many rows of each column, from the first on, belong to the heap."""
    cost = np.pad(-np.cumsum(odds, axis=0), ((1, 0), (0, 0)))
    cost[1:-1] += down
    return _least_path(cost, np.pad(np.cumsum(across, axis=0), ((1, 0), (0, 0))))


def _least_path(cost: np.ndarray, beside: np.ndarray) -> np.ndarray:
    """Row y in each column for which Σ cost[y(x), x] + Σ |beside[y(x + 1), x] −
    beside[y(x), x]| is least; beside grows downwards."""
    total, beside = np.ascontiguousarray(cost.T), np.ascontiguousarray(beside.T)
    for x, level in enumerate(beside, start=1):
        before = total[x - 1]
        from_above = np.minimum.accumulate(before - level) + level
        from_below = np.minimum.accumulate((before + level)[::-1])[::-1] - level
        total[x] += np.minimum(from_above, from_below)
    path = [int(total[-1].argmin())]
    for before, level in zip(total[-2::-1], beside[::-1]):
        path.append(int((before + np.abs(level - level[path[-1]])).argmin()))
    return np.array(path[::-1])


def _as_rgb(small: np.ndarray) -> np.ndarray:
    """Float RGB 0–1 of a grey or colour picture."""
    if small.shape[2] != 3:
        small = np.repeat(small[..., :1], 3, axis=2)
    return np.ascontiguousarray(small, dtype=np.float32) / 255


def _local_odds(
    clusters: np.ndarray, seeds: np.ndarray, others: np.ndarray
) -> np.ndarray:
    """Log odds that a pixel's cluster belongs to the seeds rather than to the
    surroundings near it."""
    height, width = clusters.shape
    count, tall, wide = clusters.max() + 1, -(-height // CELL_PX), -(-width // CELL_PX)
    rows, columns = np.arange(height)[:, None] // CELL_PX, np.arange(width) // CELL_PX
    cells = (clusters * tall + rows) * wide + columns

    def density(where: np.ndarray) -> np.ndarray:
        number = np.bincount(cells[where], minlength=count * tall * wide)
        maps = number.reshape(count, tall, wide).astype(np.float32) / CELL_PX**2
        spread = [cv2.GaussianBlur(m, (0, 0), LOCAL * max(tall, wide)) for m in maps]
        return np.array(spread) / (np.sum(spread, axis=0) + 1e-6)

    odds = np.log((density(seeds) + LEAST_SHARE) / (density(others) + LEAST_SHARE))
    return cv2.GaussianBlur(odds.ravel()[cells], (0, 0), 0.7)


def _disc(diameter: int) -> np.ndarray:
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (diameter, diameter))


def _triangle_mask(shape: tuple[int, ...], triangle: np.ndarray) -> np.ndarray:
    x, top, foot, left, right = triangle
    corners = np.array([(x - left, foot), (x, top), (x + right, foot)])
    mask = np.zeros(shape[:2], np.uint8)
    cv2.fillPoly(mask, [corners.round().astype(np.int32)], 1)
    return mask.astype(bool)
