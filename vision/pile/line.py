"""Least-squares lines through boundary points, with standard errors that allow for
correlated grain roughness.

Neighbouring boundary points lie on the same grain: their residuals are not independent,
and the textbook standard error is many times too small. The slope's error is due to
roughness at long wavelengths, of the order of the window. Therefore the residuals are
expanded in orthonormal polynomials over the window. The slope is polynomial 1; the
coefficients of polynomials 2 … K+1, its neighbours in wavelength, show how large
coefficient 1 is by chance:

    s² = mean(a₂² … a²_{K+1}),      se(slope) = s · t_{.975, K} / 1.96 / √Σ(x − x̄)²

K is at most a quarter of the number of roughness correlation lengths in the window, so
that all K wavelengths are longer than the grains. Few grains give a small K and, by
Student's t, a wider interval. Curvature of the pile is part of s, too."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from benchtwin.bench.distributions import t as student
from benchtwin.bench.language import tr
from benchtwin.bench.robust import robust_sd
from benchtwin.bench.slope_window import line_window
from benchtwin.vision.pile.heap import BaseLine, Flank, Heap

EDGE_FLOOR_PX = 0.01  # least error of an edge, however smooth it is
LEAST_DEG, ROUGH = 3.0, 0.25  # flatter, or rms over its rise: no flank
STEEP_DEG = 50.0  # beyond this an angle is doubtful
MOST_OUTLIERS = 0.1
LEAST_COLUMNS = 8  # of a line


@dataclass(frozen=True)
class Line:
    """y = intercept + slope · x, fitted between x_low and x_high.

    slope_sd: value ± 1.96 sd is a 95 % interval. rms: of the residuals (unit of y).
    outlier_share: of points farther off than 4 robust standard deviations. slope_low,
    slope_high: smallest and largest local slope of a cubic through the same points.
    cubic_share: of the residuals' variance that the cubic explains (little for grains,
    nearly all for an S-shaped surface)."""

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
    """Least-squares line through points (x, y), n ≥ 8, with the standard error
    described at the head of this file. Points farther than 4 robust standard deviations
    from the line are left out (a stray seed, a scratch). floor: least error of the line
    at an end of the window, in units of y. Raises ValueError for fewer than 8 points or
    no extent in x."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    order = np.argsort(x, kind="stable")
    x, y = x[order], y[order]
    if x.size < LEAST_COLUMNS or x[-1] - x[0] <= 0:
        raise ValueError(
            tr("a line needs at least 8 points that differ in x; here are {}", x.size)
        )
    keep = np.ones(x.size, dtype=bool)
    for _ in range(4):
        centred, middle = x[keep] - x[keep].mean(), y[keep].mean()
        slope = float(centred @ y[keep] / (centred @ centred))
        intercept = float(middle - slope * x[keep].mean())
        residual = y - intercept - slope * x
        spread = robust_sd(residual[keep] - np.median(residual[keep]))
        inliers = np.abs(residual) <= 4 * max(spread, 0.25)
        if (inliers == keep).all() or inliers.sum() < LEAST_COLUMNS:
            break
        keep = inliers
    xk, rk = x[keep], residual[keep]
    s = _long_wave_sd(xk, rk, _correlation_lengths(rk))
    extent = np.sqrt(np.sum((xk - xk.mean()) ** 2))
    slope_sd = float(np.hypot(s / extent, floor / (xk[-1] - xk[0]) * 2))
    low, high, cubic_share = _cubic(xk, rk)
    return Line(
        slope=float(slope),
        intercept=float(intercept),
        x_low=float(x[0]),
        x_high=float(x[-1]),
        slope_sd=slope_sd,
        rms=float(np.sqrt(np.mean(rk**2))),
        outlier_share=float(1 - keep.mean()),
        slope_low=slope + low,
        slope_high=slope + high,
        cubic_share=cubic_share,
    )


def _correlation_lengths(residual: np.ndarray) -> float:
    """Number of the roughness's correlation lengths in the window: n / (1 + 2 Σ ρ_k),
    summed up to the first ρ < 0.05."""
    n = residual.size
    rough = residual - residual.mean()
    correlation = np.correlate(rough, rough, "full")[n - 1 :]
    if correlation[0] <= 1e-12 * n:
        return float(n)
    correlation = correlation / correlation[0]
    end = int(np.argmax(correlation < 0.05)) or n
    return float(n / (1 + 2 * correlation[1:end].sum()))


