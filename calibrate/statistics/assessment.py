"""Assessment of a fitted surface: coefficients, R² and related figures, predictions
with intervals.

Source: Myers, Montgomery & Anderson-Cook, Response Surface Methodology (4th ed.),
chapter 2."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy import stats

from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.surface import (
    Surface,
    leverage,
    residuals,
    total_ss,
)


def coefficients(surface: Surface, level: float = 0.95) -> pd.DataFrame:
    """Table of coded coefficients: term, coefficient, se, low, high (a `level`
    interval), t, p; units of the response."""
    se = np.sqrt(np.diag(surface.covariance))
    reach = stats.t.ppf((1 + level) / 2, surface.residual_df) * se
    t = surface.coefficients / se
    p = 2 * stats.t.sf(abs(t), surface.residual_df)
    table = pd.DataFrame(
        {"term": surface.term_names, "coefficient": surface.coefficients, "se": se}
    )
    return table.assign(
        low=surface.coefficients - reach, high=surface.coefficients + reach, t=t, p=p
    )


def natural_coefficients(surface: Surface) -> pd.Series:
    """Coefficients of the same surface in natural units, indexed by term; lower-order
    terms appear where a reduced model needs them."""
    box, terms, coded = surface.box, surface.terms, surface.coefficients
    found = polynomial.natural_coefficients(box, terms, coded)
    ordered = sorted(found, key=lambda t: (sum(t), max(t, default=0), [-e for e in t]))
    return pd.Series({polynomial.name(t): found[t] for t in ordered})


def response_grid(
    surface: Surface,
    across: str,
    along: str,
    *,
    steps: int = 41,
    at: dict[str, float] | None = None,
) -> pd.DataFrame:
    """The surface over two factors, for drawing: columns `across`, `along`, predicted,
    se; steps² rows.

    at: natural values of the other factors; default the box's centre. Raises ValueError
    for a factor that the box has not."""
    box = surface.box
    unknown = [n for n in (across, along, *(at or {})) if n not in box.names]
    if unknown or across == along:
        raise ValueError(
            f"a grid needs two different factors of {', '.join(box.names)}, not"
            f" {across}, {along}, {at or {}}"
        )
    place = dict(zip(box.names, box.centre)) | (at or {})
    i, j = box.names.index(across), box.names.index(along)
    axes = [np.linspace(box.low[f], box.high[f], steps) for f in (i, j)]
    grid = np.meshgrid(*axes, indexing="ij")
    natural = np.tile([place[n] for n in box.names], (steps**2, 1))
    natural[:, i], natural[:, j] = grid[0].ravel(), grid[1].ravel()
    mean, variance = surface.evaluate(natural)
    table = {across: natural[:, i], along: natural[:, j]}
    return pd.DataFrame(table | {"predicted": mean, "se": np.sqrt(variance)})


@dataclass(frozen=True)
class Quality:
    """How well a surface describes its runs and predicts others.

    press: Σ (residual/(1 − leverage))²; r2_predicted: 1 − press/SS_total;
    adequate_precision: range of predictions over their mean standard error, (max ŷ −
    min ŷ)/√(p s²/n), above 4 wanted; sd: √s²; cv_percent: sd over the mean response.
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
    """R², adjusted and predicted R², PRESS, adequate precision; definitions in
    `Quality`."""
    y, predicted = surface.response, surface.mean(surface.points)
    n, p = len(y), len(surface.terms)
    total, free = total_ss(surface), 1 - leverage(surface)
    decided = not (free > 1e-9).all()  # a run alone decides its own prediction
    press = np.nan if decided else float(np.sum((residuals(surface) / free) ** 2))
    sd, mean = float(np.sqrt(surface.residual_ms)), float(y.mean())
    reach = float(np.ptp(predicted))
    return Quality(
        r2=1 - surface.residual_ss / total,
        r2_adjusted=1 - surface.residual_ms / (total / (n - 1)),
        r2_predicted=1 - press / total,
        press=press,
        adequate_precision=float(reach / (sd * np.sqrt(p / n))) if sd else np.inf,
        mean=mean,
        sd=sd,
        cv_percent=100 * sd / abs(mean) if mean else np.nan,
    )
