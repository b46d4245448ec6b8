"""What `benchtwin.calibrate` finds: contact parameters with intervals; and what it is
asked for, checked."""

import math
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
from plotly.graph_objects import Figure

from benchtwin import shown
from benchtwin.bench.exits import DONE, FAILED
from benchtwin.bench.language import tr
from benchtwin.bench.numbers import beside_interval, with_interval
from benchtwin.bench.terminal import Terminal
from benchtwin.bench.workbook import WORKBOOK, write_workbook
from benchtwin.calibrate.procedure import Calibration, parameters
from benchtwin.calibrate.procedure.calibration import advice
from benchtwin.calibrate.procedure.shape_effect import verdict
from benchtwin.calibrate.procedure.words import in_status, ties_in_words
from benchtwin.calibrate.result_file import write_result
from benchtwin.report import draw
from benchtwin.report.numbers import words
from benchtwin.report.page import render
from benchtwin.report.spreadsheet import sheets
from benchtwin.report.template import PAGE, PRINTED, write_page
from benchtwin.twin.bench_folder import Observed
from benchtwin.twin.command import (
    check_bench,
    check_out,
    print_lines,
    progress_line,
    reported,
)

# what a calibration leaves
OURS = {"result.json", PAGE, PRINTED, WORKBOOK, "tables", "runs", "twin"}


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
    written, None where none were; reported: whether the report could be drawn. details:
    every fit and table; its fields may change between versions."""

    parameters: pd.DataFrame
    not_calibrated: dict[str, str]
    findings: tuple[str, ...]
    folder: Path | None
    details: Calibration = field(repr=False)
    reported: bool = True

    def plot(self) -> Figure:
        """A panel a parameter: its value and interval."""
        table = self.parameters
        figure, places = shown.panels([draw.name(n) for n in table["parameter"]])
        for row, place in zip(table.itertuples(), places, strict=True):
            if np.isfinite([row.low, row.value, row.high]).all():
                ends = {"array": [row.high - row.value]}
                ends |= {"arrayminus": [row.value - row.low]}
                bar = ends | {"color": draw.BLUE, "thickness": 5}
                mark = {"color": draw.RED, "size": 11, "symbol": "diamond"}
                point = {"x": [row.value], "y": [" "], "mode": "markers"}
                figure.add_scatter(**point, marker=mark, error_x=bar, **place)
        figure.update_layout(height=60 + 110 * math.ceil(len(table) / 2))
        return figure

    def _repr_html_(self) -> str:
        lost = [f"{rig}: {why}" for rig, why in self.not_calibrated.items()]
        cells = as_read(self.parameters)
        return shown.html(tr("Contact parameters"), cells, [*lost, *self.findings])

    def tell(self, *, quiet: bool) -> int:
        """Print this as the command does, and return its exit code."""
        if not quiet:
            _show(self.details, self.folder or Path(), self.reported)
        return DONE if self.reported else FAILED


def summary(
    found: Calibration, folder: Path | None = None, *, reported: bool = True
) -> CalibrationSummary:
    """What a calibration found, as Python shows it."""
    return CalibrationSummary(
        parameters(found), dict(found.refused), found.findings, folder, found, reported
    )


def make_room(bench: Path | Observed, out: Path, overwrite: bool) -> None:
    """Tables of other rigs than this time's would stand beside the new result; runs are
    kept. Raises what `check_bench` and `check_out` raise."""
    check_bench(bench, out)
    there = check_out(out, OURS, "calibration", "result.json", overwrite)
    if "result.json" in there:
        shutil.rmtree(out / "tables", ignore_errors=True)
        for name in ("result.json", WORKBOOK):
            (out / name).unlink(missing_ok=True)


def written(found: Calibration, out: Path) -> CalibrationSummary:
    """Write a calibration into `out`."""
    out.mkdir(parents=True, exist_ok=True)
    write_result(found, out)
    write_workbook(out / WORKBOOK, sheets(found))
    return summary(found, out, reported=report(found, out))


def report(found: Calibration, out: Path) -> bool:
    """Write the report; a fault of ours in drawing it costs neither the results nor a
    simulation."""
    out.mkdir(parents=True, exist_ok=True)
    if found.finished:
        kept = tr("the numbers are in {}", out / "result.json")
    else:
        kept = tr("the calibration goes on")
    return reported(lambda: write_page(out, render(found)), kept, "calibrate")


@contextmanager
def stages(
    quiet: bool,
) -> Iterator[tuple[Callable[[str], None], Callable[[object], None]]]:
    """Two functions: one takes the name of every stage, one the campaign's progress."""
    stage = ""
    with progress_line(quiet) as update:

        def begin(text: str) -> None:
            nonlocal stage
            stage = text
            update(text)
            if not (quiet or sys.stderr.isatty()):  # where nothing moves
                print(text, file=sys.stderr)

        yield begin, lambda state: update(f"{stage}: {state}")


def _show(c: Calibration, out: Path, reported: bool) -> None:
    """The answer in the terminal, and where to look."""
    console = Terminal()
    shown.in_terminal(as_read(parameters(c)), console)
    # columns and keys as the files have them
    refused = [tr("not calibrated: {}: {}", rig, why) for rig, why in c.refused.items()]
    shape = verdict(c.more["shape_effect"]) if "shape_effect" in c.more else []
    lines = [
        *(line for line in c.findings if line not in c.refused.values()),
        *(*c.flags, *c.options.get("said", []), *shape),
    ]
    lines += [
        tr(
            "printed {} = {} does not follow; recomputed {:.4g}",
            r.item,
            r.printed,
            r.recomputed,
        )
        for r in c.not_following.itertuples()
    ]
    if c.joint is not None:
        lines += [*ties_in_words(c.joint.ties), *advice(c)]
    left = (
        tr("report: {}", out / PAGE) if reported else tr("tables: {}", out / "tables")
    )
    print_lines(console, *refused, *map(words, lines), left)


def as_read(table: pd.DataFrame) -> pd.DataFrame:
    """The parameters in words and in the digits that their intervals carry. table: as
    `parameters` has it."""
    rows = [
        (
            draw.name(row.parameter),
            with_interval(row.value, row.low, row.high),
            beside_interval(row.most_probable_set, row.low, row.high),
            in_status(row.status, row.remark),
        )
        for row in table.itertuples()
    ]
    names = ["parameter", "median (95 % interval)", "most probable set", ""]
    return pd.DataFrame(rows, columns=names)


def folder_of(calibrated: str | Path | CalibrationSummary) -> Path:
    """Where a calibration lies; ValueError for one that wrote no files."""
    if not isinstance(calibrated, CalibrationSummary):
        return Path(calibrated)
    if calibrated.folder is None:
        raise ValueError(
            tr("this calibration wrote no files; give calibrate a folder as out")
        )
    return calibrated.folder
