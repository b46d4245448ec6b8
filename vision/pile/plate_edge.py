"""The plate's edge beside the pile where it is too faint for the silhouette: a long, nearly level step in brightness."""

import cv2
import numpy as np

from vision.pile.heap import MAX_PLATE_SLOPE
from vision.pile.image import as_float, denoise
from vision.pile.line import Line, fit_line
from vision.pile.surface import Background

CLEAR = 6.0  # standard errors of a step's mean over the columns, below which it is none


def plate_edge(image: np.ndarray, background: Background, top: np.ndarray, floor: float) -> Line | None:
    """The plate's edge beside the pile, as a line in px of the full picture; None where there is none.

    top (w,): the silhouette's rows in the small picture, −1 beside the pile. For every slope within MAX_PLATE_SLOPE the vertical
    gradient is averaged over those columns; the strongest mean near the pile's lowest visible point is the edge, if it is
    CLEAR. It is then refined to sub-pixel rows on the full picture.
    """
    columns = np.flatnonzero(top < 0)
    columns = columns[(columns > 2) & (columns < top.size - 3)]
    if columns.size < 0.08 * top.size or (top >= 0).sum() < 8:
        return None
    grey = cv2.GaussianBlur(background.distance, (0, 0), 1.0)
    gradient = np.gradient(grey, axis=0)[:, columns]
    foot, reach = int(top.max()), max(12, int(0.15 * (top.max() - top[top >= 0].min())))
    noise = 1.4826 * float(np.median(np.abs(gradient - np.median(gradient)))) + 1e-3
    best = (0.0, 0.0, 0.0)
    middle = columns.mean()
    offsets = np.arange(foot - reach, foot + reach + 1)
    for slope in np.linspace(-MAX_PLATE_SLOPE, MAX_PLATE_SLOPE, 81):
        rows = offsets[:, None] + slope * (columns - middle)
        inside = (rows >= 2) & (rows <= grey.shape[0] - 3)
        steps = gradient[np.clip(np.rint(rows).astype(int), 0, grey.shape[0] - 1), np.arange(columns.size)]
        mean = np.where(inside.mean(axis=1) > 0.8, (steps * inside).sum(axis=1) / np.maximum(inside.sum(axis=1), 1), 0.0)
        at = int(np.abs(mean).argmax())
        alike = (steps[at] * np.sign(mean[at]) > 0.3 * abs(mean[at]))[inside[at]]  # a blot is not a line
        if abs(mean[at]) > abs(best[0]) and alike.mean() > 0.6:
            best = (float(mean[at]), slope, float(offsets[at]))
    step, slope, row = best
    if abs(step) < max(CLEAR * noise / np.sqrt(columns.size), 0.5):
        return None
    return _refine(image, background, columns, slope, row - slope * middle, np.sign(step), floor)


def _refine(image, background: Background, columns, slope, intercept, sign, floor) -> Line | None:
    """The line through the gradient's centroid in each full column beside the pile; None where that is no straight line."""
    factor, (height, width) = background.factor, image.shape[:2]
    x = np.arange(width)
    x = x[np.isin(((x + 0.5) / factor).astype(int), columns)]
    guess = (intercept + slope * ((x + 0.5) / factor - 0.5) + 0.5) * factor - 0.5
    reach = int(np.ceil(2.5 * factor)) + 3
    rows = np.rint(guess).astype(int) + np.arange(-reach, reach + 1)[:, None]
    fits = (rows.min(axis=0) >= 0) & (rows.max(axis=0) < height)
    x, rows = x[fits], rows[:, fits]
    if x.size < 16:
        return None
    first = rows.min()
    band = as_float(denoise(np.ascontiguousarray(image[first : rows.max() + 1])))
    strip = band[rows - first, x]
    face = (strip[-3:] - strip[:3]).mean(axis=(0, 1))
    level = strip @ (face / max(np.linalg.norm(face), 1e-9))
    rise = np.clip(np.gradient(cv2.blur(level, (1, 3)), axis=0), 0, None) ** 2
    weight = rise.sum(axis=0)
    clear = weight > 0.1 * np.median(weight)
    if clear.sum() < 16:
        return None
    y = (rows * rise).sum(axis=0) / np.maximum(weight, 1e-9)
    line = fit_line(x[clear], y[clear], floor)
    return line if line.rms < max(1.0, 0.7 * factor) and line.outlier_share < 0.4 else None
