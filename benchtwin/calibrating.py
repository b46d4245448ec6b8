"""`benchtwin.calibrate`: a bench folder → contact parameters with intervals."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
from plotly.graph_objects import Figure

from benchtwin import shown
from benchtwin.bench.numbers import with_interval
from benchtwin.blas import on_one_blas_thread
from benchtwin.calibrate.procedure import Calibration, calibrate_tables, parameters
from benchtwin.calibrate.procedure.words import in_status
from benchtwin.calibrate_command import Asked, calibrate_into
from benchtwin.measuring import Bench, recordings_of
from benchtwin.report import draw


@dataclass(frozen=True, eq=False)
class CalibrationSummary:
    """What a calibration found.

    parameters: a row a contact parameter: parameter; value (the posterior's median),
    low, high, level (the chance that low to high holds the value), unit; status
    ("calibrated", "only bounded" where low or high is a limit of what was simulated,
    "not resolved", "doubtful") and remark, what it means; most_probable_set, its value
    in the one set of all parameters that fits best together, which is exported; source;
    budget (shares of its variance). not_calibrated: rigs that gave nothing,
    and why. findings: what no contact parameters explain. folder: where files were
    written, None where none were. details: every fit and table; its fields may change
    between versions."""

    parameters: pd.DataFrame
    not_calibrated: dict[str, str]
    findings: tuple[str, ...]
    folder: Path | None
    details: Calibration = field(repr=False)

    def plot(self) -> Figure:
        """A panel a parameter: its value and interval."""
        table = self.parameters
        figure, places = shown.panels([draw.name(n) for n in table["parameter"]])
        for row, place in zip(table.itertuples(), places, strict=True):
            if np.isfinite([row.low, row.value, row.high]).all():
                for trace in shown.across(row.low, row.value, row.high, " "):
                    figure.add_trace(trace, **place)
        figure.update_layout(height=60 + 110 * math.ceil(len(table) / 2))
        return figure

    def _repr_html_(self) -> str:
        table = self.parameters
        cells = pd.DataFrame(
            {
                "parameter": table["parameter"].map(draw.name),
                "median (95 % interval)": [
                    with_interval(row.value, row.low, row.high)
                    for row in table.itertuples()
                ],
                "unit": table["unit"].map(draw.unit),
                "status": [
                    in_status(row.status, row.remark) for row in table.itertuples()
                ],
                "most probable set": table["most_probable_set"],
            }
        )
        lost = [f"{rig}: {why}" for rig, why in self.not_calibrated.items()]
        return shown.html("Contact parameters", cells, [*lost, *self.findings])


@on_one_blas_thread
def calibrate(
    bench: Bench,
    *,
    out: str | Path | None = None,
    tables: bool = False,
    quick: bool = False,
    whole_pile: bool = False,
    next_test: bool = False,
    rendered: bool = False,
    method: str = "posterior",
    ranges: Mapping[str, tuple[float, float]] | None = None,
    priors: Mapping[str, tuple[float, float]] | None = None,
    rng: int = 1,
    workers: int | None = None,
    scheduler: str | None = None,
    overwrite: bool = False,
    progress: bool = False,
) -> CalibrationSummary:
    """Calibrate contact parameters on a bench: values with intervals, and what the
    bench leaves open.

    bench: its folder, or what `measure` found on it: no recording is then read again.
    out: folder for result.json, tables, report and finished simulations; only with
    tables=True may it be left out. tables: calibrate on the simulations in BENCH/tables
    instead of simulating. quick: fewer repeats and piles, wider intervals. whole_pile:
    simulate the pile as described, not a slice of it. next_test: simulate rigs that the
    bench has not recorded, to tell what they would add. rendered: film every run and
    measure the pictures. method: "posterior", or "surface": piles by a publication's
    steps (steepest ascent, Box–Behnken, analysis of variance, optimum).
    ranges: (low, high) in which to look for a seed–seed parameter; priors: (mean, sd)
    of a parameter known beforehand; both by its name. rng: seed of the random numbers.
    workers: processes that simulate, else one a core; scheduler: tcp://host:port of a
    dask scheduler. overwrite: replace a result; finished simulations are kept.
    progress: shown on stderr.

    A script guards its call by `if __name__ == "__main__":`, because the workers are
    processes that import it. Raises FileNotFoundError for a bench that is not there;
    FileExistsError where `out` must not be replaced; ValueError where an option does
    not fit or nothing can be calibrated; RuntimeError where simulations fail."""
    if out is None:
        if not tables:
            raise ValueError(
                "calibrate: out names the folder that keeps finished simulations; only"
                " tables=True needs none"
            )
        return _summary(calibrate_tables(recordings_of(bench), seed=rng), None)
    asked = Asked(
        recordings_of(bench),
        Path(out),
        tables=tables,
        quick=quick,
        whole_pile=whole_pile,
        next_test=next_test,
        rendered=rendered,
        method=method,
        ranges=ranges or {},
        priors=priors or {},
        rng=rng,
        workers=workers,
        scheduler=scheduler,
        overwrite=overwrite,
        quiet=not progress,
    )
    found, _ = calibrate_into(asked)
    return _summary(found, asked.out)


def _summary(found: Calibration, folder: Path | None) -> CalibrationSummary:
    return CalibrationSummary(
        parameters(found), dict(found.refused), found.findings, folder, found
    )


def folder_of(calibrated: str | Path | CalibrationSummary) -> Path:
    """Where a calibration lies; ValueError for one that wrote no files."""
    if not isinstance(calibrated, CalibrationSummary):
        return Path(calibrated)
    if calibrated.folder is None:
        raise ValueError(
            "this calibration wrote no files; give calibrate a folder as out"
        )
    return calibrated.folder
