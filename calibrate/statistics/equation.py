"""A publication's curve through its rows, y(x) = Σ c_i x^(degree − i) by least squares
(the soybean paper's Eqs. 5–7), and where it gives the bench's mean."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from statsmodels.regression.linear_model import OLS

from benchtwin.bench.language import tr


@dataclass(frozen=True, eq=False)
class Equation:
    """coefficients: highest power first, natural units; low, high: ends of its rows."""

    coefficients: np.ndarray
    r2: float
    low: float
    high: float

    def mean(self, x: np.ndarray | float) -> np.ndarray:
        """y at x."""
        return np.polyval(self.coefficients, x)

    def at(self, y: float) -> float:
        """The x that gives y, of several the one nearest to the rows' middle, beyond
        them where it must be; NaN where none does."""
        roots = np.roots([*self.coefficients[:-1], self.coefficients[-1] - y])
        real = roots[np.isreal(roots)].real
        middle = (self.low + self.high) / 2
        return float(min(real, key=lambda x: abs(x - middle), default=np.nan))


def fit_equation(table: pd.DataFrame, x: str, y: str, degree: int) -> Equation:
    """Unweighted, as the paper fits it. ValueError: too few different x, y all
    equal."""
    xs, ys = table[[x, y]].to_numpy(float).T
    if np.unique(xs).size < degree + 2:
        raise ValueError(
            tr(
                "{}: degree {} needs at least {} different values; here are {}",
                x,
                degree,
                degree + 2,
                np.unique(xs).size,
            )
        )
    if np.ptp(ys) == 0:
        raise ValueError(
            tr(
                "{}: all {} values equal {:g}; {} does not act on it",
                y,
                ys.size,
                ys[0],
                x,
            )
        )
    fit = OLS(ys, np.vander(xs, degree + 1)).fit()
    return Equation(fit.params, float(fit.rsquared), float(xs.min()), float(xs.max()))
