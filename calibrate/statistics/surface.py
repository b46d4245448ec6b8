"""Quadratic response surfaces: least squares in coded units (the paper's Eq. 8), how good they are, prediction with its error.

ŷ = Xβ̂, β̂ = (XᵀX)⁻¹Xᵀy, cov β̂ = s² (XᵀX)⁻¹, s² = residual sum of squares / (n − p).
Source: Myers, Montgomery & Anderson-Cook, Response Surface Methodology (4th ed.), chapters 2 and 6.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd
from scipy import stats

from calibrate.statistics import terms as polynomial
from calibrate.statistics.box import Box
from calibrate.statistics.columns import numbers

LACK_P = 0.10  # lack of fit this unlikely by chance is believed, and added to the surface's own error


@dataclass(frozen=True, eq=False)
class Surface:
    """A fitted polynomial in the coded factors of a box.

    response_name: with its unit; terms: p tuples of exponents; coefficients: (p,) coded; inverse: (p, p) (XᵀX)⁻¹;
    points: (n, k) coded; response: (n,); residual_ss on residual_df; of it pure_ss on pure_df from repeated points.
    """

    response_name: str
    box: Box
    terms: tuple[polynomial.Term, ...]
    coefficients: np.ndarray
    inverse: np.ndarray
    points: np.ndarray
    response: np.ndarray
    residual_ss: float
    residual_df: int
    pure_ss: float
    pure_df: int

    @property
    def names(self) -> tuple[str, ...]:
        return self.box.names

    @property
    def term_names(self) -> list[str]:
        return [polynomial.name(t) for t in self.terms]

    @property
    def residual_ms(self) -> float:
        return self.residual_ss / self.residual_df

    @property
    def df(self) -> int:
        """Degrees of freedom of the error variance."""
        return self.residual_df

    @property
    def covariance(self) -> np.ndarray:
        """(p, p) covariance of the coded coefficients."""
        return self.residual_ms * self.inverse

    @property
    def noise_sd(self) -> float:
        """Scatter of one run about the surface: from repeated points where there are three degrees of freedom, else the
        residual.
        """
        return float(np.sqrt(self.pure_ss / self.pure_df if self.pure_df >= 3 else self.residual_ms))

    @cached_property
    def lack_sd(self) -> float:
        """How far the surface is off beyond noise, √(MS_lack − MS_pure), where lack of fit is believed (p < LACK_P); else 0."""
        df = self.residual_df - self.pure_df
        if df < 1 or self.pure_df < 1 or self.pure_ss <= 0:
            return 0.0
        lack, pure = (self.residual_ss - self.pure_ss) / df, self.pure_ss / self.pure_df
        return float(np.sqrt(lack - pure)) if stats.f.sf(lack / pure, df, self.pure_df) < LACK_P else 0.0

    def mean(self, coded) -> np.ndarray:
        """Predicted response (n,) at coded points (n, k)."""
        return polynomial.matrix(coded, self.terms) @ self.coefficients

    def variance(self, coded) -> np.ndarray:
        """Variance (n,) of the predicted mean at coded points (n, k): s² xᵀ(XᵀX)⁻¹x + lack of fit."""
        return self._variance(polynomial.matrix(coded, self.terms))

    def _variance(self, x: np.ndarray) -> np.ndarray:
        return self.residual_ms * np.sum(x @ self.inverse * x, axis=1) + self.lack_sd**2

    def gradient(self, coded) -> np.ndarray:
        """∂ŷ/∂z (n, k) at coded points (n, k), response unit per coded unit."""
        return polynomial.gradient(coded, self.terms, self.coefficients)

    def evaluate(self, natural) -> tuple[np.ndarray, np.ndarray]:
        """Mean (n,) and its variance (n,) at natural points (n, k): what the posterior asks a surrogate for."""
        x = polynomial.matrix(self.box.coded(natural), self.terms)
        return x @ self.coefficients, self._variance(x)


def fit_surface(
    table: pd.DataFrame, response: str, box: Box, *, terms="quadratic", coded_columns: tuple[str, ...] | None = None
) -> Surface:
    """Least-squares surface through the runs of a table, one row a run, replicates as rows of their own.

    table: columns `box.names` in natural units, or `coded_columns` (in the box's order) in coded ones, and `response`.
    terms: "linear", "interactions", "quadratic", or tuples of exponents.
    Raises ValueError: a column missing, responses all equal, fewer runs than terms + 1, a design that cannot tell terms apart.
    """
    points = numbers(table, coded_columns) if coded_columns else box.coded(box.points(table))
    y = numbers(table, [response])[:, 0]
    chosen = polynomial.full(len(box.names), terms) if isinstance(terms, str) else tuple(terms)
    return _solve(response, box, chosen, points, y)


def _solve(response: str, box: Box, terms: tuple[polynomial.Term, ...], points: np.ndarray, y: np.ndarray) -> Surface:
    x = polynomial.matrix(points, terms)
    n, p = x.shape
    if n <= p:
        raise ValueError(f"{response}: {p} terms need at least {p + 1} runs; here are {n}")
    if np.ptp(y) == 0:
        raise ValueError(f"{response}: all {n} values equal {y[0]:g}; nothing to fit")
    aliased = _aliased(x, terms)
    if aliased:
        raise ValueError(f"singular design: its {n} runs cannot tell {', '.join(aliased)} from the other terms")
    q, r = np.linalg.qr(x)
    coefficients = np.linalg.solve(r, q.T @ y)
    r_inverse = np.linalg.inv(r)
    pure_ss, pure_df = pure_error(points, y)
    residual_ss = float(np.sum((y - x @ coefficients) ** 2))
    return Surface(
        response_name=response, box=box, terms=terms, coefficients=coefficients, inverse=r_inverse @ r_inverse.T,
        points=points, response=y, residual_ss=residual_ss, residual_df=n - p, pure_ss=min(pure_ss, residual_ss), pure_df=pure_df,
    )  # fmt: skip


def _aliased(x: np.ndarray, terms: tuple[polynomial.Term, ...]) -> list[str]:
    """Names of terms whose column is a combination of the columns before it."""
    found, rank = [], 0
    for j, term in enumerate(terms):
        now = np.linalg.matrix_rank(x[:, : j + 1])
        if now == rank:
            found.append(polynomial.name(term))
        rank = now
    return found


def pure_error(points: np.ndarray, y: np.ndarray) -> tuple[float, int]:
    """Sum of squares and degrees of freedom within groups of runs at the same coded point."""
    groups = pd.DataFrame(np.round(points, 9) + 0.0).groupby(list(range(points.shape[1])), sort=False).ngroup()
    within = pd.Series(y).groupby(groups.to_numpy()).transform(lambda v: v - v.mean())
    return float(np.sum(within**2)), int(len(y) - groups.nunique())


@dataclass(frozen=True)
class Quality:
    """How well a surface describes its runs and predicts others.

    press: Σ (residual/(1 − leverage))²; r2_predicted: 1 − press/SS_total; adequate_precision: range of predictions over their
    mean standard error, (max ŷ − min ŷ)/√(p s²/n), above 4 wanted; sd: √s²; cv_percent: sd over the mean response.
    """

    r2: float
    r2_adjusted: float
    r2_predicted: float
    press: float
    adequate_precision: float
    mean: float
    sd: float
    cv_percent: float


def quality(surface: Surface) -> Quality:
    """R², adjusted and predicted R², PRESS, adequate precision; definitions in `Quality`."""
    y, predicted = surface.response, surface.mean(surface.points)
    n, p = len(y), len(surface.terms)
    total = float(np.sum((y - y.mean()) ** 2))
    free = 1 - leverage(surface)
    press = float(np.sum(((y - predicted) / free) ** 2)) if (free > 1e-9).all() else np.nan
    sd, mean = float(np.sqrt(surface.residual_ms)), float(y.mean())
    return Quality(
        r2=1 - surface.residual_ss / total, r2_adjusted=1 - surface.residual_ms / (total / (n - 1)),
        r2_predicted=1 - press / total, press=press,
        adequate_precision=float(np.ptp(predicted) / (sd * np.sqrt(p / n))) if sd else np.inf,
        mean=mean, sd=sd, cv_percent=100 * sd / abs(mean) if mean else np.nan,
    )  # fmt: skip


def leverage(surface: Surface) -> np.ndarray:
    """(n,) diagonal of X(XᵀX)⁻¹Xᵀ: how much each run decides its own prediction."""
    x = polynomial.matrix(surface.points, surface.terms)
    return np.einsum("ij,jk,ik->i", x, surface.inverse, x)


def coefficients(surface: Surface, level: float = 0.95) -> pd.DataFrame:
    """Table of coded coefficients: term, coefficient, se, low, high (a `level` interval), t, p; units of the response."""
    se = np.sqrt(np.diag(surface.covariance))
    reach = stats.t.ppf((1 + level) / 2, surface.residual_df) * se
    t = surface.coefficients / se
    p = 2 * stats.t.sf(abs(t), surface.residual_df)
    table = pd.DataFrame({"term": surface.term_names, "coefficient": surface.coefficients, "se": se})
    return table.assign(low=surface.coefficients - reach, high=surface.coefficients + reach, t=t, p=p)


def natural_coefficients(surface: Surface) -> pd.Series:
    """Coefficients of the same surface in natural units, indexed by term; lower-order terms appear where a reduced model needs
    them.
    """
    found = polynomial.natural_coefficients(surface.box, surface.terms, surface.coefficients)
    ordered = sorted(found, key=lambda t: (sum(t), max(t, default=0), [-e for e in t]))
    return pd.Series({polynomial.name(t): found[t] for t in ordered})


def predict(surface: Surface, table: pd.DataFrame, level: float = 0.95) -> pd.DataFrame:
    """Prediction at natural points: predicted, se (of the mean), low, high (of the mean), run_low, run_high (of one further
    run).
    """
    coded = surface.box.coded(surface.box.points(table))
    mean, variance = surface.mean(coded), surface.variance(coded)
    t = stats.t.ppf((1 + level) / 2, surface.residual_df)
    mean_reach, run_reach = t * np.sqrt(variance), t * np.sqrt(variance + surface.residual_ms)
    return table[list(surface.names)].assign(
        predicted=mean, se=np.sqrt(variance), low=mean - mean_reach, high=mean + mean_reach,
        run_low=mean - run_reach, run_high=mean + run_reach,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Reduction:
    """A surface with its significant terms only, and the terms left out in order: steps has term, p."""

    surface: Surface
    steps: pd.DataFrame


def reduce(surface: Surface, alpha: float = 0.05) -> Reduction:
    """Backward elimination to terms with p < alpha, keeping a term as long as a higher-order relative of it stays (hierarchy)."""
    steps = []
    while len(surface.terms) > 1:
        p = coefficients(surface)["p"].to_numpy()
        free = [i for i, t in enumerate(surface.terms) if any(t) and not any(polynomial.inside(t, o) for o in surface.terms)]
        worst = max(free, key=lambda i: p[i])
        if p[worst] < alpha:
            break
        steps.append({"term": polynomial.name(surface.terms[worst]), "p": float(p[worst])})
        kept = surface.terms[:worst] + surface.terms[worst + 1 :]
        surface = _solve(surface.response_name, surface.box, kept, surface.points, surface.response)
    return Reduction(surface, pd.DataFrame(steps, columns=["term", "p"]))
