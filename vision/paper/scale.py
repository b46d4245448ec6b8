"""Graph paper in the picture → millimetres per pixel at every place, with standard
deviation."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike

from benchtwin.vision.measurement import DOUBTFUL, GOOD, MeasurementError
from benchtwin.vision.paper.grid_find import Level, find_candidates, pyramid
from benchtwin.vision.paper.grid_follow import (
    Fit,
    GridMap,
    cut_windows,
    fit_map,
    follow_grid,
    start_map,
)
from benchtwin.vision.paper.grid_pitch import Pitch, find_pitch

# relative: commercial graph paper keeps its millimetres to about 0.1–0.2 % (print,
# moisture)
PAPER_SD = 0.001
SMALLEST_PX = 32
MAX_WINDOWS = 2000
CANDIDATES = 8
DOUBTFUL_SD = 0.03  # relative


@dataclass(frozen=True)
class Scale:
    """What graph paper says of a picture. Valid in the paper's plane; what lies h above
    it, at camera distance D, is seen larger by h/D.

    `mm_per_px` ± `mm_per_px_sd` holds at the picture's centre, `paper_mm_per_px` ±
    `paper_mm_per_px_sd` at the paper's. It is the geometric mean of all directions,
    √|det ∂(mm)/∂(px)|. The sd contains the lines' scatter, its correlation from place
    to place, extrapolation beyond the paper (see `grid_follow`), and the paper's own
    error, `paper_sd`. `tilt_deg` ± `tilt_sd_deg`: direction of the grid's vertical
    lines at the paper's centre, clockwise from straight down, −45° to 45° (the sign of
    `plumb_deg`). `variation`: (largest − smallest) / centre of mm_per_px over the
    picture. `region`: polygon (n, 2) around the paper that was read [px]. `lines`:
    measured windows."""

    mm_per_px: float
    mm_per_px_sd: float
    paper_mm_per_px: float
    paper_mm_per_px_sd: float
    tilt_deg: float
    tilt_sd_deg: float
    variation: float
    region: np.ndarray
    lines: int
    line_mm: float
    grid: GridMap
    covariance: np.ndarray
    paper_sd: float
    quality: str = GOOD
    reason: str = ""

    def at(self, x_px: ArrayLike, y_px: ArrayLike) -> Any:
        """mm per px at places of the picture: scalar or array like x_px, y_px."""
        return _mean_scale(self.grid, x_px, y_px)

    def sd_at(self, x_px: float, y_px: float) -> float:
        """One standard deviation of `at` [mm per px], the paper's own error
        included."""
        of_fit = _relative_sd(self.grid, self.covariance, x_px, y_px)
        return float(self.at(x_px, y_px) * np.hypot(of_fit, self.paper_sd))

    def to_mm(self, x_px: ArrayLike, y_px: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Places on the paper [mm] of picture points [px]: perspective and lens
        distortion taken out."""
        return self.grid.uv(x_px, y_px)


def read_scale(image: np.ndarray, *, paper_sd: float = PAPER_SD) -> Scale:
    """Find millimetre graph paper (dark lines on lighter paper) anywhere in `image` and
    read the scale from it.

    image: (h, w) or (h, w, 3), uint8 or uint16. The phase of the grid in many windows
    is fitted by a homography and one distortion term; which lines are 1, 5 and 10 mm is
    decided by their strengths. Works for 2.5 to 130 px between the finest lines that
    are visible, turned by any angle (reported within ±45°), tipped by up to 30°.
    `paper_sd` is the relative sd of the paper's own millimetres. Raises
    MeasurementError when there is no graph paper, or when the distance of its lines is
    ambiguous."""
    grey = darkest_channel(image)
    levels = pyramid(grey)
    rng = np.random.default_rng(0)
    ambiguous: list[tuple[Fit, Pitch]] = []
    for candidate in find_candidates(levels)[:CANDIDATES]:
        grid = start_map(levels, candidate, (grey.shape[0], grey.shape[1]))
        fit = None if grid is None else _follow(levels, grid, candidate.at)
        pitch = None if fit is None else find_pitch(fit, levels, rng)
        if fit is None or pitch is None:
            continue
        if pitch.mm is not None:
            return _finish(fit, pitch, pitch.mm, levels, paper_sd)
        ambiguous.append((fit, pitch))
        if len(ambiguous) == 3:  # three places suffice
            break
    if ambiguous:
        raise MeasurementError(_ambiguity(*ambiguous[0]))
    raise MeasurementError(
        "no millimetre graph paper found in the picture (two crossing families of fine"
        " lines, every fifth or tenth heavier)"
    )


