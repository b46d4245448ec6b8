"""Steps from a photo to a mask, one function each: reduce, denoise, fit the illumination, find a threshold."""

import cv2
import numpy as np

WORKING_PX = 1024  # longest side of the reduced picture; edges are read off the full one


def shrink(image: np.ndarray, longest_px: int = WORKING_PX) -> tuple[np.ndarray, float]:
    """The picture with its longest side at most `longest_px` (area-averaged, float32, 0–255), and the factor px : px'."""
    factor = max(1.0, max(image.shape[:2]) / longest_px)
    size = (max(1, round(image.shape[1] / factor)), max(1, round(image.shape[0] / factor)))
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA) if factor > 1 else image
    return as_float(small), factor


def as_float(image: np.ndarray) -> np.ndarray:
    """Pixels as float32 on the scale 0–255, whatever the depth; always (height, width, channels)."""
    scale = 255.0 / np.iinfo(image.dtype).max if np.issubdtype(image.dtype, np.integer) else 1.0
    pixels = image.astype(np.float32) * np.float32(scale)
    return pixels if pixels.ndim == 3 else pixels[..., None]


def denoise(image: np.ndarray, aperture_px: int = 5) -> np.ndarray:
    """Median over aperture_px × aperture_px (at most 5 for float and 16-bit pictures): removes single wrong pixels."""
    blurred = cv2.medianBlur(image, aperture_px)
    return blurred.reshape(image.shape)


def fit_illumination(image: np.ndarray, where: np.ndarray, order: int = 2) -> np.ndarray:
    """Polynomial of `order` in x and y for each channel, fitted to the pixels of `where` without outliers: (terms, channels)."""
    height, width = where.shape
    y, x = np.nonzero(where)
    step = max(1, y.size // 20_000)  # a smooth surface needs no more
    y, x = y[::step], x[::step]
    terms, values = _terms(x / width, y / height, order), image[y, x]
    keep = np.ones(y.size, dtype=bool)
    for _ in range(3):
        coefficients, *_ = np.linalg.lstsq(terms[keep], values[keep], rcond=None)
        residual = np.linalg.norm(values - terms @ coefficients, axis=1)
        limit = 3 * max(1.48 * float(np.median(residual)), 0.5)
        if keep.sum() == (kept := residual < limit).sum() or kept.sum() < 10 * terms.shape[1]:
            break
        keep = kept
    return coefficients


def illumination_at(coefficients: np.ndarray, x: np.ndarray, y: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """The fitted illumination (…, channels) at pixels x, y of a picture of `shape` (height, width)."""
    order = {1: 0, 3: 1, 6: 2}[coefficients.shape[0]]
    x, y = np.asarray(x, dtype=np.float32), np.asarray(y, dtype=np.float32)
    flat = _terms(np.ravel(x) / shape[1], np.ravel(y) / shape[0], order) @ coefficients.astype(np.float32)
    return flat.reshape(*x.shape, coefficients.shape[1])


def binarise(grey: np.ndarray) -> tuple[float, float]:
    """Otsu's threshold (1979) on a grey picture, and its separability σ²_between / σ²_total (noise alone gives about 0.64)."""
    low, high = float(grey.min()), float(grey.max())
    if high - low < 1e-6:
        return high, 0.0
    counts, edges = np.histogram(grey, bins=512, range=(low, high))
    middles = (edges[:-1] + edges[1:]) / 2
    weight = np.cumsum(counts) / counts.sum()
    mean = np.cumsum(counts * middles) / counts.sum()
    total = mean[-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        between = np.where((weight > 0) & (weight < 1), (total * weight - mean) ** 2 / (weight * (1 - weight)), 0.0)
    variance = float((counts * (middles - total) ** 2).sum() / counts.sum())
    best = between >= between.max() * (1 - 1e-9)  # an empty valley is a plateau: take its middle
    return float(edges[1:][best].mean()), float(between.max() / variance)


def _terms(x: np.ndarray, y: np.ndarray, order: int) -> np.ndarray:
    one = np.ones_like(x)
    columns = [one] if order == 0 else [one, x, y] if order == 1 else [one, x, y, x * x, x * y, y * y]
    return np.stack(columns, axis=1)
