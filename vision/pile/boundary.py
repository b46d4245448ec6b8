"""The pile's surface: where, going down each column, the ground (background) ends. First coarse, then sub-pixel."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import median_filter

from vision.pile.image import as_float, binarise, denoise, fit_light, light_at, shrink


@dataclass(frozen=True)
class Ground:
    """The picture's background, and how far every pixel of the small picture is from it.

    `small` float32 (h, w, c), `factor` full : small, `light` coefficients of image.fit_light, `distance` float32 (h, w) ≥ 0.
    """

    small: np.ndarray
    factor: float
    light: np.ndarray
    distance: np.ndarray


@dataclass(frozen=True)
class Silhouette:
    """What stands before the ground, in the small picture: mask (h, w), top and bottom row of each column (−1: none)."""

    mask: np.ndarray
    top: np.ndarray
    bottom: np.ndarray
    threshold: float


def find_ground(image: np.ndarray) -> Ground:
    """The light on the background, which must show at the picture's top, fitted and taken away.

    Starts from the median colour of the top rows and works downwards: the pixels nearest to the fit are the ground (lowest
    of Otsu's thresholds), and the light is fitted through them, first a plane, then a quadratic, over more and more rows.
    (Starting with all rows, a plate between ground and pile in brightness was taken for a fall of the light.)
    """
    small, factor = shrink(image)
    small = denoise(small, 3 if factor > 1 else 5)
    start = np.median(small[: max(1, small.shape[0] // 20)].reshape(-1, small.shape[2]), axis=0)
    light = start[None].astype(float)
    coarse = np.ascontiguousarray(small[::2, ::2])  # three quarters of the pixels are needed only once
    for share, order in ((0.25, 1), (0.5, 1), (0.75, 2), (1.0, 2)):
        light = _refit(coarse, light, max(4, round(share * coarse.shape[0])), order)
    light = _refit(small, light, small.shape[0], 2)
    return Ground(small, factor, light, _distance(small, light, small.shape[0]))


def _refit(small: np.ndarray, light: np.ndarray, rows: int, order: int) -> np.ndarray:
    """The light fitted anew through those pixels of the upper `rows` that are near the present fit."""
    distance = _distance(small, light, rows)
    where = np.zeros(small.shape[:2], dtype=bool)
    where[:rows] = distance <= _thresholds(distance)[-1]
    return fit_light(small, where, order if where[:rows].mean() > 0.05 else 0)


def _distance(small: np.ndarray, light: np.ndarray, rows: int) -> np.ndarray:
    """How far the colours of the upper `rows` are from the light on the ground."""
    y, x = np.mgrid[0:rows, 0 : small.shape[1]].astype(np.float32)
    off = small[:rows] - light_at(light, x, y, small.shape[:2])
    return np.sqrt(np.einsum("yxc,yxc->yx", off, off))


def silhouettes(ground: Ground) -> list[Silhouette]:
    """Candidate silhouettes, one a threshold (the plate may or may not be darker than the pile's half)."""
    found = [_silhouette(ground.distance > threshold, threshold) for threshold in _thresholds(ground.distance)]
    return [s for s in found if (s.top >= 0).sum() >= 8]


def _thresholds(distance: np.ndarray, most: int = 3) -> list[float]:
    """Otsu's threshold, then Otsu's below it, and so on while what is split stands clear of the ground's own noise."""
    values = np.minimum(distance.ravel()[::3], np.percentile(distance[::4, ::4], 99.8))
    found: list[float] = []
    for _ in range(most):
        threshold, _ = binarise(values)
        below = values[values <= threshold]
        noise = 1.4826 * float(np.median(below)) if below.size else 0.0
        if found and (below.size < 0.05 * distance.size / 3 or threshold < max(4 * noise, 4.0)):
            break
        found.append(threshold)
        values = below
    return found


def _silhouette(mask: np.ndarray, threshold: float) -> Silhouette:
    """Opened by 3 px (thin lines, specks); grains joined over gaps of 1 % to tell the pile from strays, small parts left out."""
    size = max(mask.shape)
    solid = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, _disc(3))
    joined = cv2.morphologyEx(solid, cv2.MORPH_CLOSE, _disc(max(3, size // 100)))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(joined, connectivity=8)
    if count > 1:
        area = stats[1:, cv2.CC_STAT_AREA]
        kept = 1 + np.flatnonzero(area >= 0.15 * area.max())
        solid = np.where(np.isin(labels, kept), solid, 0)
    some = solid.any(axis=0)
    top = np.where(some, solid.argmax(axis=0), -1)
    bottom = np.where(some, solid.shape[0] - 1 - solid[::-1].argmax(axis=0), -1)
    return Silhouette(solid.astype(bool), top, bottom, threshold)


def _disc(diameter: int) -> np.ndarray:
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (diameter | 1, diameter | 1))


def edge(image: np.ndarray, ground: Ground, coarse: np.ndarray, threshold: float, upward: bool = False) -> np.ndarray:
    """Sub-pixel row of the surface in every column of the full picture; NaN where `coarse` has none.

    `coarse` holds rows of the small picture (−1: none), `threshold` the distance from the ground that found them. In a strip
    about the coarse row the picture is denoised, the ground's light taken away, and projected on the local colour of what
    stands before it (running median over 2 % of the width), so that ground = 0 and pile = 1; the surface is where ½ is first
    passed, by a straight line between two rows. `upward` reads a lower edge instead, coming from below.
    """
    (height, width), factor = image.shape[:2], ground.factor
    columns = np.arange(width)
    nearest = np.clip(np.rint((columns + 0.5) / factor - 0.5).astype(int), 0, coarse.size - 1)
    known = coarse[nearest] >= 0
    if known.sum() < 2:
        return np.full(width, np.nan)
    inward = -1 if upward else 1
    reach, inside = int(np.ceil(2 * factor)) + 6, max(6, int(np.ceil(3 * factor)))
    start = np.rint((coarse[nearest] + 0.5) * factor - 0.5).astype(int)
    rows = start + inward * np.arange(-reach, reach + inside + 1)[:, None]
    first, last = max(0, rows[:, known].min()), min(height, rows[:, known].max() + 1)
    band = as_float(denoise(np.ascontiguousarray(image[first:last])))
    visible = np.clip(rows, first, last - 1)
    run = max(3, int(0.02 * width)) | 1
    strip = band[visible - first, columns] - _light(ground, visible, columns)
    strip = strip - _along(strip[: reach - 4].mean(axis=0), run)  # what little the fitted light has left
    face = _along(strip[reach + 3 : reach + 3 + inside].mean(axis=0), run)
    clear = (face**2).sum(axis=1) >= (0.5 * threshold) ** 2  # a fold of the light is no edge
    level = np.einsum("rxc,xc->rx", strip, face) / np.maximum((face**2).sum(axis=1), 1e-9)
    level = (np.roll(level, 1, 0) + 2 * level + np.roll(level, -1, 0)) / 4
    crossing = _first_crossing(level, rows == visible)
    found = np.where(known & clear, start + inward * (crossing - reach), np.nan)
    border = known & ((coarse[nearest] >= ground.small.shape[0] - 2) if upward else (coarse[nearest] <= 1))
    return np.where(border, height - 1.0 if upward else 0.0, found)  # it goes on beyond the picture


def _along(values: np.ndarray, run: int) -> np.ndarray:
    """Running median of (columns, channels) along the columns."""
    return np.stack([median_filter(channel, run, mode="nearest") for channel in values.T], axis=1)


def _first_crossing(level: np.ndarray, visible: np.ndarray) -> np.ndarray:
    """Fractional index at which `level` first rises through ½ going down axis 0; NaN where it starts above or never does."""
    before, after = level[1:-2], level[2:-1]
    rises = (before < 0.5) & (after >= 0.5) & visible[1:-2] & visible[2:-1]
    at, columns = rises.argmax(axis=0), np.arange(level.shape[1])
    a, b = before[at, columns], after[at, columns]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = 1 + at + (0.5 - a) / (b - a)
    return np.where(rises.any(axis=0), crossing, np.nan)


def _light(ground: Ground, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """The ground's light at pixels of the full picture (its polynomial runs over the small one)."""
    x = (np.broadcast_to(columns, rows.shape) + 0.5) / ground.factor - 0.5
    y = (rows + 0.5) / ground.factor - 0.5
    return light_at(ground.light, x, y, ground.small.shape[:2])
