"""What stands for the piles in the posterior: surfaces over seed–seed and seed–steel
parameters, one for each thing seen.

The seed–steel parameters vary along: every pile of the design has them low or high, in
a pattern that keeps them apart from the seed–seed ones, so that what they do to a pile
is known without a pile more, and their uncertainty goes into the posterior."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from scipy.linalg import block_diag

from benchtwin.bench.tells import Believed, BySurface
from benchtwin.calibrate.procedure.bench import RigReadings
from benchtwin.calibrate.procedure.rigs import PILE
from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.anova import anova_table
from benchtwin.calibrate.statistics.assessment import coefficients
from benchtwin.calibrate.statistics.bench import pooled_mean
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.next_test import BenchTest
from benchtwin.calibrate.statistics.posterior import Observable
from benchtwin.calibrate.statistics.shrinkage import shrink
from benchtwin.calibrate.statistics.surface import Surface, fit_surface

# of a seed–steel parameter: how far to either side it varies at least, so that what it
# does to a pile shows beside packing noise; and at least so many of its own sds
STEEL_HALF_RANGE, STEEL_SDS = 0.25, 4
# residual degrees of freedom below which the seed–steel terms are left out: on fewer
# the noise is hardly known (t at 95 % is 3.2 on three, 2.8 on four)
SPARE_DF = 4
PATTERNS = 2000  # drawn and compared: a choice of time against a little information
MOST_CORRELATION = 0.99  # so that no two observables count as one and the same
SIGNIFICANT_P = 0.05  # the paper's level
LEAST_DIFFERENT = 8  # values of a column, below which it is a count or a constant
NOT_OBSERVABLES = {
    *("seconds", "packing", "replicate", *PILE.not_seen),
    *(f"true_{column}" for column in PILE.rig.readings),
    *(f"{quantity}_sd_{unit}" for quantity, unit in PILE.rig.readings.values()),
}


@dataclass(frozen=True, kw_only=True, eq=False)
class PileObservables:
    """observables of the bench's piles with their surfaces, the angle first;
    correlation between their errors, by name; used: columns they come from; notes;
    angle: the least-squares surface of the angle, None where it was not seen; runs: all
    that was simulated, where no `PileFit` keeps it; believed: what the surfaces depend
    on beside the contact parameters, and nobody stated."""

    observables: tuple[Observable, ...]
    correlation: pd.DataFrame
    used: tuple[str, ...]
    notes: tuple[str, ...]
    angle: Surface | None = None
    runs: pd.DataFrame | None = None
    believed: Mapping[str, Believed] = field(default_factory=dict)


def steel_box(
    found: dict[str, tuple[float, float]], limits: dict[str, tuple[float, float]]
) -> Box | None:
    """Ranges over which seed–steel parameters vary along; found: {parameter: (value,
    sd)}. None without any."""
    ranges = {}
    for name, (value, sd) in found.items():
        half = max(STEEL_HALF_RANGE * value, STEEL_SDS * sd)
        low, high = limits[name]
        ends = max(low, value - half), min(high, value + half)
        ranges[name] = (float(f"{ends[0]:.3g}"), float(f"{ends[1]:.3g}"))
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
    rig: BySurface = PILE,
) -> PileObservables:
    """Surfaces through all piles in the box, a row a run, for the angle and whatever
    else the bench says of its piles; or through the runs of `rig`.

    alike: whether the bench's piles are the simulated ones' like, so that their scatter
    may be pooled; shared: whether piles of one packing scatter together; where a few
    pairs do not show it, a fitted share would be chance."""
    wide = box.with_factors(steel)
    inside = (abs(box.coded(box.points(piles))) <= 1 + 1e-9).all(axis=1)
    piles, packing = piles[inside], "packing" if shared else None
    read = {rig.response: readings.values, **readings.further}
    weighed = [column for column in readings.further if column in rig.rig.weighed]
    notes: list[str] = []
    if weighed and not alike:
        ratios = _ratios(read, rig)
        notes.append(
            f"not used in the posterior: {' and '.join(weighed)}, weighed of the"
            f" {rig.name} as described, not of the slice"
            + "".join(f"; {ratio} is" for ratio in ratios)
        )
        read = {c: v for c, v in read.items() if c not in weighed} | ratios
        sources = {c: _source(piles, c) for c in weighed}
        simulated = {c: piles[s] for c, s in sources.items() if s in piles}
        piles = piles.assign(**_ratios(simulated, rig))
    found, errors, used, angle = [], {}, [], None
    for column, values in read.items():
        source = _source(piles, column)
        if source not in piles or piles[source].nunique() < LEAST_DIFFERENT:
            continue
        there = piles[piles[source].notna()]
        least_squares, note = surface_through(
            there, source, wide, len(box.names), packing
        )
        surface, own = shrink(least_squares), column == rig.response
        angle = least_squares if own else angle
        try:
            mean = pooled_mean(
                values,
                name=column,
                scatter_sd=surface.noise_sd,
                df=surface.noise_df,
                pooled=alike,
                reading_sd=readings.reading_sd if own else 0.0,
                shared_sd=readings.shared_sd if own else 0.0,
            )
        except ValueError as error:
            notes.append(f"not used in the posterior: {error}")
            continue
        notes += note
        found.append(Observable(f"{rig.name}: {column}", surface, mean))
        errors[f"{rig.name}: {column}"] = pd.Series(
            surface.residuals, index=there.index
        )
        used.append(source)
    return PileObservables(
        observables=tuple(found),
        correlation=correlation_of(errors),
        used=tuple(used),
        notes=tuple(dict.fromkeys(notes)),
        angle=angle,
    )


def joined(
    parts: Sequence[PileObservables],
) -> tuple[tuple[Observable, ...], pd.DataFrame]:
    """Observables of several rigs, and the correlation of their errors: none between
    rigs, which share no run."""
    observables = tuple(o for part in parts for o in part.observables)
    names = [o.name for o in observables]
    blocks = block_diag(*(part.correlation for part in parts)) if names else None
    return observables, pd.DataFrame(blocks, index=names, columns=names, dtype=float)


def _source(piles: pd.DataFrame, column: str) -> str:
    """The column of simulated runs that a bench's stands beside."""
    measured = column in piles and bool(piles[column].notna().any())
    return column if measured else f"true_{column}"