def darkest_channel(image: np.ndarray) -> np.ndarray:
    """The minimum of the channels, float32 0–1, in which ink of any colour is dark."""
    if not isinstance(image, np.ndarray) or image.dtype not in (np.uint8, np.uint16):
        raise MeasurementError("a picture must have 8 or 16 bits a channel")
    if image.ndim not in (2, 3) or (image.ndim == 3 and image.shape[2] not in (1, 3)):
        raise MeasurementError(
            f"a picture must be grey or RGB, not an array of shape {image.shape}"
        )
    if min(image.shape[:2]) < SMALLEST_PX:
        raise MeasurementError(
            f"the picture is too small ({image.shape[1]} × {image.shape[0]} px) to find"
            " graph paper in it"
        )
    if image.ndim == 3:
        if image.shape[2] == 3:
            image = cv2.min(cv2.min(image[..., 0], image[..., 1]), image[..., 2])
        else:
            image = image[..., 0]
    return image.astype(np.float32) / np.float32(np.iinfo(image.dtype).max)


def _follow(
    levels: list[Level], grid: GridMap, start: tuple[float, float]
) -> Fit | None:
    """Fit `grid` to all of the picture, on the level where its lines lie 6 to 12 px
    apart (or the finest)."""
    jacobian = grid.jacobian(*start)
    pitch_px = 1 / np.sqrt(abs(np.linalg.det(jacobian)) + 1e-12)
    if not 2 < pitch_px < 2000:
        return None
    level = levels[int(np.clip(np.floor(np.log2(pitch_px / 6)), 0, len(levels) - 1))]
    own_pitch = pitch_px / level.factor
    size = int(np.clip(round(4.5 * own_pitch), 20, 96))
    height, width = level.lines.shape
    step = max(0.45 * size, np.sqrt(height * width / MAX_WINDOWS))
    return follow_grid(
        grid, cut_windows(level, size, step), start, 2.5 * step * level.factor
    )


def _finish(
    fit: Fit, pitch: Pitch, line_mm: float, levels: list[Level], paper_sd: float
) -> Scale:
    middle = (float(fit.windows.x.mean()), float(fit.windows.y.mean()))
    finest = fit.grid.with_density(1 / pitch.ratio)
    finest = finest.shifted(-pitch.shift[0], -pitch.shift[1])
    refollowed = _follow(levels, finest, middle) or replace(fit, grid=finest)
    grid, covariance = _refit_with_correlated_errors(refollowed)
    grid, region = grid.with_density(line_mm), _hull(refollowed)
    covariance = covariance * np.outer(*[np.where(np.arange(9) < 6, line_mm, 1)] * 2)
    centre, middle = grid.centre, tuple(region.mean(0))
    height, width = 2 * centre[1] + 1, 2 * centre[0] + 1
    corners = _mean_scale(
        grid,
        *np.array([[0, 0], [width, 0], [0, height], [width, height], centre], float).T,
    )
    sds = [
        np.hypot(_relative_sd(grid, covariance, *place), paper_sd)
        for place in (centre, middle)
    ]
    values = [float(_mean_scale(grid, *place)) for place in (centre, middle)]
    reasons = [f"of the paper's lines {pitch.pattern}"] if pitch.pattern else []
    if sds[0] > DOUBTFUL_SD:
        reasons.append(
            "the paper gives the scale at the picture's centre only to"
            f" ±{100 * sds[0]:.0f} %"
        )
    return Scale(
        *(values[0], float(values[0] * sds[0]), values[1], float(values[1] * sds[1])),
        *_tilt(grid, covariance, middle),
        variation=float(np.ptp(corners) / values[0]),
        region=region,
        lines=len(refollowed.windows.x),
        line_mm=line_mm,
        grid=grid,
        covariance=covariance,
        paper_sd=paper_sd,
        quality=DOUBTFUL if reasons else GOOD,
        reason="; ".join(reasons),
    )


