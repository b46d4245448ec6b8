"""Seed on steel: simulated rows → curve → the parameter at the bench's mean, with its
uncertainty, verified by repeats."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from benchtwin.bench.tells import ByCurve
from benchtwin.calibrate.statistics.bench import BenchMean, Verification
from benchtwin.calibrate.statistics.curves import (
    Monotone,
    Polynomial,
    fit_monotone,
    fit_polynomial,
)
from benchtwin.calibrate.statistics.inversion import Inverse, OutsideRange, invert

# of the simulated range: how far past its end the polynomial is followed when nothing
# else answers, where its error is still about that of its last row
BEYOND = 0.05
FEWEST_ROWS = 4  # of a monotone curve: its error comes from rows with two neighbours
ANSWERS = ["curve", "value", "low", "high", "note"]


@dataclass(frozen=True, kw_only=True, eq=False)
class SteelFit:
    """One seed–steel parameter.

    rows: what was simulated, a row a value; polynomial: as the paper fits it; monotone:
    free of a formula, None with fewer than 4 values; inverse: the answer; by: which
    curve gave it; answers: table curve, value, low, high, note of every curve, refusals
    included; direct: by Eqs. 1–3 without simulation; verification: repeats at the
    answer beside the bench; notes."""

    rig: ByCurve
    bench: BenchMean
    rows: pd.DataFrame
    polynomial: Polynomial
    monotone: Monotone | None
    inverse: Inverse
    by: str
    answers: pd.DataFrame
    direct: float | None
    notes: tuple[str, ...]
    verification: Verification | None = None

    @property
    def surrogate(self) -> Polynomial | Monotone:
        """The curve that stands for the rig in the posterior: the one that answers
        within its rows."""
        if self.by == "polynomial" or self.monotone is None:
            return self.polynomial
        return self.monotone


def fit_steel(
    rig: ByCurve,
    rows: pd.DataFrame,
    bench: BenchMean,
    *,
    rng: np.random.Generator,
    description: dict | None = None,
    weighted: bool = True,
) -> SteelFit:
    """Fit both curves and invert them at the bench's mean.

    weighted: rows count by their own scatter; False as the paper does. Raises
    OutsideRange when the bench's mean lies beyond what was simulated on both curves and
    just beyond; ValueError as the curves."""
    x, y = rig.parameter, rig.response
    sd = rig.sd if rig.sd in rows else None
    repeats = "repeats" if "repeats" in rows else None
    weighing = {"sd": sd, "repeats": repeats} if weighted else {}
    polynomial = fit_polynomial(rows, x, y, rig.degree, **weighing)
    monotone = None
    if rows[x].nunique() >= FEWEST_ROWS:
        monotone = fit_monotone(rows, x, y, rng=rng, sd=sd, repeats=repeats)
    curves = {"polynomial": polynomial, "monotone curve": monotone}
    answers, refused = _answers(curves, bench)
    if not answers:
        raise refused["polynomial"]
    by, inverse = next(iter(answers.items()))
    notes = _disagreement(answers)
    if by != "polynomial":
        notes.append(
            f"the answer comes from the {by}, because the polynomial refuses:"
            f" {refused['polynomial']}"
        )
    return SteelFit(
        rig=rig,
        bench=bench,
        rows=rows,
        polynomial=polynomial,
        monotone=monotone,
        inverse=inverse,
        by=by,
        answers=pd.DataFrame(
            [answer_row(n, a) for n, a in (answers | refused).items()], columns=ANSWERS
        ),
        direct=rig.direct(bench.value, description or {}),
        notes=(*notes, *inverse.notes),
    )


def _answers(
    curves: dict[str, Polynomial | Monotone | None], bench: BenchMean
) -> tuple[dict[str, Inverse], dict[str, OutsideRange]]:
    """Inverses by curve, and refusals by curve."""
    answers: dict[str, Inverse] = {}
    refused: dict[str, OutsideRange] = {}
    for name, curve in curves.items():
        if curve is None:
            continue
        try:
            answers[name] = invert(curve, bench)
        except OutsideRange as error:
            refused[name] = error
    return answers, refused


def answer_row(curve: str, found: Inverse | OutsideRange) -> tuple:
    """What a curve answers or why it refuses, in the columns ANSWERS."""
    if isinstance(found, OutsideRange):
        return curve, np.nan, np.nan, np.nan, str(found)
    return curve, found.value, found.low, found.high, "; ".join(found.notes)


def _disagreement(answers: dict[str, Inverse]) -> list[str]:
    """A note where both curves answer and differ by more than the first's interval."""
    if len(answers) < 2:
        return []
    a, b = answers.values()
    if a.low <= b.value <= a.high:
        return []
    return [
        f"the curves disagree: polynomial {a.value:.4g}, monotone {b.value:.4g}; the"
        " degree may not suit the rows"
    ]


def fit_beyond(rig: ByCurve, rows: pd.DataFrame, bench: BenchMean) -> Inverse:
    """The unweighted polynomial followed a little beyond its rows; raises OutsideRange
    when that does not reach either."""
    curve = fit_polynomial(rows, rig.parameter, rig.response, rig.degree)
    return invert(curve, bench, beyond=BEYOND)


def together(fits: Iterable[SteelFit]) -> dict[str, tuple[float, float]]:
    """{parameter: (value, sd)}; of several rigs that tell one parameter the mean, each
    weighed by 1/sd²."""
    found: dict[str, tuple[float, float]] = {}
    for fit in fits:
        new, name = (fit.inverse.value, fit.inverse.sd), fit.rig.parameter
        found[name] = _weighed(found[name], new) if name in found else new
    return found


def _weighed(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    share = b[1] ** 2 / (a[1] ** 2 + b[1] ** 2)
    value = share * a[0] + (1 - share) * b[0]
    return value, a[1] * b[1] / float(np.hypot(a[1], b[1]))
