"""Mask of spread grains, corrected for uneven illumination, and splitting of touching
grains."""

from dataclasses import dataclass

import cv2
import numpy as np
from skimage.filters import threshold_isodata

from benchtwin.bench.language import tr
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.pile.surface import as_float, fit_illumination, illumination_at

# px of the reduced picture on which background and threshold are found
SMALL_SIDE = 700
LEAST_CONTRAST = 3.0  # difference of the means of grains and background, in their sds
# levels of 255: of a colour, added to what it scatters by; of grains from background
LEAST_SPREAD, LEAST_GAP = 2.0, 5.0
SHADOW = 0.1  # sd of the share of the background's light that a shadow takes
LEAST_SMALL_PX = 12  # area of a thing in the reduced picture
# two maxima of depth are one grain where the path between them stays above this share
# of the lower one
SADDLE = 0.88
# of the greatest depth: smoothing of the depth; what is less deep is no grain's middle
BLUR, SHALLOW = 0.05, 0.3


@dataclass(frozen=True)
class Relief:
    """height: float32, about 0 on the background and 1 on grains; mask: uint8, 1 on
    grains. others: outlines (n, 2) [px] of large things that are no grains (a
    label)."""

    height: np.ndarray
    mask: np.ndarray
    others: tuple[np.ndarray, ...] = ()


@dataclass(frozen=True)
class Piece:
    """Closed pixel outline (n, 2) [px] of one grain; free (n,): points that are not on
    a cut to a neighbour."""

    outline: np.ndarray
    free: np.ndarray