def _ratios(
    read: Mapping[str, np.ndarray | pd.Series], rig: BySurface
) -> dict[str, np.ndarray]:
    """The rig's ratios of what was weighed, where as many of both were."""
    return {
        name: np.asarray(read[above]) / np.asarray(read[below])
        for name, (above, below) in rig.ratios.items()
        if above in read and below in read and len(read[above]) == len(read[below])
    }


def correlation_of(errors: dict[str, pd.Series]) -> pd.DataFrame:
    """Correlation of the surfaces' residuals, a hundredth short of what would make two
    observables one."""
    names = list(errors)
    found, one = pd.DataFrame(errors).corr().fillna(0.0).to_numpy(), np.eye(len(names))
    return pd.DataFrame(
        np.where(one, 1.0, MOST_CORRELATION * found), index=names, columns=names
    )


def surface_through(
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
    angle = design[PILE.response].copy()
    surface = seen.angle
    if steel is None or surface is None:
        return angle
    there = np.array([at[n] for n in steel.names])
    coded = (steel.points(design) - there) / steel.half_width
    p = coefficients(surface)["p"].to_numpy()
    for j, name in enumerate(steel.names):
        term = tuple(int(n == name) for n in surface.box.names)
        k = surface.terms.index(term) if term in surface.terms else None
        if k is not None and p[k] < SIGNIFICANT_P:
            angle -= float(surface.coefficients[k]) * coded[:, j]
    return angle


def informative(
    design: pd.DataFrame, box: Box, packing: str | None, seen: PileObservables
) -> tuple[str, ...]:
    """What, besides the angle, shows beyond packing noise that the parameters do
    something to a pile: by their main effects, for which a quick design has runs to
    spare."""
    out = []
    for column in seen.used:
        if column == PILE.response or design[column].isna().any():
            continue
        linear = fit_surface(design, column, box, terms="linear", packing=packing)
        if anova_table(linear)["p"].iloc[0] < SIGNIFICANT_P:
            out.append(column.removeprefix("true_"))
    return tuple(out)


def to_read(
    design: pd.DataFrame,
    box: Box,
    packing: str | None,
    piles: int,
    seen: PileObservables,
) -> tuple[BenchTest, ...]:
    """What else can be read of the same piles: its scatter is that of simulated ones,
    over as many."""
    known = {PILE.response, *seen.used, *box.names, *NOT_OBSERVABLES}
    out = []
    for column in design.columns:
        if column in known or column.endswith("_coded") or "_sd" in column:
            continue
        values = design[column]
        whole = values.dtype.kind == "f" and not values.isna().any()
        if not whole or values.nunique() < LEAST_DIFFERENT:
            continue
        surface = fit_surface(design, column, box, packing=packing)
        name = f"{column.removeprefix('true_').replace('_', ' ')} of the same heaps"
        runs = max(piles, 1)
        noise = np.array([[surface.noise_sd**2 / runs]])
        out.append(BenchTest(name, (surface,), noise, runs, 0.0))
    return tuple(out)
