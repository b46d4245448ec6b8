"""Analysis of variance of a response surface, in Design-Expert's order, and the
contributions of the factors.

Term sums of squares are partial (each term added last): SS_j = β_j² / [(XᵀX)⁻¹]_jj.
Residual = lack of fit + pure error."""

import numpy as np
import pandas as pd
from scipy import stats

from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.surface import Surface, total_ss


def anova_table(surface: Surface) -> pd.DataFrame:
    """Columns source, sum_of_squares (unit² of the response), df, mean_square, f, p;
    rows Model, terms, Residual, Lack of fit, Pure error, Total.

    Model and terms are tested against the residual, lack of fit against pure error;
    where there is none of these, NaN."""
    total = total_ss(surface)
    rows: list[tuple[str, float, int, str | None]] = [
        ("Model", total - surface.residual_ss, len(surface.terms) - 1, "residual")
    ]
    for j, term in enumerate(surface.terms):
        if any(term):
            ss = surface.coefficients[j] ** 2 / surface.inverse[j, j]
            rows.append((polynomial.name(term), ss, 1, "residual"))
    rows.append(("Residual", surface.residual_ss, surface.residual_df, None))
    lack_df = surface.residual_df - surface.pure_df
    rows.append(("Lack of fit", surface.residual_ss - surface.pure_ss, lack_df, "pure"))
    rows.append(("Pure error", surface.pure_ss, surface.pure_df, None))
    rows.append(("Total", total, len(surface.response) - 1, None))
    against = {
        "residual": (surface.residual_ss, surface.residual_df),
        "pure": (surface.pure_ss, surface.pure_df),
    }
    return pd.DataFrame(
        [_row(name, ss, df, against.get(error or "")) for name, ss, df, error in rows]
    )


def _row(source: str, ss: float, df: int, error: tuple[float, int] | None) -> dict:
    mean_square = ss / df if df > 0 else np.nan
    f = p = np.nan
    if error and df > 0 and error[1] > 0 and error[0] > 0:
        f = mean_square / (error[0] / error[1])
        p = stats.f.sf(f, df, error[1])
    return {
        "source": source,
        "sum_of_squares": ss,
        "df": df,
        "mean_square": mean_square,
        "f": f,
        "p": p,
    }


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
