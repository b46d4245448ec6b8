"""Least-squares lines through boundary points, with standard errors that hold although grain roughness is correlated.

Neighbouring boundary points lie on the same grain: their residuals are not independent, and the textbook standard error
is many times too small. What decides how far the slope is off is the roughness at *long* wavelengths, of the order of the
window. So the residuals are expanded in orthonormal polynomials over the window: the slope is polynomial 1, and the
coefficients of polynomials 2 … K+1, its neighbours in wavelength, show directly how large coefficient 1 is by chance:

    s² = mean(a₂² … a²_{K+1}),      se(slope) = s · t_{.975, K} / 1.96 / √Σ(x − x̄)²

K is at most the number of roughness correlation lengths in the window over 4, so that all K wavelengths are longer than
the grains; few grains give a small K and, through Student's t, a wider interval. Curvature of the pile enters s as well.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import t as student

EDGE_FLOOR_PX = 0.01  # an edge is not believed better than this, however smooth it is


@dataclass(frozen=True)
class Line:
    """y = intercept + slope · x, fitted between x_low and x_high.

    slope_sd: one standard deviation (value ± 1.96 sd is a 95 % interval); rms: residual (unit of y); n: points used;
    left_out: fraction of points farther than 4 robust standard deviations; lengths: roughness correlation lengths in the window;
    slope_low, slope_high: smallest and largest local slope of the cubic through the same points; bent: fraction of the residual's
    variance that the cubic takes away (grains leave little to it, an S-shaped surface nearly all).
    """

    slope: float
    intercept: float
    x_low: float
    x_high: float
    slope_sd: float
    rms: float
    n: int
    left_out: float
    lengths: float
    slope_low: float
    slope_high: float
    bent: float

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

    Points farther than 4 robust standard deviations from the line are left out (a stray seed, a scratch). `floor`, in units
    of y, is the smallest error that the fitted line is believed to have at an end of the window.
    Raises ValueError with fewer than 8 points or no extent in x.
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    order = np.argsort(x, kind="stable")
    x, y = x[order], y[order]
    if x.size < 8 or x[-1] - x[0] <= 0:
        raise ValueError(f"a line needs at least 8 points that differ in x; here are {x.size}")
    keep = np.ones(x.size, dtype=bool)
    for _ in range(4):
        slope, intercept = _straight(x[keep], y[keep])
        residual = y - intercept - slope * x
        spread = 1.4826 * np.median(np.abs(residual[keep] - np.median(residual[keep])))
        again = np.abs(residual) <= 4 * max(spread, 0.25)
        if (again == keep).all() or again.sum() < 8:
            break
        keep = again
    xk, rk = x[keep], residual[keep]
    lengths = _correlation_lengths(rk)
    s = _long_wave_sd(xk, rk, lengths)
    extent = np.sqrt(np.sum((xk - xk.mean()) ** 2))
    slope_sd = float(np.hypot(s / extent, floor / (xk[-1] - xk[0]) * 2))
    low, high, bent = _cubic(xk, rk)
    return Line(
        slope=float(slope), intercept=float(intercept), x_low=float(x[0]), x_high=float(x[-1]), slope_sd=slope_sd,
        rms=float(np.sqrt(np.mean(rk**2))), n=int(keep.sum()), left_out=float(1 - keep.mean()), lengths=lengths,
        slope_low=slope + low, slope_high=slope + high, bent=bent,
    )  # fmt: skip


def _straight(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    xc = x - x.mean()
    slope = float(xc @ y / (xc @ xc))
    return slope, float(y.mean() - slope * x.mean())


def _correlation_lengths(residual: np.ndarray) -> float:
    """How many correlation lengths of the roughness the window holds: n / (1 + 2 Σ ρ_k), summed to the first ρ ≤ 0.05."""
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


def _long_wave_sd(x: np.ndarray, residual: np.ndarray, lengths: float) -> float:
    """t-widened root mean square of the residual's coefficients 2 … K+1 in orthonormal polynomials."""
    k = min(int(np.clip(lengths / 4, 4, 16)), x.size - 3)
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
