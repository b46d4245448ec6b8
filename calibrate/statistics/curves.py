"""Curves through simulated rows, y(x) of one parameter: a polynomial of stated degree
(the paper's Eqs. 5–7) and a monotone one.

Both know their mean and its variance at any x within the simulated range;
`inversion.py` asks them nothing else."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import stats
from scipy.interpolate import PchipInterpolator
from scipy.optimize import isotonic_regression

from benchtwin.calibrate.statistics.box import Box

# the pooled variance counts this many degrees of freedom beside a row's own: with five
# repeats, one half
PRIOR_DF = 4


class Curve(ABC):
    """A surrogate of one parameter."""

    x_name: str
    y_name: str
    low: float
    high: float
    df: float

    @abstractmethod
    def mean(self, x: ArrayLike) -> np.ndarray:
        """y (n,) at x."""

    @abstractmethod
    def variance(self, x: ArrayLike) -> np.ndarray:
        """Variance (n,) of `mean`."""

    @abstractmethod
    def simulation_variance(self, x: float, variance: float) -> float:
        """The part of its variance at x that single runs' scatter makes."""

    @property
    def box(self) -> Box:
        return Box((self.x_name,), np.array([self.low]), np.array([self.high]))

    def evaluate(self, natural: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Mean (n,) and its variance (n,) at natural points (n, 1)."""
        x = np.asarray(natural, dtype=float)[:, 0]
        return self.mean(x), self.variance(x)


@dataclass(frozen=True, kw_only=True, eq=False)
class Polynomial(Curve):
    """y = Σ c_i x^(degree − i).

    coefficients: highest power first, in natural units (what the paper prints); scaled,
    covariance: ascending in u = (x − middle)/half range, (degree + 1); inflation:
    factor on the simulation's own variance because the rows scatter about the curve
    more than their sds say, 1 if not; absolute: whether the rows bring sds; r2: of the
    (weighted) fit; df: of the variance."""

    x_name: str
    y_name: str
    low: float
    high: float
    coefficients: np.ndarray
    scaled: np.ndarray
    covariance: np.ndarray
    inflation: float
    absolute: bool
    r2: float
    df: float

    def _u(self, x: ArrayLike) -> np.ndarray:
        x = np.atleast_1d(np.asarray(x, dtype=float))
        return (x - (self.low + self.high) / 2) / ((self.high - self.low) / 2)

    def mean(self, x: ArrayLike) -> np.ndarray:
        return np.polynomial.polynomial.polyval(self._u(x), self.scaled)

    def variance(self, x: ArrayLike) -> np.ndarray:
        """Variance of the mean curve at x."""
        basis = np.vander(self._u(x), len(self.scaled), increasing=True)
        return np.einsum("ij,jk,ik->i", basis, self.covariance, basis)

    def simulation_variance(self, x: float, variance: float) -> float:
        """Without what the rows scatter more than their sds say."""
        return variance / self.inflation if self.absolute else 0.0


def fit_polynomial(
    table: pd.DataFrame,
    x: str,
    y: str,
    degree: int,
    *,
    sd: str | None = None,
    repeats: str | None = None,
) -> Polynomial:
    """Least-squares polynomial y(x), one row a simulated x.

    sd: column with the standard deviation of single runs, repeats: column with the
    number of runs behind each row; rows then weigh repeats/sd² (single sds are drawn
    towards the pooled one). Without, all rows weigh the same and scatter tells the
    error. With sds, a χ²/df above 1 inflates the variance by it (Birge 1932): the
    degree does not describe the rows. Raises ValueError: columns missing, too few
    different x, degree < 1, y all equal, sd or repeats that make no sense."""
    xs, ys = table[[x, y]].to_numpy(float).T
    if degree < 1:
        raise ValueError(f"degree: at least 1, not {degree}")
    if np.unique(xs).size < degree + 1:
        raise ValueError(
            f"{x}: degree {degree} needs at least {degree + 1} different values; here"
            f" are {np.unique(xs).size}"
        )
    _acts(x, y, ys)
    variance, row_df = _row_variance(table, y, sd, repeats)
    spare = xs.size - degree - 1
    if variance is None and spare < 1:
        raise ValueError(
            f"{y}: {xs.size} rows leave nothing to see the error of degree {degree};"
            " give more rows or their sd"
        )
    low, high = float(xs.min()), float(xs.max())
    u = (xs - (low + high) / 2) / ((high - low) / 2)
    w = np.ones_like(ys) if variance is None else 1 / variance
    basis = np.vander(u, degree + 1, increasing=True) * np.sqrt(w)[:, None]
    inverse = np.linalg.inv(basis.T @ basis)
    scaled = inverse @ basis.T @ (ys * np.sqrt(w))
    off = ys - np.polynomial.polynomial.polyval(u, scaled)
    residual = float(np.sum(w * off**2))
    total = float(np.sum(w * (ys - np.sum(w * ys) / w.sum()) ** 2))
    ratio = residual / spare if spare else 1.0
    inflation = ratio if variance is None else max(1.0, ratio)
    unit = [-1, 1]
    in_u = np.polynomial.Polynomial(scaled, domain=[low, high], window=unit)
    in_x = in_u.convert(domain=unit, window=unit).coef
    in_x = np.pad(in_x, (0, degree + 1 - in_x.size))
    return Polynomial(
        x_name=x,
        y_name=y,
        low=low,
        high=high,
        coefficients=in_x[::-1],
        scaled=scaled,
        covariance=inflation * inverse,
        inflation=inflation if variance is not None else 1.0,
        absolute=variance is not None,
        r2=1 - residual / total,
        df=float(spare) if variance is None or inflation > 1 else row_df,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Monotone(Curve):
    """A curve that only rises or only falls, smooth between its rows, free of any
    formula.

    x, y: (n,) rows after isotonic regression; row_sd: (n,) of each row's mean; draws:
    (m, n) rows drawn anew within their error, each made monotone; df: of the rows'
    variance. Between rows: PCHIP (Fritsch & Carlson 1980), which makes no new extremes.
    """

    x_name: str
    y_name: str
    low: float
    high: float
    x: np.ndarray
    y: np.ndarray
    row_sd: np.ndarray
    draws: np.ndarray
    df: float

    def mean(self, x: ArrayLike) -> np.ndarray:
        x = np.atleast_1d(np.asarray(x, dtype=float))
        return PchipInterpolator(self.x, self.y)(x)

    def variance(self, x: ArrayLike) -> np.ndarray:
        """Variance of the curve at x: scatter of the redrawn curves, and (PCHIP −
        straight line)²/3 for the unseen shape between rows."""
        x = np.atleast_1d(np.asarray(x, dtype=float))
        scatter = PchipInterpolator(self.x, self.draws, axis=1)(x).var(axis=0)
        return scatter + (self.mean(x) - np.interp(x, self.x, self.y)) ** 2 / 3

    def simulation_variance(self, x: float, variance: float) -> float:
        """That of the rows on either side."""
        return min(variance, float(np.interp(x, self.x, self.row_sd**2)))


def fit_monotone(
    table: pd.DataFrame,
    x: str,
    y: str,
    *,
    rng: np.random.Generator,
    sd: str | None = None,
    repeats: str | None = None,
    draws: int = 200,
) -> Monotone:
    """Isotonic regression of the rows, joined by PCHIP; its error by drawing the rows
    anew.

    Columns as in `fit_polynomial`; rows with the same x are averaged. Without sd the
    rows' error is estimated from how far each lies from the line through its neighbours
    (Gasser, Sroka & Jennen-Steinmetz 1986), which counts curvature as error: wide
    rather than narrow. Rises or falls as the rows' rank correlation says. Raises
    ValueError: columns missing, fewer than 4 different x, y all equal."""
    xs, ys = table[[x, y]].to_numpy(float).T
    _acts(x, y, ys)
    variance, df = _row_variance(table, y, sd, repeats)
    nodes, index = np.unique(xs, return_inverse=True)
    if nodes.size < 4:
        raise ValueError(
            f"{x}: a monotone curve needs at least 4 different values; here are"
            f" {nodes.size}"
        )
    w = np.ones_like(ys) if variance is None else 1 / variance
    weight = np.bincount(index, w)
    raw = np.bincount(index, w * ys) / weight
    if variance is None:
        row_variance, df = _neighbour_variance(nodes, raw), nodes.size - 2.0
    else:
        row_variance = 1 / weight
    sign = 1.0 if stats.spearmanr(nodes, raw).statistic >= 0 else -1.0
    known = bool(row_variance.all())
    of_row = 1 / row_variance if known else np.ones_like(row_variance)
    level = sign * isotonic(sign * raw, of_row)
    noise = rng.standard_normal((draws, nodes.size)) * np.sqrt(row_variance)
    return Monotone(
        x_name=x,
        y_name=y,
        low=float(nodes[0]),
        high=float(nodes[-1]),
        x=nodes,
        y=level,
        row_sd=np.sqrt(row_variance),
        draws=sign * isotonic(sign * (level + noise), of_row),
        df=df,
    )


def _acts(x: str, y: str, values: np.ndarray) -> None:
    if np.ptp(values) == 0:
        raise ValueError(
            f"{y}: all {values.size} values equal {values[0]:g}; {x} does not act on it"
        )


def isotonic(y: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Weighted non-decreasing least-squares fits of each row of y, (…, n), weights w
    (n,).

    >>> isotonic(np.array([1.0, 3.0, 2.0]), np.ones(3))
    array([1. , 2.5, 2.5])
    """
    return np.apply_along_axis(lambda r: isotonic_regression(r, weights=w).x, -1, y)


def _neighbour_variance(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(n,) common variance of the rows: mean of e²/(1 + a² + b²), e = a y₋ + b y₊ − y,
    a and b by linear interpolation."""
    a = (x[2:] - x[1:-1]) / (x[2:] - x[:-2])
    b = 1 - a
    e = a * y[:-2] + b * y[2:] - y[1:-1]
    return np.full(x.size, np.mean(e**2 / (1 + a**2 + b**2)))


def _row_variance(
    table: pd.DataFrame, y: str, sd: str | None, repeats: str | None
) -> tuple[np.ndarray | None, float]:
    """Variance of each row's mean and its degrees of freedom; None where the rows bring
    no sd, or all are zero (nothing random)."""
    if sd is None:
        return None, np.nan
    s = table[sd].to_numpy(float)
    n = table[repeats].to_numpy(float) if repeats else np.ones_like(s)
    if (s < 0).any():
        raise ValueError(f"column {sd}: row {int(np.argmin(s)) + 1} is negative")
    if (n < 1).any():
        raise ValueError(f"column {repeats}: row {int(np.argmin(n)) + 1} is below 1")
    if not s.any():
        return None, np.nan
    if repeats is None:
        if (s == 0).any():
            raise ValueError(
                f"column {sd}: row {int(np.argmin(s)) + 1} is zero; say how many runs"
                " are behind each row (repeats)"
            )
        return s**2, np.inf
    own_df = n - 1
    if own_df.sum() < 1:
        raise ValueError(f"column {repeats}: one run a row has no sd for {y}")
    pooled = np.sum(own_df * s**2) / own_df.sum()
    moderated = (PRIOR_DF * pooled + own_df * s**2) / (PRIOR_DF + own_df)
    return moderated / n, float(own_df.sum())
