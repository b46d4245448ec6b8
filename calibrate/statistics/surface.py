"""Quadratic response surfaces: least squares in coded units (the paper's Eq. 8), how
good they are, prediction with its error.

ŷ = Xβ̂, β̂ = (XᵀX)⁻¹Xᵀy, cov β̂ = s² (XᵀX)⁻¹, s² = residual sum of squares / (n − p).
Source: Myers, Montgomery & Anderson-Cook, Response Surface Methodology (4th ed.),
chapters 2 and 6."""

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import stats

from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.packings import decorrelate

# lack of fit this unlikely by chance is believed, and added to the surface's own error
LACK_P = 0.10
# degrees of freedom of repeated points, from which on their scatter alone is the noise
PURE_DF = 3


@dataclass(frozen=True, kw_only=True, eq=False)
class Runs:
    """What a surface is fitted to.

    response_name: with its unit; points: (n, k) coded; response: (n,). Runs on common
    packings: root (n, n) makes them independent (`packings.py`), shared is λ =
    σ²_packing/σ²_own, packings their number. Else root is None."""

    response_name: str
    box: Box
    points: np.ndarray
    response: np.ndarray
    root: np.ndarray | None = None
    shared: float = 0.0
    packings: int = 0

    def independent(self, values: np.ndarray) -> np.ndarray:
        """Values of the runs (n, …), with what packings share taken out."""
        return values if self.root is None else self.root @ values


