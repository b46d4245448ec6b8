"""Sub-pixel edges of a pile, and its silhouette on a smooth background: where, going
down each column, the background ends.

Steps: reduce, denoise, fit the illumination, find a threshold, read the edges off the
full picture."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import median_filter
from skimage.filters import threshold_otsu

from benchtwin.bench.robust import robust_sd

# longest side of the reduced picture; edges are read off the full one
WORKING_PX = 1024
BINS = 512  # of grey levels, among which a threshold is sought


def shrink(image: np.ndarray, longest_px: int = WORKING_PX) -> tuple[np.ndarray, float]:
    """The picture with its longest side at most `longest_px` (area-averaged, float32,
    0–255), and the factor px : px'."""
    factor = max(1.0, max(image.shape[:2]) / longest_px)
    size = (
        max(1, round(image.shape[1] / factor)),
        max(1, round(image.shape[0] / factor)),
    )
    small = (
        cv2.resize(image, size, interpolation=cv2.INTER_AREA) if factor > 1 else image
    )
    return as_float(small), factor


def as_float(image: np.ndarray) -> np.ndarray:
    """Pixels as float32 on the scale 0–255, whatever the depth; always (height, width,
    channels)."""
    return np.atleast_3d(in_float(image))


def in_float(values: np.ndarray) -> np.ndarray:
    """Values of any shape as float32 on the scale 0–255, whatever their depth."""
    pixels = values.astype(np.float32)
    if np.issubdtype(values.dtype, np.integer) and values.dtype != np.uint8:
        pixels *= np.float32(255.0 / np.iinfo(values.dtype).max)
    return pixels


def denoise(image: np.ndarray, aperture_px: int = 5) -> np.ndarray:
    """Median over aperture_px × aperture_px (at most 5 for float and 16-bit pictures):
    removes single wrong pixels."""
    blurred = cv2.medianBlur(image, aperture_px)
    return blurred.reshape(image.shape)


