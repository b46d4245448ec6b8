"""What stands for the piles in the posterior: surfaces over seed–seed and seed–steel
parameters, one for each thing seen.

The seed–steel parameters vary along: every pile of the design has them low or high, in
a pattern that keeps them apart from the seed–seed ones, so that what they do to a pile
is known without a pile more, and their uncertainty goes into the posterior."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from benchtwin.calibrate.procedure.bench import RigReadings
from benchtwin.calibrate.procedure.rigs import PILE_RESPONSE
from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.anova import anova_table
from benchtwin.calibrate.statistics.assessment import coefficients
from benchtwin.calibrate.statistics.bench import pooled_mean
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.posterior import Observable
from benchtwin.calibrate.statistics.resolution import Candidate
from benchtwin.calibrate.statistics.shrinkage import shrink
from benchtwin.calibrate.statistics.surface import Surface, fit_surface

STEEL_HALF_RANGE = (
    0.25  # of a seed–steel parameter: how far to either side it varies at least
)
SPARE_DF = (
    4  # residual degrees of freedom below which the seed–steel terms are left out
)
PATTERNS = 2000
MOST_CORRELATION = 0.99
SIGNIFICANT_P = 0.05
NOT_OBSERVABLES = {
    "true_repose_angle_deg",
    "true_centroid_angle_deg",
    "true_photo_s",
    "true_lies_still",
    "seconds",
    "repose_angle_sd_deg",
    "centroid_angle_sd_deg",
    "packing",
    "replicate",
}


@dataclass(frozen=True, eq=False)
class PileObservables:
    """observables of the bench's piles with their surfaces, the angle first;
    correlation between their errors, by name; used: columns they come from; notes;
    angle: the least-squares surface of the angle, None where it was not seen."""

    observables: tuple[Observable, ...]
    correlation: pd.DataFrame
    used: tuple[str, ...]
    notes: tuple[str, ...]
    angle: Surface | None = None


def steel_box(
    found: dict[str, tuple[float, float]], limits: dict[str, tuple[float, float]]
) -> Box | None:
    """Ranges over which seed–steel parameters vary along; found: {parameter: (value,
    sd)}. None without any."""
    ranges = {}
    for name, (value, sd) in found.items():
        half = max(STEEL_HALF_RANGE * value, 4 * sd)
        low, high = (
            max(limits[name][0], value - half),
            min(limits[name][1], value + half),
        )
        ranges[name] = (float(f"{low:.3g}"), float(f"{high:.3g}"))
    return Box.of(ranges) if ranges else None


def two_level_pattern(coded: np.ndarray, factors: int) -> np.ndarray:
    """−1 or +1 (n, factors) for runs at coded (n, k): of many drawn patterns the one
    that tells most (D-optimal with a quadratic in the k). Runs at the centre keep 0, as
    they tell the noise. The same design gets the same pattern."""
    rng, moving = np.random.default_rng(0), (coded != 0).any(axis=1)
    base = polynomial.matrix(coded, polynomial.full(coded.shape[1]))
    best, most = np.zeros((len(coded), factors)), -np.inf
    half = np.resize([-1.0, 1.0], int(moving.sum()))
    for _ in range(PATTERNS):
        trial = np.zeros_like(best)
        trial[moving] = np.column_stack([rng.permutation(half) for _ in range(factors)])
        x = np.column_stack([base, trial])
        information = np.linalg.slogdet(x.T @ x)[1]
        if information > most:
            best, most = trial, information
    return best


def observed(
    piles: pd.DataFrame,
    readings: RigReadings,
    box: Box,
    steel: Box | None,
    *,
    alike: bool,
    shared: bool = False,
) -> PileObservables:
    """Surfaces through all piles in the box, a row a run, for the angle and whatever
    else the bench says of its piles.

    alike: whether the bench's piles are the simulated ones' like, so that their scatter
    may be pooled; shared: whether piles of one packing scatter together; where a few
    pairs do not show it, a fitted share would be chance."""
    names = box.names if steel is None else (*box.names, *steel.names)
    wide = (
        box
        if steel is None
        else Box(names, np.r_[box.low, steel.low], np.r_[box.high, steel.high])
    )
    inside = (abs(box.coded(box.points(piles))) <= 1 + 1e-9).all(axis=1)
    piles, notes, found, errors, used, angle = (
        piles[inside].reset_index(drop=True),
        [],
        [],
        {},
        [],
        None,
    )
    weighed = [column for column in readings.further if column.endswith("_mass_g")]
    if weighed and not alike:
        notes.append(
            f"not used in the posterior: {' and '.join(weighed)}, weighed of the pile"
            " as described, not of the slice"
        )
    for column, values in {PILE_RESPONSE: readings.values, **readings.further}.items():
        if column in weighed and not alike:
            continue
        source = (
            column
            if column in piles and piles[column].notna().any()
            else f"true_{column}"
        )
        if source not in piles or piles[source].nunique() < 8:
            continue
        there = piles[piles[source].notna()].reset_index(drop=True)
        least_squares, note = _surface(
            there, source, wide, len(box.names), "packing" if shared else None
        )
        surface = shrink(least_squares)
        angle = least_squares if column == PILE_RESPONSE else angle
        reading_sd, shared_sd = (
            (readings.reading_sd, readings.shared_sd)
            if column == PILE_RESPONSE
            else (np.zeros(1), 0.0)
        )
        try:
            mean = pooled_mean(
                values,
                name=column,
                scatter_sd=surface.noise_sd,
                df=surface.noise_df,
                pooled=alike,
                reading_sd=reading_sd,
                shared_sd=shared_sd,
            )
        except ValueError as error:
            notes.append(f"not used in the posterior: {error}")
            continue
        notes += note
        found.append(Observable(f"pile: {column}", surface, mean))
        errors[f"pile: {column}"] = pd.Series(surface.residuals)
        used.append(source)
    return PileObservables(
        tuple(found),
        _correlation(errors),
        tuple(used),
        tuple(dict.fromkeys(notes)),
        angle,
    )


def _correlation(errors: dict[str, pd.Series]) -> pd.DataFrame:
    """Correlation of the surfaces' residuals, a hundredth short of what would make two
    observables one."""
    names = list(errors)
    found, one = pd.DataFrame(errors).corr().fillna(0.0).to_numpy(), np.eye(len(names))
    return pd.DataFrame(
        np.where(one, 1.0, MOST_CORRELATION * found), index=names, columns=names
    )


def _surface(
    piles: pd.DataFrame, column: str, wide: Box, quadratic: int, packing: str | None
) -> tuple[Surface, list[str]]:
    """Quadratic in the first factors, linear in the others as far as there are runs
    enough."""
    k = len(wide.names)
    terms = [(*t, *(0,) * (k - quadratic)) for t in polynomial.full(quadratic)]
    linear = [tuple(int(i == j) for i in range(k)) for j in range(quadratic, k)]
    notes = []
    if len(piles) - len(terms) - len(linear) >= SPARE_DF:
        terms += linear
    elif linear:
        notes.append(
            "too few piles to tell what the seed–steel parameters do to them: their"
            " uncertainty is not in the posterior"
        )
    return fit_surface(piles, column, wide, terms=tuple(terms), packing=packing), notes


def angles_at(
    design: pd.DataFrame, seen: PileObservables, steel: Box | None, at: dict[str, float]
) -> pd.Series:
    """The design's angles as they would be with the seed–steel parameters `at`, by the
    slopes of the surface over all piles.

    Only by slopes that the piles show (p < SIGNIFICANT_P): bringing by mere noise would
    make the runs look quieter than they are."""
    angle = design[PILE_RESPONSE].copy()
    surface = seen.angle
    if steel is None or surface is None:
        return angle
    coded = (
        steel.points(design) - np.array([at[n] for n in steel.names])
    ) / steel.half_width
    p = coefficients(surface)["p"].to_numpy()
    for j, name in enumerate(steel.names):
        term = tuple(int(n == name) for n in surface.box.names)
        if term in surface.terms and p[surface.terms.index(term)] < SIGNIFICANT_P:
            angle -= (
                float(surface.coefficients[surface.terms.index(term)]) * coded[:, j]
            )
    return angle


def informative(
    design: pd.DataFrame,
    box: Box,
    packing: str | None,
    seen: PileObservables,
    alpha: float = 0.05,
) -> tuple[str, ...]:
    """What, besides the angle, shows beyond packing noise that the parameters do
    something to a pile: by their main effects, for which a quick design has runs to
    spare."""
    out = []
    for column in seen.used:
        if column == PILE_RESPONSE or design[column].isna().any():
            continue
        if (
            anova_table(
                fit_surface(design, column, box, terms="linear", packing=packing)
            )["p"].iloc[0]
            < alpha
        ):
            out.append(column.removeprefix("true_"))
    return tuple(out)


def candidates(
    design: pd.DataFrame,
    box: Box,
    packing: str | None,
    piles: int,
    without: tuple[str, ...] = (),
) -> list[Candidate]:
    """What else the same piles show, as observables to measure: their scatter is the
    simulated piles', over as many piles."""
    out = []
    for column in design.columns:
        if (
            column in NOT_OBSERVABLES
            or column in (PILE_RESPONSE, *without, *box.names)
            or design[column].dtype.kind != "f"
        ):
            continue
        if (
            column.endswith("_coded")
            or "_sd" in column
            or design[column].isna().any()
            or design[column].nunique() < 8
        ):
            continue
        surface = fit_surface(design, column, box, packing=packing)
        out.append(
            Candidate(
                column.removeprefix("true_").replace("_", " "),
                surface,
                surface.noise_sd / np.sqrt(max(piles, 1)),
            )
        )
    return out
