"""What stands for a rig that tells of seed on seed in the posterior: a surrogate over
seed–seed and seed–steel parameters for each thing seen.

The seed–steel parameters vary along: every pile of the design has them low or high, so
that what they do to a pile is known without a pile more, and their uncertainty goes
into the posterior."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import cast

import numpy as np
import pandas as pd
from scipy.linalg import block_diag

from benchtwin.bench.language import tr
from benchtwin.bench.tells import Believed, BySurface
from benchtwin.calibrate.procedure.bench import RigReadings
from benchtwin.calibrate.procedure.rigs import PILE
from benchtwin.calibrate.statistics.bench import BenchMean, pooled_mean
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.posterior import Observable
from benchtwin.calibrate.statistics.surrogate import Surrogate, fit_surrogate

# of a seed–steel parameter: how far to either side it varies at least, so that what it
# does to a pile shows beside packing noise; and at least so many of its own sds
STEEL_HALF_RANGE, STEEL_SDS = 0.25, 4
MOST_CORRELATION = 0.99  # so that no two observables count as one and the same
LEAST_DIFFERENT = 8  # values of a column, below which it is a count or a constant


@dataclass(frozen=True, kw_only=True, eq=False)
class PileObservables:
    """observables of the bench's piles with their surrogates, the rig's own reading
    first; box: of the seed–seed parameters; correlation between their errors, by name;
    notes; findings, for a diagnosis; runs: all that was simulated; alike: whether the
    bench's piles are simulated as they are; believed: what the surrogates depend on
    beside the contact parameters, and nobody stated."""

    observables: tuple[Observable, ...]
    box: Box
    correlation: pd.DataFrame
    notes: tuple[str, ...] = ()
    findings: tuple[str, ...] = ()
    runs: pd.DataFrame = field(default_factory=pd.DataFrame)
    alike: bool = True
    believed: Mapping[str, Believed] = field(default_factory=dict)

    @property
    def surrogates(self) -> list[Surrogate]:
        """Of the observables, in their order."""
        return [cast(Surrogate, o.surrogate) for o in self.observables]

    @property
    def used(self) -> list[str]:
        """Columns of readings that they come from."""
        return [o.name.split(": ", 1)[1] for o in self.observables]

    @property
    def bench(self) -> BenchMean:
        """Mean of the rig's own reading."""
        return self.observables[0].bench


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


def observed(
    piles: pd.DataFrame,
    readings: RigReadings,
    box: Box,
    steel: Box | None,
    *,
    alike: bool,
    rig: BySurface = PILE,
) -> PileObservables:
    """Surrogates through all runs of `rig` in the box, a row each, for whatever the
    bench says of it.

    alike: whether the bench's piles are the simulated ones' like, so that their scatter
    may be pooled, and weights compared."""
    inside = (abs(box.coded(box.points(piles))) <= 1 + 1e-9).all(axis=1)
    piles = with_ratios(piles[inside], rig)
    read, notes = _read(readings, rig, alike)
    found, errors = [], {}
    for column, values in read.items():
        if (through := surrogate_of(piles, column, box, steel)) is None:
            continue
        own, name = column == rig.response, f"{rig.name}: {column}"
        surrogate, residuals = through
        recorded = max(int((readings.recordings.get("n", pd.Series()) > 0).sum()), 1)
        alike_sd = scatter_apart(surrogate, piles, rig)[0] / np.sqrt(recorded)
        stated = readings.description.get(rig.rig.name, {})
        left_out = rig.left_out(stated) * abs(float(np.mean(values)))
        shared = float(np.hypot(np.hypot(readings.shared_sd, alike_sd), left_out))
        try:
            mean = pooled_mean(
                values,
                name=column,
                scatter_sd=surrogate.noise_sd,
                df=surrogate.noise_df,
                pooled=alike,
                reading_sd=readings.reading_sd if own else 0.0,
                shared_sd=shared if own else 0.0,
            )
        except ValueError as error:
            notes.append(tr("not used in the posterior: {}", error))
            continue
        found.append(Observable(name, surrogate, mean))
        errors[name] = residuals
    return PileObservables(
        observables=tuple(found),
        box=box,
        correlation=correlation_of(errors),
        notes=tuple(notes),
        runs=piles,
        alike=alike,
    )


def scatter_apart(
    surrogate: Surrogate, runs: pd.DataFrame, rig: BySurface
) -> tuple[float, float]:
    """What the scatter of single runs is made of, where each is a mean of several
    readings: sd between runs (the card, the bed), and sd of a reading within one; none
    and all of it where runs do not show it."""
    if rig.within not in runs:
        return 0.0, surrogate.noise_sd * float(np.sqrt(rig.per_run))
    within = float(np.sqrt((runs[rig.within] ** 2).mean()))
    between = surrogate.noise_sd**2 - within**2 / rig.per_run
    return float(np.sqrt(max(between, 0.0))), within


def _read(
    readings: RigReadings, rig: BySurface, alike: bool
) -> tuple[dict[str, np.ndarray], list[str]]:
    """{column: readings} that simulated runs can be held against; weights of a pile
    that is not simulated as it is are left out and named, their ratios taken."""
    read = {rig.response: readings.values, **readings.further}
    weighed = [column for column in readings.further if column in rig.rig.weighed]
    if not weighed or alike:
        return read, []
    ratios = _ratios(read, rig)
    note = tr(
        "not used in the posterior: {}, weighed of the {} as described, not of the"
        " slice",
        tr(" and ").join(weighed),
        rig.name,
    )
    note += "".join(f"; {ratio} is" for ratio in ratios)
    return {c: v for c, v in read.items() if c not in weighed} | ratios, [note]


def surrogate_of(
    runs: pd.DataFrame, column: str, box: Box, steel: Box | None
) -> tuple[Surrogate, pd.Series] | None:
    """The surrogate of a bench's column through simulated runs, and its residuals; None
    where they do not show it."""
    source = simulated_column(runs, column)
    if source not in runs or runs[source].nunique() < LEAST_DIFFERENT:
        return None
    there = runs[runs[source].notna()]
    wide = box.with_factors(steel)
    surrogate = fit_surrogate(there, source, wide, curved=len(box.names))
    return surrogate, pd.Series(surrogate.residuals, index=there.index)


def joined(
    parts: Sequence[PileObservables],
) -> tuple[tuple[Observable, ...], pd.DataFrame]:
    """Observables of several rigs, and the correlation of their errors: none between
    rigs, which share no run."""
    observables = tuple(o for part in parts for o in part.observables)
    names = [o.name for o in observables]
    blocks = block_diag(*(part.correlation for part in parts)) if names else None
    return observables, pd.DataFrame(blocks, index=names, columns=names, dtype=float)


def simulated_column(runs: pd.DataFrame, column: str) -> str:
    """The column of simulated runs that a bench's stands beside."""
    measured = column in runs and bool(runs[column].notna().any())
    return column if measured else f"true_{column}"


def with_ratios(runs: pd.DataFrame, rig: BySurface) -> pd.DataFrame:
    """Simulated runs with the rig's ratios of what is weighed."""
    weighed = {c: simulated_column(runs, c) for c in rig.rig.weighed}
    found = {c: runs[source] for c, source in weighed.items() if source in runs}
    return runs.assign(**_ratios(found, rig))


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
    """Correlation of the surrogates' residuals, a hundredth short of what would make
    two observables one."""
    names = list(errors)
    found, one = pd.DataFrame(errors).corr().fillna(0.0).to_numpy(), np.eye(len(names))
    return pd.DataFrame(
        np.where(one, 1.0, MOST_CORRELATION * found), index=names, columns=names
    )
