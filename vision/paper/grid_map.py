"""The map from picture to graph paper: a homography and one term of lens distortion, fitted to the phases of the grid."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

# Priors of the camera, which matter only where the paper covers little of the picture.
PERSPECTIVE_SD = 0.05  # relative change of scale from the picture's centre to its corner (a phone leaning by some 3.5°)
DISTORTION_SD = 0.01  # relative displacement of the picture's corner by the lens


@dataclass(frozen=True)
class GridMap:
    """Paper coordinates u (right), v (down) [lines of the grid] of picture coordinates x, y [px; pixel centres integer].

    With X, Y = (x, y − `centre`) / `radius` · (1 + k·ρ²), ρ² = (|x, y − centre| / radius)²:
    u = (a1 X + a2 Y + a3) / (1 + g1 X + g2 Y), v likewise with b. `p` is (a1, a2, a3, b1, b2, b3, g1, g2, k).
    Valid for camera tilts below about 30° and distortion below about 10 % at the corner.
    """

    centre: tuple[float, float]
    radius: float
    p: np.ndarray

    def uv(self, x: ArrayLike, y: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Paper coordinates [grid lines] of picture points [px]."""
        X, Y, _ = self._undistorted(x, y)
        w = np.maximum(1 + self.p[6] * X + self.p[7] * Y, 0.05)
        return (self.p[0] * X + self.p[1] * Y + self.p[2]) / w, (self.p[3] * X + self.p[4] * Y + self.p[5]) / w

    def jacobian(self, x: ArrayLike, y: ArrayLike) -> np.ndarray:
        """∂(u, v)/∂(x, y) [grid lines per px], shape (..., 2, 2), by central differences over one pixel."""
        x, y = np.asarray(x, float), np.asarray(y, float)
        across = [np.subtract(a, b) for a, b in zip(self.uv(x + 0.5, y), self.uv(x - 0.5, y))]
        down = [np.subtract(a, b) for a, b in zip(self.uv(x, y + 0.5), self.uv(x, y - 0.5))]
        return np.stack([np.stack([across[0], down[0]], -1), np.stack([across[1], down[1]], -1)], -2)

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
            dk = ((c1 - value * self.p[6]) * X + (c2 - value * self.p[7]) * Y) / w * stretch
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


def from_waves(shape: tuple[int, int], at: tuple[float, float], wave_u: np.ndarray, wave_v: np.ndarray) -> GridMap:
    """A flat map with its origin at `at` [px] and the grid's wave vectors `wave_u`, `wave_v` [lines per px]."""
    height, width = shape
    centre, radius = ((width - 1) / 2, (height - 1) / 2), float(np.hypot(width, height) / 2)
    offset = np.subtract(centre, at)
    p = np.array([*(wave_u * radius), wave_u @ offset, *(wave_v * radius), wave_v @ offset, 0, 0, 0], dtype=float)
    return GridMap(centre, radius, p)


def fit_map(
    start: GridMap, x: np.ndarray, y: np.ndarray, u: np.ndarray, v: np.ndarray, weight_u: np.ndarray, weight_v: np.ndarray,
    sd: float, *, flat: bool = False,
) -> tuple[GridMap, np.ndarray]:  # fmt: skip
    """Gauss–Newton from `start` to the paper coordinates `u`, `v` measured at `x`, `y`; returns the map and its covariance.

    sd [lines]: of a measurement of weight 1; the camera has the priors above. flat: perspective and distortion are fixed.
    """
    prior = np.zeros(9)
    prior[6:8], prior[8] = (1e12, 1e12) if flat else (PERSPECTIVE_SD**-2, DISTORTION_SD**-2)
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
        p = current.p + np.linalg.lstsq(normal / np.outer(scale, scale), pull, rcond=None)[0] / scale
        p[6:8] = np.clip(p[6:8], -0.6, 0.6)
        p[8] = np.clip(p[8], -0.3, 0.3)
        current = replace(current, p=p)
    covariance = np.linalg.pinv(normal / np.outer(scale, scale), rcond=1e-14, hermitian=True) / np.outer(scale, scale)
    return current, covariance
