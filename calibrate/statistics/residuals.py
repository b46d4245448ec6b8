"""Residual diagnostics of a surface: leverage, studentised residuals, Cook's distance,
normality.

Source: Cook & Weisberg (1982), Residuals and Influence in Regression; Shapiro & Wilk
(1965), Biometrika 52, 591."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy import stats

from benchtwin.calibrate.statistics.surface import Surface, leverage, residuals


@dataclass(frozen=True)
class Normality:
    """Shapiro–Wilk on the internally studentised residuals: W and p; p < 0.05 speaks
    against a normal scatter."""

    w: float
    p: float


def residual_table(surface: Surface, alpha: float = 0.05) -> pd.DataFrame:
    """One row a run: run, actual, predicted, residual, leverage, student_internal,
    student_external, cook, outlier.

    student_internal: e/(s√(1−h)); student_external: with s from the other runs; cook:
    r²h/(p(1−h)); outlier: |student_external| beyond t at alpha/n (Bonferroni). NaN
    where a run decides its own prediction alone (h = 1)."""
    y, predicted = surface.response, surface.mean(surface.points)
    h, e = leverage(surface), residuals(surface)
    n, p, df = len(y), len(surface.terms), surface.residual_df
    free = np.where(h < 1 - 1e-9, 1 - h, np.nan)
    internal = e / np.sqrt(surface.residual_ms * free)
    # the residual variance without run i, by the deletion formula; with one degree of
    # freedom nothing is left to estimate it
    spare = np.maximum(df - internal**2, 0)
    usable = (spare > 0) & (df > 1)
    ratio = np.divide(df - 1, spare, out=np.full(n, np.nan), where=usable)
    external = internal * np.sqrt(ratio)
    limit = stats.t.ppf(1 - alpha / (2 * n), df - 1) if df > 1 else np.inf
    return pd.DataFrame(
        {
            "run": np.arange(1, n + 1),
            "actual": y,
            "predicted": predicted,
            "residual": e,
            "leverage": h,
            "student_internal": internal,
            "student_external": external,
            "cook": internal**2 * h / (p * free),
            "outlier": abs(external) > limit,
        }
    )


def normality(surface: Surface) -> Normality:
    """Whether the residuals look normal. Raises ValueError with fewer than 3 usable
    residuals."""
    r = residual_table(surface)["student_internal"].dropna()
    if len(r) < 3:
        raise ValueError(
            f"{surface.response_name}: a normality test needs at least 3 residuals;"
            f" here are {len(r)}"
        )
    w, p = stats.shapiro(r)
    return Normality(float(w), float(p))
