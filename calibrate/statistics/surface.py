"""Quadratic response surfaces as a publication fits them: least squares in coded units
(the paper's Eq. 8), analysis of variance, residuals, prediction with its error.

Source: Myers, Montgomery & Anderson-Cook, Response Surface Methodology (4th ed.),
chapters 2 and 6; computed by statsmodels."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import stats
from statsmodels.regression.linear_model import OLS

from benchtwin.bench.language import tr
from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.box import Box


@dataclass(frozen=True, kw_only=True, eq=False)
class Surface:
    """A fitted polynomial in the coded factors of a box.

    response_name: with its unit; points: (n, k) coded; terms: p tuples of exponents;
    fit: statsmodels' result of the regression on their columns."""

    response_name: str
    box: Box
    points: np.ndarray
    terms: tuple[polynomial.Term, ...]
    fit: Any

    @property
    def names(self) -> tuple[str, ...]:
        return self.box.names

    def mean(self, coded: ArrayLike) -> np.ndarray:
        """Predicted response (n,) at coded points (n, k)."""
        return polynomial.matrix(coded, self.terms) @ self.fit.params

    def variance(self, coded: ArrayLike) -> np.ndarray:
        """Variance (n,) of the predicted mean at coded points (n, k): s² xᵀ(XᵀX)⁻¹x."""
        x = polynomial.matrix(coded, self.terms)
        return np.sum(x @ self.fit.cov_params() * x, axis=1)


def fit_surface(table: pd.DataFrame, response: str, box: Box) -> Surface:
    """Least-squares quadratic through the runs of a table, one row a run, columns
    `box.names` in natural units and `response`.

    Raises ValueError: responses all equal, fewer runs than terms + 1, a design that
    cannot tell terms apart."""
    points = box.coded(box.points(table))
    y, terms = table[response].to_numpy(float), polynomial.full(len(box.names))
    x = polynomial.matrix(points, terms)
    n, p = x.shape
    if n <= p:
        raise ValueError(
            tr("{}: {} terms need at least {} runs; here are {}", response, p, p + 1, n)
        )
    if np.ptp(y) == 0:
        raise ValueError(
            tr("{}: all {} values equal {:g}; nothing to fit", response, n, y[0])
        )
    if aliased := _aliased(x, terms):
        raise ValueError(
            tr(
                "singular design: its {} runs cannot tell {} from the other terms",
                n,
                ", ".join(aliased),
            )
        )
    fit = OLS(y, x).fit()
    return Surface(response_name=response, box=box, points=points, terms=terms, fit=fit)


def _aliased(x: np.ndarray, terms: tuple[polynomial.Term, ...]) -> list[str]:
    """Names of terms whose column is a combination of the columns before it."""
    ranks = [0, *(np.linalg.matrix_rank(x[:, : j + 1]) for j in range(len(terms)))]
    return [polynomial.name(t) for t, r in zip(terms, np.diff(ranks)) if not r]


def coefficients(surface: Surface, level: float = 0.95) -> pd.DataFrame:
    """Table of coded coefficients: term, coefficient, se, low, high (a `level`
    interval), t, p, natural (of the same surface in natural units)."""
    fit, box = surface.fit, surface.box
    low, high = fit.conf_int(1 - level).T
    there = polynomial.matrix(box.natural(surface.points), surface.terms)
    return pd.DataFrame(
        {
            "term": [polynomial.name(t) for t in surface.terms],
            "coefficient": fit.params,
            "se": fit.bse,
            "low": low,
            "high": high,
            "t": fit.tvalues,
            "p": fit.pvalues,
            "natural": OLS(fit.fittedvalues, there).fit().params,
        }
    )


def anova_table(surface: Surface) -> pd.DataFrame:
    """Columns source, sum_of_squares (unit² of the response), df, mean_square, f, p;
    rows Model, terms (partial, each added last), Residual, Lack of fit, Pure error,
    Total, in Design-Expert's order.

    Model and terms are tested against the residual, lack of fit against pure error;
    where there is none of these, NaN."""
    fit = surface.fit
    pure_ss, pure_df = _pure_error(surface)
    residual, pure = (fit.ssr, fit.df_resid), (pure_ss, pure_df)
    rows: list[tuple[str, float, float, tuple[float, float] | None]]
    rows = [("Model", fit.ess, fit.df_model, residual)]
    rows += [
        (polynomial.name(term), t**2 * fit.mse_resid, 1, residual)
        for term, t in zip(surface.terms, fit.tvalues)
        if any(term)
    ]
    rows += [
        ("Residual", *residual, None),
        ("Lack of fit", fit.ssr - pure_ss, fit.df_resid - pure_df, pure),
        ("Pure error", *pure, None),
        ("Total", fit.centered_tss, fit.nobs - 1, None),
    ]
    return pd.DataFrame([_row(*row) for row in rows])