def _long_wave_sd(
    x: np.ndarray, residual: np.ndarray, correlation_lengths: float
) -> float:
    """t-widened root mean square of the residual's coefficients 2 … K+1 in orthonormal
    polynomials."""
    k = min(int(np.clip(correlation_lengths / 4, 4, 16)), x.size - 3)
    u = 2 * (x - x[0]) / (x[-1] - x[0]) - 1
    basis, _ = np.linalg.qr(np.polynomial.legendre.legvander(u, k + 1))
    spectrum = basis[:, 2:].T @ residual
    return float(np.sqrt(np.mean(spectrum**2)) * student.ppf(0.975, k) / 1.96)


def _cubic(x: np.ndarray, residual: np.ndarray) -> tuple[float, float, float]:
    """Smallest and largest slope of the residual's cubic inside the window, and the
    fraction of its variance that it explains."""
    centre, half = (x[0] + x[-1]) / 2, (x[-1] - x[0]) / 2
    u = (x - centre) / half
    cubic = np.polynomial.Polynomial.fit(u, residual, 3, domain=[-1, 1], window=[-1, 1])
    slopes = cubic.deriv()(np.linspace(-1, 1, 21)) / half
    total = float(residual @ residual)
    explained = (
        1 - float(np.sum((residual - cubic(u)) ** 2)) / total if total > 0 else 0.0
    )
    return float(slopes.min()), float(slopes.max()), explained


@dataclass(frozen=True)
class FlankLine:
    """The line through one flank in the picture [px, y down], and its angle against the
    horizontal; toe, top: angle and sd [deg], but for the horizontal's, of its lower and
    upper third, None where they have too few columns."""

    side: str
    line: Line
    angle_deg: float
    angle_sd_deg: float
    toe: tuple[float, float] | None
    top: tuple[float, float] | None
    doubts: tuple[str, ...] = ()


def fit_flank(
    surface: np.ndarray,
    base: BaseLine,
    heap: Heap,
    flank: Flank,
    factor: float,
    window: tuple[float, float],
    horizontal: float,
    horizontal_sd: float,
) -> FlankLine | None:
    """The line through the flank's surface between the window's heights; None where it
    is too short, too flat or too rough."""
    x = np.arange(surface.size)
    height = (base.at(x) - surface) / factor
    crest, toe = (heap.crest + 0.5) * factor - 0.5, (flank.toe + 0.5) * factor - 0.5
    side = (
        (x <= crest) & (x >= toe) if flank.side == "left" else (x >= crest) & (x <= toe)
    )
    side &= np.isfinite(height)
    low, high = (share * heap.height_px for share in window)
    inside = line_window(x, height, side, low, high)
    if inside is None:
        return None
    line = fit_line(x[inside], surface[inside], floor=EDGE_FLOOR_PX)
    sign = 1 if flank.side == "right" else -1
    angle = sign * (line.angle_deg - horizontal)
    rise = abs(line.slope) * (line.x_high - line.x_low)
    if angle < LEAST_DEG or line.rms > ROUGH * rise:
        return None
    told = (
        (
            angle > STEEP_DEG,
            tr(
                "steeper than {:.0f}°: is the picture turned, or is this no slope of"
                " grains?",
                STEEP_DEG,
            ),
        ),
        (
            line.outlier_share > MOST_OUTLIERS,
            tr(
                "{:.0f} % of the surface lies off the line and was left out",
                100 * line.outlier_share,
            ),
        ),
    )
    doubts = tuple(why for holds, why in told if holds)
    upper, _, lower = (
        _angle_of(x[third], surface[third], sign, horizontal)
        for third in np.array_split(np.flatnonzero(inside), 3)[::sign]
    )
    angle_sd_deg = float(np.hypot(line.angle_sd_deg, horizontal_sd))
    return FlankLine(flank.side, line, angle, angle_sd_deg, lower, upper, doubts)


def _angle_of(
    x: np.ndarray, y: np.ndarray, sign: int, horizontal: float
) -> tuple[float, float] | None:
    """Angle and sd [deg] of a part of a flank that falls towards `sign`."""
    if x.size < LEAST_COLUMNS:
        return None
    line = fit_line(x, y, floor=EDGE_FLOOR_PX)
    return sign * (line.angle_deg - horizontal), line.angle_sd_deg
