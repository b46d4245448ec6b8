"""Seed on steel: simulated rows → curve → the parameter at the bench's mean, with its
uncertainty, verified by repeats."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from benchtwin.calibrate.procedure.rigs import Rig, direct
from benchtwin.calibrate.statistics.bench import BenchMean, Verification
from benchtwin.calibrate.statistics.curves import (
    Monotone,
    Polynomial,
    fit_monotone,
    fit_polynomial,
)
from benchtwin.calibrate.statistics.inversion import Inverse, OutsideRange, invert

# of the simulated range: how far its end the polynomial is followed when nothing else
# answers
BEYOND = 0.05


@dataclass(frozen=True, eq=False)
class SteelFit:
    """One seed–steel parameter.

    rows: what was simulated, a row a value; polynomial: as the paper fits it; monotone:
    free of a formula, None with fewer than 4 values; inverse: the answer; by: which
    curve gave it; answers: table curve, value, low, high, note of every curve, refusals
    included; direct: by Eqs. 1–3 without simulation; verification: repeats at the
    answer beside the bench; notes."""

    rig: Rig
    bench: BenchMean
    rows: pd.DataFrame
    polynomial: Polynomial
    monotone: Monotone | None
    inverse: Inverse
    by: str
    answers: pd.DataFrame
    direct: float | None
    verification: Verification | None
    notes: tuple[str, ...]

    @property
    def surrogate(self) -> Polynomial | Monotone:
        """The curve that stands for the rig in the posterior: the one that answers
        within its rows."""
        return (
            self.monotone
            if self.by != "polynomial" and self.monotone is not None
            else self.polynomial
        )


def fit_steel(
    rig: Rig,
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
    sd = rig.sd if rig.sd in rows else None
    repeats = "repeats" if "repeats" in rows else None
    weights = (sd, repeats) if weighted else (None, None)
    polynomial = fit_polynomial(
        rows, rig.parameter, rig.response, rig.degree, sd=weights[0], repeats=weights[1]
    )
    several = rows[rig.parameter].nunique() >= 4
    monotone = (
        fit_monotone(rows, rig.parameter, rig.response, rng=rng, sd=sd, repeats=repeats)
        if several
        else None
    )
    answers, refused, notes = _answers(polynomial, monotone, bench)
    by, inverse = _choose(answers, polynomial, refused)
    if by != "polynomial":
        notes.append(
            f"the answer comes from the {by}, because the polynomial refuses:"
            f" {refused['polynomial']}"
        )
    notes += inverse.notes
    table = pd.DataFrame(
        [(n, a.value, a.low, a.high, "; ".join(a.notes)) for n, a in answers.items()]
        + [(n, np.nan, np.nan, np.nan, str(e)) for n, e in refused.items()],
        columns=["curve", "value", "low", "high", "note"],
    )
    plain = direct(rig.name, bench.value, description or {})
    return SteelFit(
        rig,
        bench,
        rows,
        polynomial,
        monotone,
        inverse,
        by,
        table,
        plain,
        None,
        tuple(notes),
    )


def _answers(polynomial: Polynomial, monotone: Monotone | None, bench: BenchMean):
    """Inverses by curve, refusals by curve, and a note where both answer and
    disagree."""
    answers: dict[str, Inverse] = {}
    refused: dict[str, OutsideRange] = {}
    for name, curve in (("polynomial", polynomial), ("monotone curve", monotone)):
        if curve is None:
            continue
        try:
            answers[name] = invert(curve, bench)
        except OutsideRange as error:
            refused[name] = error
    notes = []
    if len(answers) == 2:
        a, b = answers["polynomial"], answers["monotone curve"]
        if not a.low <= b.value <= a.high:
            notes.append(
                f"the curves disagree: polynomial {a.value:.4g}, monotone"
                f" {b.value:.4g}; the degree may not suit the rows"
            )
    return answers, refused, notes


def _choose(
    answers: dict[str, Inverse],
    polynomial: Polynomial,
    refused: dict[str, OutsideRange],
) -> tuple[str, Inverse]:
    for name in ("polynomial", "monotone curve"):
        if name in answers:
            return name, answers[name]
    raise refused["polynomial"]


def fit_beyond(rig: Rig, rows: pd.DataFrame, bench: BenchMean) -> Inverse:
    """The unweighted polynomial followed a little beyond its rows; raises OutsideRange
    when that does not reach either."""
    return invert(
        fit_polynomial(rows, rig.parameter, rig.response, rig.degree),
        bench,
        beyond=BEYOND,
    )


def verified(fit: SteelFit, verification: Verification) -> SteelFit:
    """The fit with its verification, and a note where it disagrees with the bench."""
    notes = fit.notes
    if not verification.agrees:
        notes += (
            (
                f"verification disagrees: {verification.simulated:.4g} simulated,"
                f" {verification.bench:.4g} at the bench (p = {verification.p:.2g})"
            ),
        )
    return replace(fit, verification=verification, notes=notes)
