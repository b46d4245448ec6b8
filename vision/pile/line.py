"""Least-squares lines through boundary points, with standard errors that allow for correlated grain roughness.

Neighbouring boundary points lie on the same grain: their residuals are not independent, and the textbook standard error
is many times too small. The slope's error is due to roughness at long wavelengths, of the order of the window. Therefore the
residuals are expanded in orthonormal polynomials over the window. The slope is polynomial 1; the coefficients of polynomials
2 … K+1, its neighbours in wavelength, show how large coefficient 1 is by chance:

    s² = mean(a₂² … a²_{K+1}),      se(slope) = s · t_{.975, K} / 1.96 / √Σ(x − x̄)²

K is at most a quarter of the number of roughness correlation lengths in the window, so that all K wavelengths are longer than
the grains. Few grains give a small K and, by Student's t, a wider interval. Curvature of the pile is part of s, too.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import t as student

EDGE_FLOOR_PX = 0.01  # least error of an edge, however smooth it is


@dataclass(frozen=True)
class Line:
    """y = intercept + slope · x, fitted between x_low and x_high.

    slope_sd: value ± 1.96 sd is a 95 % interval. rms: of the residuals (unit of y).
    outlier_share: of points farther off than 4 robust standard deviations.
    slope_low, slope_high: smallest and largest local slope of a cubic through the same points.
    cubic_share: of the residuals' variance that the cubic explains (little for grains, nearly all for an S-shaped surface).
    """

    slope: float
    intercept: float
    x_low: float
    x_high: float
    slope_sd: float
    rms: float
    outlier_share: float
    slope_low: float
    slope_high: float
    cubic_share: float

    def at(self, x: Any) -> Any:
        """y at x, a number or an array."""
        return self.intercept + self.slope * np.asarray(x)

    @property
    def angle_deg(self) -> float:
        """Inclination, positive where y grows with x."""
        return float(np.degrees(np.arctan(self.slope)))

    @property
    def angle_sd_deg(self) -> float:
        return float(np.degrees(self.slope_sd / (1 + self.slope**2)))


def fit_line(x: np.ndarray, y: np.ndarray, floor: float = 0.0) -> Line:
    """Least-squares line through points (x, y), n ≥ 8, with the standard error described at the head of this file.

    Points farther than 4 robust standard deviations from the line are left out (a stray seed, a scratch).
    floor: least error of the line at an end of the window, in units of y.
    Raises ValueError for fewer than 8 points or no extent in x.
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    order = np.argsort(x, kind="stable")
    x, y = x[order], y[order]
    if x.size < 8 or x[-1] - x[0] <= 0:
        raise ValueError(f"a line needs at least 8 points that differ in x; here are {x.size}")
    keep = np.ones(x.size, dtype=bool)
    for _ in range(4):
        slope, intercept = _least_squares(x[keep], y[keep])
        residual = y - intercept - slope * x
        spread = 1.4826 * np.median(np.abs(residual[keep] - np.median(residual[keep])))
        inliers = np.abs(residual) <= 4 * max(spread, 0.25)
        if (inliers == keep).all() or inliers.sum() < 8:
            break
        keep = inliers
    xk, rk = x[keep], residual[keep]
    s = _long_wave_sd(xk, rk, _correlation_lengths(rk))
    extent = np.sqrt(np.sum((xk - xk.mean()) ** 2))
    slope_sd = float(np.hypot(s / extent, floor / (xk[-1] - xk[0]) * 2))
    low, high, cubic_share = _cubic(xk, rk)
    return Line(
        slope=float(slope), intercept=float(intercept), x_low=float(x[0]), x_high=float(x[-1]), slope_sd=slope_sd,
        rms=float(np.sqrt(np.mean(rk**2))), outlier_share=float(1 - keep.mean()),
        slope_low=slope + low, slope_high=slope + high, cubic_share=cubic_share,
    )  # fmt: skip


def _least_squares(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    xc = x - x.mean()
    slope = float(xc @ y / (xc @ xc))
    return slope, float(y.mean() - slope * x.mean())


def _correlation_lengths(residual: np.ndarray) -> float:
    """Number of the roughness's correlation lengths in the window: n / (1 + 2 Σ ρ_k), summed up to the first ρ < 0.05."""
    n = residual.size
    padded = np.zeros(2 * n)
    padded[:n] = residual - residual.mean()
    power = np.abs(np.fft.rfft(padded)) ** 2
    correlation = np.fft.irfft(power)[:n]
    if correlation[0] <= 1e-12 * n:
        return float(n)
    correlation = correlation / correlation[0]
    end = int(np.argmax(correlation < 0.05)) or n
    return float(n / (1 + 2 * correlation[1:end].sum()))


def _long_wave_sd(x: np.ndarray, residual: np.ndarray, correlation_lengths: float) -> float:
    """t-widened root mean square of the residual's coefficients 2 … K+1 in orthonormal polynomials."""
    k = min(int(np.clip(correlation_lengths / 4, 4, 16)), x.size - 3)
    u = 2 * (x - x[0]) / (x[-1] - x[0]) - 1
    basis, _ = np.linalg.qr(np.polynomial.legendre.legvander(u, k + 1))
    spectrum = basis[:, 2:].T @ residual
    return float(np.sqrt(np.mean(spectrum**2)) * student.ppf(0.975, k) / 1.96)


def _cubic(x: np.ndarray, residual: np.ndarray) -> tuple[float, float, float]:
    """Smallest and largest slope of the residual's cubic inside the window, and the fraction of its variance that it explains."""
    centre, half = (x[0] + x[-1]) / 2, (x[-1] - x[0]) / 2
    u = (x - centre) / half
    cubic = np.polynomial.Polynomial.fit(u, residual, 3, domain=[-1, 1], window=[-1, 1])
    slopes = cubic.deriv()(np.linspace(-1, 1, 21)) / half
    total = float(residual @ residual)
    explained = 1 - float(np.sum((residual - cubic(u)) ** 2)) / total if total > 0 else 0.0
    return float(slopes.min()), float(slopes.max()), explained