def _pure_error(surface: Surface) -> tuple[float, int]:
    """Sum of squares and degrees of freedom that one mean for every coded point
    leaves."""
    places = np.round(surface.points, 9) + 0.0
    _, cell = np.unique(places, axis=0, return_inverse=True)
    y = pd.Series(surface.fit.model.endog)
    within = y - y.groupby(cell.ravel()).transform("mean")
    return float(np.sum(within**2)), len(y) - int(cell.max()) - 1


def _row(source: str, ss: float, df: float, error: tuple[float, float] | None) -> dict:
    mean_square = ss / df if df > 0 else np.nan
    f = p = np.nan
    if error and df > 0 and error[1] > 0 and error[0] > 0:
        f = mean_square / (error[0] / error[1])
        p = stats.f.sf(f, df, error[1])
    told = {"source": source, "sum_of_squares": ss, "df": int(df)}
    return told | {"mean_square": mean_square, "f": f, "p": p}


def contributions(anova: pd.DataFrame, factors: int) -> pd.DataFrame:
    """Contributions K of the factors, by Eqs. (9)–(10) and as the soybean paper
    computed them.

    δ = 0 where F ≤ 1, else 1 − 1/F; by_formula: K_i = δ_i + ½ Σ_j δ_ij + δ_ii;
    as_paper: δ_i + Σ_j δ_ij, which is what its printed 0.976, 1.854 and 1.852 are.
    Columns factor (A, B …), by_formula, as_paper; anova: a table of `anova_table`. A
    term that is not in the table has δ = 0."""
    f = anova.set_index("source")["f"]
    delta = (1 - 1 / f.where(f > 1, 1.0)).to_dict()
    letters = polynomial.LETTERS[:factors]
    rows = []
    for a in letters:
        pairs = sum(delta.get("".join(sorted(a + b)), 0.0) for b in letters if b != a)
        own, square = delta.get(a, 0.0), delta.get(f"{a}²", 0.0)
        rows.append((a, own + pairs / 2 + square, own + pairs))
    return pd.DataFrame(rows, columns=["factor", "by_formula", "as_paper"])


def quality(surface: Surface) -> pd.DataFrame:
    """Columns measure, value: R², adjusted R², predicted R² (1 − PRESS/SS_total),
    PRESS (Σ (residual/(1 − leverage))²), adequate precision (range of predictions over
    their mean standard error, above 4 wanted), sd (√s²), C.V. (sd over the mean, %),
    Shapiro and Wilk's p of the studentised residuals (below 0.05: no normal scatter).
    """
    fit, (n, p) = surface.fit, surface.fit.model.exog.shape
    influence, sd = fit.get_influence(), np.sqrt(fit.mse_resid)
    press = float(np.sum(influence.resid_press**2))
    internal = influence.resid_studentized_internal
    internal = internal[np.isfinite(internal)]
    rows = {
        "R²": fit.rsquared,
        "adjusted R²": fit.rsquared_adj,
        "predicted R²": 1 - press / fit.centered_tss,
        "PRESS": press,
        "adequate precision": np.ptp(fit.fittedvalues) / (sd * np.sqrt(p / n)),
        "sd": sd,
        "C.V. (%)": 100 * sd / abs(fit.model.endog.mean()),
        "p of a normal scatter": stats.shapiro(internal).pvalue
        if internal.size >= 3
        else np.nan,
    }
    return pd.DataFrame(rows.items(), columns=["measure", "value"])


def residual_table(surface: Surface, alpha: float = 0.05) -> pd.DataFrame:
    """One row a run: run, actual, predicted, residual, leverage, student_internal,
    student_external (with s from the other runs), cook, outlier (beyond t at alpha/n,
    Bonferroni)."""
    influence, fit = surface.fit.get_influence(), surface.fit
    external, n = influence.resid_studentized_external, int(fit.nobs)
    limit = stats.t.ppf(1 - alpha / (2 * n), max(fit.df_resid - 1, 1))
    return pd.DataFrame(
        {
            "run": np.arange(1, n + 1),
            "actual": fit.model.endog,
            "predicted": fit.fittedvalues,
            "residual": fit.resid,
            "leverage": influence.hat_matrix_diag,
            "student_internal": influence.resid_studentized_internal,
            "student_external": external,
            "cook": influence.cooks_distance[0],
            "outlier": abs(external) > limit,
        }
    )


def response_grid(
    surface: Surface,
    across: str,
    along: str,
    *,
    steps: int = 41,
    at: dict[str, float] | None = None,
) -> pd.DataFrame:
    """The surface over two factors, for drawing: columns `across`, `along`, predicted;
    steps² rows. at: natural values of the other factors; default the box's centre."""
    box = surface.box
    place = dict(zip(box.names, box.centre)) | (at or {})
    axes = [np.linspace(*box.range(name), steps) for name in (across, along)]
    grid = np.meshgrid(*axes, indexing="ij")
    natural = pd.DataFrame(place, index=range(steps**2))
    natural[across], natural[along] = grid[0].ravel(), grid[1].ravel()
    predicted = surface.mean(box.coded(box.points(natural)))
    return natural[[across, along]].assign(predicted=predicted)