def fit_illumination(
    image: np.ndarray, where: np.ndarray, order: int = 2
) -> np.ndarray:
    """Polynomial of `order` in x and y for each channel, fitted to the pixels of
    `where` without outliers: (terms, channels)."""
    height, width = where.shape
    y, x = np.nonzero(where)
    step = max(1, y.size // 20_000)  # a smooth surface needs no more
    y, x = y[::step], x[::step]
    terms, values = _terms(x / width, y / height, order), image[y, x]
    keep = np.ones(y.size, dtype=bool)
    for _ in range(3):
        kept_terms = terms[keep]
        normal = kept_terms.T @ kept_terms, kept_terms.T @ values[keep]
        coefficients, *_ = np.linalg.lstsq(*normal, rcond=None)
        residual = np.linalg.norm(values - terms @ coefficients, axis=1)
        limit = 3 * max(1.48 * float(np.median(residual)), 0.5)
        if (
            keep.sum() == (kept := residual < limit).sum()
            or kept.sum() < 10 * terms.shape[1]
        ):
            break
        keep = kept
    return coefficients


def illumination_at(coefficients: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """The fitted illumination (h, w, channels) of a picture of `shape`."""
    shown = np.zeros((6, coefficients.shape[1]), np.float32)
    shown[: len(coefficients)] = coefficients
    one, by_x, by_y, by_xx, by_xy, by_yy = shown
    y, x = (np.arange(n, dtype=np.float32)[:, None] / np.float32(n) for n in shape[:2])
    y = y[:, None]
    return one + x * (by_x + x * by_xx) + y * (by_y + x * by_xy + y * by_yy)


def binarise(grey: np.ndarray) -> tuple[float, float]:
    """Otsu's threshold (1979) on a grey picture, in the middle of a valley that is
    empty, and its separability σ²_between / σ²_total (noise alone gives about 0.64)."""
    low, high = float(grey.min()), float(grey.max())
    if high - low < 1e-6:
        return high, 0.0
    threshold = threshold_otsu(grey, nbins=BINS) + (high - low) / BINS / 2
    bright = grey > threshold
    dark, light, share = grey[~bright], grey[bright], bright.mean()
    between = share * (1 - share) * (light.mean() - dark.mean()) ** 2
    return float(dark.max() + light.min()) / 2, float(between / grey.var())


def _terms(x: np.ndarray, y: np.ndarray, order: int) -> np.ndarray:
    terms = [np.ones_like(x), x, y, x * x, x * y, y * y]
    return np.stack(terms[: (order + 1) * (order + 2) // 2], axis=1)


def distance_from_background(image: np.ndarray) -> tuple[np.ndarray, float]:
    """How far the colour of every pixel is from the background's, which must show at
    the picture's top: float32 (h, w) ≥ 0, levels of 255, in the reduced picture, and
    full px per px of it.

    Starts from the median colour of the top rows. The pixels nearest to the fit (below
    the lowest of Otsu's thresholds) are background; the illumination is fitted to them,
    first a plane, then a quadratic, over more and more rows. (Starting with all rows, a
    plate between background and pile in brightness would be taken for uneven light.)
    """
    small, factor = shrink(image)
    small = denoise(small, 3 if factor > 1 else 5)
    start = np.median(
        small[: max(1, small.shape[0] // 20)].reshape(-1, small.shape[2]), axis=0
    )
    light = start[None].astype(float)
    # three quarters of the pixels are needed only once
    coarse = np.ascontiguousarray(small[::2, ::2])
    for share, order in ((0.25, 1), (0.5, 1), (0.75, 2), (1.0, 2)):
        light = _refit(coarse, light, max(4, round(share * coarse.shape[0])), order)
    light = _refit(small, light, small.shape[0], 2)
    return _distance(small, light, small.shape[0]), factor


def _refit(small: np.ndarray, light: np.ndarray, rows: int, order: int) -> np.ndarray:
    """The illumination refitted to those pixels of the upper `rows` that are near the
    present fit."""
    distance = _distance(small, light, rows)
    where = np.zeros(small.shape[:2], dtype=bool)
    where[:rows] = distance <= _thresholds(distance)[-1]
    return fit_illumination(small, where, order if where[:rows].mean() > 0.05 else 0)


def _distance(small: np.ndarray, light: np.ndarray, rows: int) -> np.ndarray:
    """Distance of the colours in the upper `rows` from the background's."""
    off = small[:rows] - illumination_at(light, small.shape)[:rows]
    return np.sqrt(np.einsum("yxc,yxc->yx", off, off))


def silhouettes(distance: np.ndarray) -> list[tuple[np.ndarray, float]]:
    """Candidate silhouettes (masks) and their thresholds of the distance from the
    background: the plate may lie between background and pile in brightness."""
    found = [(_without_specks(distance > at), at) for at in _thresholds(distance)]
    return [(mask, at) for mask, at in found if mask.any(axis=0).sum() >= 8]


def _thresholds(distance: np.ndarray, most: int = 3) -> list[float]:
    """Otsu's threshold, then Otsu's of what is below it, and so on down to the
    background's noise."""
    values = np.minimum(distance.ravel()[::3], np.percentile(distance[::4, ::4], 99.8))
    found: list[float] = []
    for _ in range(most):
        threshold, _ = binarise(values)
        below = values[values <= threshold]
        noise = robust_sd(below) if below.size else 0.0
        if found and (
            below.size < 0.05 * distance.size / 3 or threshold < max(4 * noise, 4.0)
        ):
            break
        found.append(threshold)
        values = below
    return found


def _without_specks(mask: np.ndarray) -> np.ndarray:
    """The mask opened by 3 px (thin lines, specks), without small parts; gaps of 1 % of
    the picture do not separate parts."""
    size = max(mask.shape)
    solid = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, _disc(3))
    joined = cv2.morphologyEx(solid, cv2.MORPH_CLOSE, _disc(max(3, size // 100)))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(joined, connectivity=8)
    if count > 1:
        area = stats[1:, cv2.CC_STAT_AREA]
        kept = 1 + np.flatnonzero(area >= 0.15 * area.max())
        solid = np.where(np.isin(labels, kept), solid, 0)
    return solid > 0


def borders(mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows (w,) of a mask's upper and lower border in each column, between two px; NaN
    where it has none."""
    some = mask.any(axis=0)
    ends = mask.argmax(axis=0) - 0.5, len(mask) - mask[::-1].argmax(axis=0) - 0.5
    top, bottom = (np.where(some, end, np.nan) for end in ends)
    return top, bottom


def _disc(diameter: int) -> np.ndarray:
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (diameter | 1, diameter | 1))


def subpixel_edge(
    image: np.ndarray,
    coarse: np.ndarray,
    factor: float,
    least_step: float,
    upward: bool = False,
) -> np.ndarray:
    """Sub-pixel row of the surface in every column; NaN where `coarse` has none.

    coarse (w,): rows to `factor` px, NaN: none. In a strip about them the picture is
    denoised and projected on the step from the local colour beyond the edge to that
    inside it (running medians over 2 % of the width), so that background = 0 and pile =
    1. The surface is where ½ is first crossed, interpolated between two rows; NaN where
    the step is less than `least_step` levels. upward: read a lower edge, coming from
    below."""
    height, width = image.shape[:2]
    columns, known = np.arange(width), np.isfinite(coarse)
    if known.sum() < 2:
        return np.full(width, np.nan)
    inward = -1 if upward else 1
    reach, inside = int(np.ceil(2 * factor)) + 6, max(6, int(np.ceil(3 * factor)))
    start = np.rint(np.interp(columns, columns[known], coarse[known])).astype(int)
    rows = start + inward * np.arange(-reach, reach + inside + 1)[:, None]
    first, last = max(0, rows[:, known].min()), min(height, rows[:, known].max() + 1)
    band = np.atleast_3d(denoise(np.ascontiguousarray(image[first:last])))
    visible = np.clip(rows, first, last - 1)
    run = {"size": (max(3, int(0.02 * width)) | 1, 1), "mode": "nearest"}
    strip = in_float(band[visible - first, columns])
    strip = strip - median_filter(strip[: reach - 4].mean(axis=0), **run)
    face = median_filter(strip[reach + 3 : reach + 3 + inside].mean(axis=0), **run)
    # otherwise uneven light, no edge
    clear = (face**2).sum(axis=1) >= least_step**2
    level = np.einsum("rxc,xc->rx", strip, face) / np.maximum(
        (face**2).sum(axis=1), 1e-9
    )
    level = (np.roll(level, 1, 0) + 2 * level + np.roll(level, -1, 0)) / 4
    crossing = _first_crossing(level, rows == visible)
    found = np.where(known & clear, start + inward * (crossing - reach), np.nan)
    beyond = start >= height - 1.5 * factor if upward else start < 2 * factor
    # it goes on beyond the picture
    return np.where(known & beyond, height - 1.0 if upward else 0.0, found)


@dataclass(frozen=True)
class Edges:
    """Upper and lower edge of a pile in the picture: rows (w,) [px], NaN where it has
    none; found in a picture reduced by `factor`."""

    top: np.ndarray
    bottom: np.ndarray
    factor: float


def in_full_px(
    rows: np.ndarray, factor: float, width: int, origin: tuple[int, int] = (0, 0)
) -> np.ndarray:
    """Rows of a reduced picture's columns in every column of the full one, `width` px
    wide, in which its corner is `origin`; NaN where there is none."""
    at = np.rint((np.arange(width) - origin[0] + 0.5) / factor - 0.5).astype(int)
    found = (rows[np.clip(at, 0, rows.size - 1)] + 0.5) * factor - 0.5 + origin[1]
    return np.where((at >= 0) & (at <= rows.size), found, np.nan)


def _first_crossing(level: np.ndarray, visible: np.ndarray) -> np.ndarray:
    """Fractional index at which `level` first rises through ½ along axis 0; NaN where
    it starts above or never does."""
    before, after = level[1:-2], level[2:-1]
    rises = (before < 0.5) & (after >= 0.5) & visible[1:-2] & visible[2:-1]
    at, columns = rises.argmax(axis=0), np.arange(level.shape[1])
    a, b = before[at, columns], after[at, columns]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = 1 + at + (0.5 - a) / (b - a)
    return np.where(rises.any(axis=0), crossing, np.nan)