def _refit_with_correlated_errors(fit: Fit) -> tuple[GridMap, np.ndarray]:
    """Refit with the sd of the residuals, enlarged where errors of neighbouring windows
    are correlated. If windows erred independently, means over blocks of m windows would
    scatter by 1/√m of a single one; the factor by which they scatter more (paper that
    is not flat, a lens beyond the model) widens the sd."""
    w, n = fit.windows, len(fit.windows.x)
    freedom = max(2 * n - 9, 2)
    sd = float(np.sqrt((fit.residual**2).sum() / freedom))
    blocks = np.stack(
        [np.floor(w.x / (3 * w.step_px)), np.floor(w.y / (3 * w.step_px))], -1
    )
    _, label = np.unique(blocks, axis=0, return_inverse=True)
    label = label.ravel()
    count = np.bincount(label)
    sums = np.stack([np.bincount(label, fit.residual[:, f]) for f in (0, 1)])
    together = (
        float((sums**2 / count).mean() / max(sd**2, 1e-12)) if len(count) > 3 else 2.0
    )
    # Windows beside the paper's edge or covered parts have the largest errors; the last
    # factor is from drawn strips of few windows.
    sd = max(sd, 1e-3) * np.sqrt(max(1.0, together)) * (1 + min(60 / n, 1))
    u, v = np.stack(fit.grid.uv(w.x, w.y)) + fit.residual.T
    weight_u, weight_v = 1 / np.maximum(1, np.abs(fit.residual.T) / (2 * sd))
    return fit_map(fit.grid, w.x, w.y, u, v, weight_u, weight_v, sd)


def _mean_scale(grid: GridMap, x, y):
    return np.sqrt(np.abs(np.linalg.det(grid.jacobian(x, y))) + 1e-300)


def _relative_sd(grid: GridMap, covariance: np.ndarray, x: float, y: float) -> float:
    return _sd(grid, covariance, lambda g: float(np.log(_mean_scale(g, x, y))))


def _tilt(
    grid: GridMap, covariance: np.ndarray, at: tuple[float, float]
) -> tuple[float, float]:
    """Direction of the lines of constant u at `at` [deg, clockwise from straight down]
    and its sd."""

    def turn(g: GridMap) -> float:
        j = g.jacobian(*at)
        # along (−∂u/∂y, ∂u/∂x) u does not change
        return float(np.degrees(np.arctan2(j[0, 1], j[0, 0])))

    return turn(grid), _sd(grid, covariance, turn)


def _sd(
    grid: GridMap, covariance: np.ndarray, value: Callable[[GridMap], float]
) -> float:
    """sd of a value of the map, by central differences."""
    slopes = []
    for i in range(9):
        h = 1e-5 * max(1.0, np.abs(grid.p[:6]).max()) if i < 6 else 1e-5
        up, down = grid.p.copy(), grid.p.copy()
        up[i], down[i] = up[i] + h, down[i] - h
        slopes.append(
            (value(replace(grid, p=up)) - value(replace(grid, p=down))) / (2 * h)
        )
    return float(np.sqrt(max(np.array(slopes) @ covariance @ slopes, 0.0)))


def _hull(fit: Fit) -> np.ndarray:
    """Convex hull [px] of the windows used."""
    half = fit.windows.h.shape[1] * fit.windows.fx / 2
    corners = [
        np.stack([fit.windows.x + a, fit.windows.y + b], -1)
        for a in (-half, half)
        for b in (-half, half)
    ]
    return cv2.convexHull(np.concatenate(corners).astype(np.float32))[:, 0].astype(
        float
    )


def _ambiguity(fit: Fit, pitch: Pitch) -> str:
    finest = fit.grid.with_density(1 / pitch.ratio)
    x, y = fit.windows.x.mean(), fit.windows.y.mean()
    line_px = 1 / float(_mean_scale(finest, x, y))
    mm, scales = (
        " or ".join(f"{f * m:.5g}" for m in pitch.may_be) for f in (1.0, 1 / line_px)
    )
    return (
        f"the picture shows lines every {line_px:.4g} px, {pitch.pattern}: whether they"
        f" are {mm} mm apart cannot be told; state [camera] mm_per_px ({scales})"
    )
