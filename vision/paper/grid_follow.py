"""Measures the phase of a grid in many windows of a picture and fits a map, outwards
from a first window."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from benchtwin.bench.robust import robust_sd
from benchtwin.vision.paper.grid_find import WINDOW_PX, GridCandidate, Level

# Squared phase amplitude over that of noise: noise alone exceeds it, in both families,
# in exp(−10) of all windows.
CLEAR = 5.0
# least share of clear windows that agree with the map: correct maps have 0.96 and more,
# a wrong one had 0.5
AGREEING = 0.75
# Priors of the camera, which matter only where the paper covers little of the picture.
# relative change of scale from the picture's centre to its corner (a phone leaning by
# some 3.5°)
PERSPECTIVE_SD = 0.05
DISTORTION_SD = 0.01  # relative displacement of the picture's corner by the lens


@dataclass(frozen=True)
class GridMap:
    """Paper coordinates u (right), v (down) [lines of the grid] of picture coordinates
    x, y [px; pixel centres integer].

    With X, Y = (x, y − `centre`) / `radius` · (1 + k·ρ²), ρ² = (|x, y − centre| /
    radius)²: u = (a1 X + a2 Y + a3) / (1 + g1 X + g2 Y), v likewise with b. `p` is (a1,
    a2, a3, b1, b2, b3, g1, g2, k). Valid for camera tilts below about 30° and
    distortion below about 10 % at the corner."""

    centre: tuple[float, float]
    radius: float
    p: np.ndarray

    def uv(self, x: ArrayLike, y: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Paper coordinates [grid lines] of picture points [px]."""
        X, Y, _ = self._undistorted(x, y)
        w = np.maximum(1 + self.p[6] * X + self.p[7] * Y, 0.05)
        return (self.p[0] * X + self.p[1] * Y + self.p[2]) / w, (
            self.p[3] * X + self.p[4] * Y + self.p[5]
        ) / w

    def jacobian(self, x: ArrayLike, y: ArrayLike) -> np.ndarray:
        """∂(u, v)/∂(x, y) [grid lines per px], shape (..., 2, 2), by central
        differences over one pixel."""
        x, y = np.asarray(x, float), np.asarray(y, float)
        across = [
            np.subtract(a, b) for a, b in zip(self.uv(x + 0.5, y), self.uv(x - 0.5, y))
        ]
        down = [
            np.subtract(a, b) for a, b in zip(self.uv(x, y + 0.5), self.uv(x, y - 0.5))
        ]
        return np.stack(
            [np.stack([across[0], down[0]], -1), np.stack([across[1], down[1]], -1)], -2
        )

    def with_density(self, factor: float) -> "GridMap":
        """The map in units of lines that are `factor` times as dense."""
        p = self.p.copy()
        p[:6] *= factor
        return replace(self, p=p)

    def shifted(self, du: float, dv: float) -> "GridMap":
        """The map with u and v increased by `du`, `dv` everywhere."""
        p = self.p.copy()
        p[:3] += du * np.array([p[6], p[7], 1.0])
        p[3:6] += dv * np.array([p[6], p[7], 1.0])
        return replace(self, p=p)

    def derivatives(self, x: ArrayLike, y: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """∂u/∂p and ∂v/∂p, each (n, 9)."""
        X, Y, rho2 = self._undistorted(x, y)
        w = np.maximum(1 + self.p[6] * X + self.p[7] * Y, 0.05)
        u, v = self.uv(x, y)
        one, zero = np.ones_like(X), np.zeros_like(X)
        stretch = rho2 / (1 + self.p[8] * rho2)  # dX/dk = X · stretch
        rows = []
        for value, (c1, c2), place in ((u, self.p[0:2], 0), (v, self.p[3:5], 3)):
            linear = [X / w, Y / w, one / w]
            dk = (
                ((c1 - value * self.p[6]) * X + (c2 - value * self.p[7]) * Y)
                / w
                * stretch
            )
            columns = [zero] * 6
            columns[place : place + 3] = linear
            rows.append(np.stack([*columns, -value * X / w, -value * Y / w, dk], -1))
        return rows[0], rows[1]

    def _undistorted(self, x, y):
        X = (np.asarray(x, float) - self.centre[0]) / self.radius
        Y = (np.asarray(y, float) - self.centre[1]) / self.radius
        rho2 = X * X + Y * Y
        bend = 1 + self.p[8] * rho2
        return X * bend, Y * bend, rho2


def from_waves(
    shape: tuple[int, int],
    at: tuple[float, float],
    wave_u: np.ndarray,
    wave_v: np.ndarray,
) -> GridMap:
    """A flat map with its origin at `at` [px] and the grid's wave vectors `wave_u`,
    `wave_v` [lines per px]."""
    height, width = shape
    centre = ((width - 1) / 2, (height - 1) / 2)
    radius = float(np.hypot(width, height) / 2)
    offset = np.subtract(centre, at)
    start = [*(wave_u * radius), wave_u @ offset, *(wave_v * radius), wave_v @ offset]
    p = np.array([*start, 0, 0, 0], dtype=float)
    return GridMap(centre, radius, p)


def fit_map(
    start: GridMap,
    x: np.ndarray,
    y: np.ndarray,
    u: np.ndarray,
    v: np.ndarray,
    weight_u: np.ndarray,
    weight_v: np.ndarray,
    sd: float,
    *,
    flat: bool = False,
) -> tuple[GridMap, np.ndarray]:
    """Gauss–Newton from `start` to the paper coordinates `u`, `v` measured at `x`, `y`;
    returns the map and its covariance. sd [lines]: of a measurement of weight 1; the
    camera has the priors above. flat: perspective and distortion are fixed."""
    prior = np.zeros(9)
    prior[6:8], prior[8] = (
        (1e12, 1e12) if flat else (PERSPECTIVE_SD**-2, DISTORTION_SD**-2)
    )
    root = np.concatenate([np.sqrt(weight_u), np.sqrt(weight_v)]) / sd
    centre = start.p if flat else np.zeros(9)
    current = start
    for _ in range(5):
        du, dv = current.derivatives(x, y)
        design = np.concatenate([du, dv]) * root[:, None]
        now_u, now_v = current.uv(x, y)
        gap = np.concatenate([u - now_u, v - now_v]) * root
        normal = design.T @ design + np.diag(prior)
        scale = np.sqrt(np.diag(normal)) + 1e-12
        pull = (design.T @ gap - prior * (current.p - centre)) / scale
        scaled = normal / np.outer(scale, scale)
        p = current.p + np.linalg.lstsq(scaled, pull, rcond=None)[0] / scale
        p[6:8] = np.clip(p[6:8], -0.6, 0.6)
        p[8] = np.clip(p[8], -0.3, 0.3)
        current = replace(current, p=p)
    covariance = np.linalg.pinv(
        normal / np.outer(scale, scale), rcond=1e-14, hermitian=True
    ) / np.outer(scale, scale)
    return current, covariance


@dataclass(frozen=True)
class Windows:
    """Windows of one level, weighted by a Hann bell: `h` (n, t, t); centres `x`, `y`
    [full-resolution px]."""

    h: np.ndarray
    energy: np.ndarray
    x: np.ndarray
    y: np.ndarray
    fx: float
    fy: float
    step_px: float

    def select(self, mask: np.ndarray) -> "Windows":
        energy = self.energy[mask]
        return replace(
            self, h=self.h[mask], energy=energy, x=self.x[mask], y=self.y[mask]
        )


def cut_windows(
    level: Level,
    size: int,
    step: float,
    around: tuple[float, float, float] | None = None,
) -> Windows:
    """Windows of `size` px every `step` px of the level, all over it or within `around`
    = (x, y, half side) [full px]."""
    height, width = level.lines.shape
    size = max(4, min(size, height, width))
    low, high = (0.0, 0.0), (width - size, height - size)
    if around:
        cx, cy = map(float, level.reduced(around[0], around[1]))
        reach = around[2] / level.factor
        low = (max(0.0, cx - reach - size / 2), max(0.0, cy - reach - size / 2))
        high = (
            min(high[0], cx + reach - size / 2),
            min(high[1], cy + reach - size / 2),
        )
    count = [max(1, int(np.ceil((b - a) / step)) + 1) for a, b in zip(low, high)]
    xs, ys = (
        np.unique(np.rint(np.linspace(a, max(a, b), n)).astype(int))
        for a, b, n in zip(low, high, count)
    )
    xs, ys = np.clip(xs, 0, width - size), np.clip(ys, 0, height - size)
    hann = np.hanning(size + 2)[1:-1].astype(np.float32)
    bell = np.outer(hann, hann)
    h = np.lib.stride_tricks.sliding_window_view(level.lines, (size, size))[
        np.ix_(ys, xs)
    ].reshape(-1, size, size)
    h = (h - h.mean((1, 2), keepdims=True)) * bell
    x, y = np.meshgrid(xs + (size - 1) / 2, ys + (size - 1) / 2)
    x, y = level.full(x.ravel(), y.ravel())
    return Windows(
        h, (h * h).sum((1, 2)) + 1e-9, x, y, level.fx, level.fy, step * level.factor
    )


def phases(windows: Windows, grid: GridMap) -> tuple[np.ndarray, np.ndarray]:
    """Distance of the lines in each window from those of `grid`, in lines (−0.5…0.5),
    and their clearness. C = Σ h·exp(−2πi·w) over the window with w the map's u (or v),
    taken linear within the window; the gap is arg C / 2π and the clearness |C|² / Σh²,
    about 1 for noise. Both (n, 2), for u and v."""
    jacobian = grid.jacobian(windows.x, windows.y)
    size = windows.h.shape[1]
    # Where the map bends within the window, its mean over the bell is not its value at
    # the centre: + ½ σ² Δu.
    reach = np.sqrt(1 / 12 - 1 / (2 * np.pi**2)) * size
    at = np.stack(grid.uv(windows.x, windows.y), -1)
    around = [
        (reach * windows.fx, 0),
        (-reach * windows.fx, 0),
        (0, reach * windows.fy),
        (0, -reach * windows.fy),
    ]
    at = (
        sum(np.stack(grid.uv(windows.x + dx, windows.y + dy), -1) for dx, dy in around)
        / 2
        - at
    )
    offset = np.arange(size) - (size - 1) / 2
    gap, clear = np.empty_like(at), np.empty_like(at)
    for family in (0, 1):
        across = np.exp(
            -2j * np.pi * np.outer(jacobian[:, family, 0] * windows.fx, offset)
        ).astype(np.complex64)
        down = np.exp(
            -2j * np.pi * np.outer(jacobian[:, family, 1] * windows.fy, offset)
        ).astype(np.complex64)
        rows = np.matmul(windows.h, np.stack([across.real, across.imag], -1))
        total = ((rows[..., 0] + 1j * rows[..., 1]) * down).sum(1) * np.exp(
            -2j * np.pi * at[:, family]
        )
        gap[:, family] = np.angle(total) / (2 * np.pi)
        clear[:, family] = np.abs(total) ** 2 / windows.energy
    return gap, clear


@dataclass(frozen=True)
class Fit:
    """A map fitted to windows: those used, their residuals [lines] (n, 2), and the
    covariance for unit sd."""

    grid: GridMap
    windows: Windows
    residual: np.ndarray
    covariance: np.ndarray


def follow_grid(
    grid: GridMap,
    windows: Windows,
    start: tuple[float, float],
    reach: float,
    *,
    flat: bool = False,
) -> Fit | None:
    """Fit the map outwards from `start`: within `reach` [full px], which grows until
    all windows are included. A window is used where both families are clear, their gaps
    are within a gate that narrows to four robust sd, and two neighbours are used too.
    flat: without perspective and lens distortion. None where fewer than three windows
    are left, or many clear ones disagree."""
    away = np.hypot(windows.x - start[0], windows.y - start[1])
    reach = max(reach, float(np.sort(away)[min(3, len(away) - 1)]))
    gate, last = 0.25, 0
    while last < 4:
        last += reach > away.max()  # four more rounds once all windows are included
        here = np.flatnonzero(away <= reach)
        gap, clear = phases(windows.select(here), grid)
        use = (clear > CLEAR).all(1) & (np.abs(gap) < gate).all(1)
        if last and use.any():  # the edge disturbs windows half off the paper
            use &= (clear > 0.45 * np.median(clear[use], 0)).all(1)
        use &= _has_neighbour(windows.x[here], windows.y[here], use, windows.step_px)
        if use.sum() < 3:
            return None
        chosen, gap = here[use], gap[use]
        u, v = grid.uv(windows.x[chosen], windows.y[chosen])
        spread = max(robust_sd(gap - np.median(gap, 0)), 0.003)
        weight = 1 / np.maximum(1, np.abs(gap) / (2 * spread))
        x, y = windows.x[chosen], windows.y[chosen]
        # errors of neighbouring windows are correlated (paper that is not flat): nine
        # count as one
        sd = 3 * max(spread, 0.01)
        grid, covariance = fit_map(
            grid,
            x,
            y,
            u + gap[:, 0],
            v + gap[:, 1],
            weight[:, 0],
            weight[:, 1],
            sd,
            flat=flat,
        )
        gate = float(np.clip(5 * spread, 0.1, 0.25)) if last else 0.25
        reach *= 1.4
    # Where the map is off by a line, as many clear windows disagree with it as agree.
    strong = (clear > 0.45 * np.median(clear[use], 0)).all(1)
    if use.sum() < AGREEING * strong.sum():
        return None
    used = windows.select(chosen)
    residual, _ = phases(used, grid)
    return Fit(grid, used, residual, covariance)


def _has_neighbour(
    x: np.ndarray, y: np.ndarray, use: np.ndarray, step: float
) -> np.ndarray:
    """Whether at least two other used windows lie within one and a half steps."""
    if use.sum() < 3:
        return use
    tree = cKDTree(np.stack([x[use], y[use]], -1))
    count = np.zeros(len(x), int)
    count[use] = [
        len(n)
        for n in tree.query_ball_point(np.stack([x[use], y[use]], -1), 1.6 * step)
    ]
    return count >= 3


def start_map(
    levels: list[Level], seed: GridCandidate, shape: tuple[int, int]
) -> GridMap | None:
    """A first map from a candidate, refined on dense windows around it."""
    level = levels[seed.level]
    grid = from_waves(shape, seed.at, seed.wave_u / level.fx, seed.wave_v / level.fy)
    near = cut_windows(
        level, WINDOW_PX, WINDOW_PX / 4, (*seed.at, WINDOW_PX * level.factor)
    )
    centre = int(np.argmin(np.hypot(near.x - seed.at[0], near.y - seed.at[1])))
    gap, _ = phases(near.select(np.arange(len(near.x)) == centre), grid)
    grid = grid.shifted(float(gap[0, 0]), float(gap[0, 1]))
    fit = follow_grid(grid, near, seed.at, WINDOW_PX * level.factor / 3, flat=True)
    return fit.grid if fit else None