def make_relief(image: np.ndarray, forbidden: np.ndarray | None = None) -> Relief:
    """The share of the way from the background's colour to the grains', whichever is
    lighter. The background's illumination is a quadratic surface in each channel.
    forbidden (h, w), bool: neither grains nor background (a board's sheet). Raises
    MeasurementError where nothing stands out."""
    allowed = np.ones(image.shape[:2], bool) if forbidden is None else ~forbidden
    step = max(1, int(np.ceil(max(image.shape[:2]) / SMALL_SIDE)))
    small_allowed = allowed[step // 2 :: step, step // 2 :: step]
    small = cv2.resize(image, small_allowed.shape[::-1], interpolation=cv2.INTER_AREA)
    small = cv2.GaussianBlur(as_float(small), (0, 0), 0.8).reshape(*small.shape[:2], -1)
    best = _separate(small, small_allowed)
    others: tuple[np.ndarray, ...] = ()
    # repeated without large things: a white label beside brown seeds would be the upper
    # level
    for _ in range(2):
        large = None if best is None else _large_things(best, small, small_allowed)
        if large is None:
            break
        mask, outlines = large
        again = _separate(small, small_allowed & ~mask)
        if again is None or again.contrast < LEAST_CONTRAST:
            break
        best, small_allowed = again, small_allowed & ~mask
        others += tuple(o * step + step // 2 for o in outlines)
    if best is None or best.contrast < LEAST_CONTRAST:
        raise MeasurementError(
            tr(
                "no seeds stand out from the ground; spread them on paper or cloth of a"
                " contrasting colour"
            )
        )
    if others:
        size = allowed.shape[::-1]
        small_mask = small_allowed.astype(np.uint8)
        allowed = allowed & (
            cv2.resize(small_mask, size, interpolation=cv2.INTER_NEAREST) > 0
        )
    height = cv2.GaussianBlur(best.height(as_float(image)), (0, 0), 1.0)
    return Relief(
        height, ((height > best.threshold) & allowed).astype(np.uint8), others
    )


@dataclass(frozen=True, eq=False)
class _Levels:
    """Grains and background of a picture: their contrast, the background's surface
    (6, c), the direction (c,) in which grains differ from it, scaled to 1, and the
    threshold on that scale."""

    contrast: float
    surface: np.ndarray
    direction: np.ndarray
    threshold: float

    def height(self, pixels: np.ndarray) -> np.ndarray:
        """About 0 on the background and 1 on grains, float32 (h, w)."""
        ground = illumination_at(self.surface @ self.direction[:, None], pixels.shape)
        return (pixels @ self.direction.astype(np.float32)) - ground[..., 0]


def _large_things(
    best, small: np.ndarray, allowed: np.ndarray
) -> tuple[np.ndarray, list[np.ndarray]] | None:
    """(mask, outlines) of things larger than 2 % of the reduced picture and 20 times
    the typical area; None without any."""
    height = best.height(small)
    seeds = ((height > best.threshold) & allowed).astype(np.uint8)
    contours = cv2.findContours(seeds, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    areas = np.array([cv2.contourArea(c) for c in contours])
    seen = areas > LEAST_SMALL_PX
    typical = np.median(areas[seen]) if seen.any() else 0.0
    chosen = [
        c for c, a in zip(contours, areas) if a > max(0.02 * allowed.size, 20 * typical)
    ]
    if not chosen or len(chosen) == seen.sum() > 1:
        return None
    mask = cv2.drawContours(np.zeros(allowed.shape, np.uint8), chosen, -1, 1, -1)
    return cv2.dilate(mask, np.ones((9, 9), np.uint8)) > 0, [c[:, 0] for c in chosen]


def _separate(small: np.ndarray, allowed: np.ndarray) -> _Levels | None:
    """What dominates the picture's border is background, and what differs from it most
    is grains: Fisher's discriminant of both, thrice, from the distance to the border's
    colour on."""
    if allowed.mean() < 0.03:
        return None
    rim = np.zeros_like(allowed)
    rim[:3], rim[-3:], rim[:, :3], rim[:, -3:] = True, True, True, True
    rim = rim & allowed if (rim & allowed).any() else allowed
    value = np.linalg.norm(small - np.median(small[rim], axis=0), axis=2)
    for _ in range(3):
        high = value > _isodata_threshold(value[allowed])
        high = high if high[rim].mean() < 0.5 else ~high
        ground, grains = allowed & ~high, allowed & high
        if ground.sum() < 50 or grains.sum() < 20:
            return None
        kernel = np.ones((5, 5), np.uint8)
        inner = cv2.erode(ground.astype(np.uint8), kernel, borderValue=1) > 0
        where = inner if inner.sum() > 50 else ground
        surface = fit_illumination(small, where)
        flat = small - illumination_at(surface, small.shape)
        direction, contrast = discriminant(
            flat[where], flat[grains], small[where].mean(axis=0)
        )
        value = flat @ direction
    if np.linalg.norm(direction) * LEAST_GAP > 1:
        return None
    level = float(np.clip(_isodata_threshold(value[allowed]), 0.2, 0.3))
    return _Levels(contrast, surface, direction, level)


def discriminant(
    ground: np.ndarray, grains: np.ndarray, lit: np.ndarray
) -> tuple[np.ndarray, float]:
    """Fisher's discriminant of the colours (n, c) of background and grains: the
    direction (c,) along which their means are 1 apart, and how many sds that is. lit
    (c,): the background's colour, of which a shadow takes a share."""
    gap = grains.mean(axis=0) - ground.mean(axis=0)
    spread = np.cov(ground.T) + np.cov(grains.T) + LEAST_SPREAD**2 * np.eye(len(gap))
    direction = np.linalg.solve(spread + SHADOW**2 * np.outer(lit, lit), gap)
    direction /= max(float(gap @ direction), 1e-12)
    return direction, float((direction @ spread @ direction) ** -0.5)


def _isodata_threshold(values: np.ndarray) -> float:
    """The level midway between the means below and above it (Ridler & Calvard), of
    several the nearest to the middle of the range. Unlike Otsu's it does not split the
    background's noise where grains cover less than 1 % of the picture."""
    low, high = (float(v) for v in np.percentile(values, (0.02, 99.98)))
    if high - low < 1e-4:
        return high
    count, edges = np.histogram(values.astype(float), 256, (low, high))
    middle = (edges[1:] + edges[:-1]) / 2
    levels = threshold_isodata(hist=(count, middle), return_all=True)
    return min(levels, key=lambda level: abs(level - (low + high) / 2), default=high)


def touching_patch(
    relief: Relief, outline: np.ndarray, level: float = 0.4
) -> tuple[np.ndarray, tuple[int, int]]:
    """A patch of touching grains in its bounding box (uint8), and the box's corner
    [px]. The threshold is higher than the mask's, so that grains separate better. Holes
    down to the background stay (between grains), dark spots on a grain are filled."""
    x, y, w, h = cv2.boundingRect(outline)
    inside = cv2.drawContours(np.zeros((h, w), np.uint8), [outline - (x, y)], -1, 1, -1)
    height = relief.height[y : y + h, x : x + w]
    shape = np.where(height > level, inside, 0)
    contours, tree = cv2.findContours(shape, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    for contour, links in zip(contours, tree[0] if tree is not None else ()):
        if links[3] >= 0:
            left, top, wide, high = cv2.boundingRect(contour)
            hole = cv2.drawContours(
                np.zeros((high, wide), np.uint8), [contour - (left, top)], -1, 1, -1
            )
            here = slice(top, top + high), slice(left, left + wide)
            if float(np.percentile(height[here][hole > 0], 20)) > 0.15:
                shape[here] |= hole
    return (shape if shape.any() else inside), (x, y)


def without_thin_parts(shape: np.ndarray, typical: float) -> np.ndarray:
    """The patch without thin parts (dust, hairs, printed lines)."""
    size = max(3, 2 * int(0.08 * np.sqrt(typical)) + 1)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    opened = cv2.morphologyEx(np.pad(shape, size), cv2.MORPH_OPEN, disc)[
        size:-size, size:-size
    ]
    return opened if opened.any() else shape


def split(shape: np.ndarray) -> list[Piece]:
    """Split a patch (uint8) of touching grains where it is narrow: maxima of the
    distance to the edge with a saddle below SADDLE of the lower one between them are
    different grains, whose watershed is the cut."""
    from skimage.morphology import local_maxima, reconstruction  # loads for .7 s
    from skimage.segmentation import watershed

    padded = np.pad(shape, 3)
    depth = cv2.distanceTransform(padded, cv2.DIST_L2, 5).astype(float)
    depth = cv2.GaussianBlur(depth, (0, 0), max(1.0, BLUR * depth.max()))
    deep = np.log(np.maximum(depth / depth.max(), SHALLOW))
    tops = local_maxima(reconstruction(deep + np.log(SADDLE), deep))
    count, summits = cv2.connectedComponents(tops.astype(np.uint8))
    if count < 3:
        return [_make_piece(padded, padded)]
    labels = watershed(-depth, summits, mask=padded > 0)
    grains = ((labels == label).astype(np.uint8) for label in range(1, count))
    return [_make_piece(grain, padded) for grain in grains if grain.any()]


def _make_piece(grain: np.ndarray, whole: np.ndarray) -> Piece:
    """Outline of `mine` in the unpadded patch; points deep inside `whole` are on a
    cut."""
    contour = max(
        cv2.findContours(grain, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0], key=len
    )[:, 0]
    inside = cv2.distanceTransform(whole, cv2.DIST_L2, 5)
    cut = inside[contour[:, 1], contour[:, 0]] >= 2.2
    # Near a cut the outline bends towards the neighbour: some points on each side are
    # not free either.
    beside = 2 * max(6, len(contour) // 70) + 1
    free = (
        cv2.dilate(
            np.tile(cut, 3)[None].astype(np.uint8), np.ones((1, beside), np.uint8)
        )[0, len(cut) : -len(cut)]
        == 0
    )
    return Piece(contour.astype(float) - 3, free)