@dataclass(frozen=True, kw_only=True, eq=False)
class Surface(Runs):
    """A fitted polynomial in the coded factors of a box.

    terms: p tuples of exponents; coefficients: (p,) coded; inverse: (p, p) (XᵀX)⁻¹;
    residual_ss on residual_df; of it pure_ss on pure_df from repeated points. X and y
    stand for root·X and root·y where packings are shared."""

    terms: tuple[polynomial.Term, ...]
    coefficients: np.ndarray
    inverse: np.ndarray
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
        """Degrees of freedom of a prediction's variance; with common packings, whose
        scatter the mean level carries, theirs."""
        return self.packings - 1 if self.shared else self.residual_df

    @property
    def covariance(self) -> np.ndarray:
        """(p, p) covariance of the coded coefficients."""
        return self.residual_ms * self.inverse

    @property
    def noise_sd(self) -> float:
        """Scatter of one run about the surface: from repeated points where there are
        three degrees of freedom, else the residual."""
        repeated = self.pure_df >= PURE_DF
        own = self.pure_ss / self.pure_df if repeated else self.residual_ms
        return float(np.sqrt(own * (1 + self.shared)))

    @property
    def noise_df(self) -> int:
        """Degrees of freedom of `noise_sd`."""
        return self.pure_df if self.pure_df >= PURE_DF else self.residual_df

    @cached_property
    def lack_sd(self) -> float:
        """Error of the surface beyond noise, √(MS_lack − MS_pure), where lack of fit is
        significant (p < LACK_P); else 0."""
        df = self.residual_df - self.pure_df
        if df < 1 or self.pure_df < 1 or self.pure_ss <= 0:
            return 0.0
        lack, pure = (self.residual_ss - self.pure_ss) / df, self.pure_ss / self.pure_df
        believed = stats.f.sf(lack / pure, df, self.pure_df) < LACK_P
        return float(np.sqrt(lack - pure)) if believed else 0.0

    def mean(self, coded: ArrayLike) -> np.ndarray:
        """Predicted response (n,) at coded points (n, k)."""
        return polynomial.matrix(coded, self.terms) @ self.coefficients

    def variance(self, coded: ArrayLike) -> np.ndarray:
        """Variance (n,) of the predicted mean at coded points (n, k): s² xᵀ(XᵀX)⁻¹x +
        lack of fit."""
        return self._variance(polynomial.matrix(coded, self.terms))

    def _variance(self, x: np.ndarray) -> np.ndarray:
        return self.residual_ms * np.sum(x @ self.inverse * x, axis=1) + self.lack_sd**2

    def gradient(self, coded: ArrayLike) -> np.ndarray:
        """∂ŷ/∂z (n, k) at coded points (n, k), response unit per coded unit."""
        return polynomial.gradient(coded, self.terms, self.coefficients)

    def evaluate(self, natural: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Mean (n,) and its variance (n,) at natural points (n, k): what the posterior
        asks a surrogate for."""
        x = polynomial.matrix(self.box.coded(natural), self.terms)
        return x @ self.coefficients, self._variance(x)


def fit_surface(
    table: pd.DataFrame,
    response: str,
    box: Box,
    *,
    terms: str | Iterable[polynomial.Term] = "quadratic",
    packing: str | None = None,
) -> Surface:
    """Least-squares surface through the runs of a table, one row a run, replicates as
    rows of their own.

    table: columns `box.names` in natural units, and `response`. terms: "linear",
    "interactions", "quadratic", or tuples of exponents. packing: column that names the
    packing of each run, where design points share packings: what runs of a packing have
    in common is then kept out of the effects' error and in the mean level's. Raises
    ValueError: responses all equal, fewer runs than terms + 1, a design that cannot
    tell terms apart."""
    points = box.coded(box.points(table))
    y = table[response].to_numpy(float)
    if isinstance(terms, str):
        terms = polynomial.full(len(box.names), terms)
    chosen = tuple(terms)
    x = polynomial.matrix(points, chosen)
    _check(response, chosen, x, y)
    runs = Runs(response_name=response, box=box, points=points, response=y)
    if packing is not None:
        shared, root = decorrelate(x, y, table[packing].to_numpy())
        many = table[packing].nunique()
        runs = replace(runs, root=root, shared=shared, packings=many)
    return refit(runs, chosen)


def refit(runs: Runs, terms: tuple[polynomial.Term, ...]) -> Surface:
    """The surface with these terms through the runs, or those of another surface; what
    packings share is kept as it was found."""
    x = runs.independent(polynomial.matrix(runs.points, terms))
    y = runs.independent(runs.response)
    q, r = np.linalg.qr(x)
    coefficients = np.linalg.solve(r, q.T @ y)
    r_inverse = np.linalg.inv(r)
    pure_ss, pure_df = pure_error(runs)
    residual_ss = float(np.sum((y - x @ coefficients) ** 2))
    return Surface(
        **{f.name: getattr(runs, f.name) for f in fields(Runs)},
        terms=terms,
        coefficients=coefficients,
        inverse=r_inverse @ r_inverse.T,
        residual_ss=residual_ss,
        residual_df=len(y) - len(terms),
        pure_ss=min(pure_ss, residual_ss),
        pure_df=pure_df,
    )


def _check(
    response: str, terms: tuple[polynomial.Term, ...], x: np.ndarray, y: np.ndarray
) -> None:
    n, p = x.shape
    if n <= p:
        raise ValueError(
            f"{response}: {p} terms need at least {p + 1} runs; here are {n}"
        )
    if np.ptp(y) == 0:
        raise ValueError(f"{response}: all {n} values equal {y[0]:g}; nothing to fit")
    aliased = _aliased(x, terms)
    if aliased:
        raise ValueError(
            f"singular design: its {n} runs cannot tell {', '.join(aliased)} from the"
            " other terms"
        )


def _aliased(x: np.ndarray, terms: tuple[polynomial.Term, ...]) -> list[str]:
    """Names of terms whose column is a combination of the columns before it."""
    found, rank = [], 0
    for j, term in enumerate(terms):
        now = np.linalg.matrix_rank(x[:, : j + 1])
        if now == rank:
            found.append(polynomial.name(term))
        rank = now
    return found


def pure_error(runs: Runs) -> tuple[float, int]:
    """Sum of squares and degrees of freedom that one mean for every coded point
    leaves."""
    places = np.round(runs.points, 9) + 0.0
    _, cell = np.unique(places, axis=0, return_inverse=True)
    member = (cell.ravel()[:, None] == np.arange(cell.max() + 1)).astype(float)
    member, y = runs.independent(member), runs.independent(runs.response)
    means = np.linalg.lstsq(member, y, rcond=None)[0]
    return float(np.sum((y - member @ means) ** 2)), len(y) - member.shape[1]


def residuals(surface: Surface) -> np.ndarray:
    """(n,) response − prediction, with what packings share taken out."""
    return surface.independent(surface.response - surface.mean(surface.points))


def leverage(surface: Surface) -> np.ndarray:
    """(n,) diagonal of X(XᵀX)⁻¹Xᵀ: how much each run decides its own prediction."""
    x = surface.independent(polynomial.matrix(surface.points, surface.terms))
    return np.sum(x @ surface.inverse * x, axis=1)


def total_ss(surface: Surface) -> float:
    """Sum of squares about the mean; with common packings about the mean that weighs
    them."""
    y = surface.independent(surface.response)
    one = surface.independent(np.ones(len(y)))
    return float(np.sum((y - one * (one @ y) / (one @ one)) ** 2))
