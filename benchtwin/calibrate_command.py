"""Command line of `benchtwin calibrate`: options, progress, printed result, exit
code."""

import shutil
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from rich.table import Table

from benchtwin.bench.numbers import beside_interval, with_interval
from benchtwin.bench.terminal import Terminal
from benchtwin.bench.workbook import WORKBOOK, write_workbook
from benchtwin.calibrate.procedure import Calibration, calibrate_tables, parameters
from benchtwin.calibrate.procedure.beside import beside_tables
from benchtwin.calibrate.procedure.effort import FULL, QUICK, Effort
from benchtwin.calibrate.procedure.next_tests import in_words
from benchtwin.calibrate.procedure.pairs import pairs
from benchtwin.calibrate.procedure.rigs import PARAMETERS, PILE
from benchtwin.calibrate.procedure.shape_effect import verdict
from benchtwin.calibrate.procedure.simulated import (
    Prescribed,
    calibrate_simulated,
    checked_ranges,
)
from benchtwin.calibrate.procedure.simulator import Simulator, campaign
from benchtwin.calibrate.procedure.words import in_status, ties_in_words
from benchtwin.calibrate.result_file import write_result
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.prior import Prior
from benchtwin.report.draw import name
from benchtwin.report.numbers import words
from benchtwin.report.page import render
from benchtwin.report.spreadsheet import sheets
from benchtwin.report.template import PAGE, PRINTED, write_page
from benchtwin.twin.bench_folder import Observed
from benchtwin.twin.command import (
    DONE,
    FAILED,
    CampaignOptions,
    Misuse,
    check_bench,
    check_out,
    exit_code,
    print_lines,
    progress_line,
    reported,
)
from benchtwin.twin.engine import Engine

Pairs = Mapping[str, tuple[float, float]]
# in result.json
RECORDED: tuple[str, ...] = (
    *("twin", "rendered", "quick", "whole_pile", "method", "ranges", "priors"),
    "next_test",
)
METHODS = ("posterior", "surface")
# what a calibration leaves
OURS = {"result.json", PAGE, PRINTED, WORKBOOK, "tables", "runs", "twin"}


@dataclass(frozen=True)
class Asked(CampaignOptions):
    """Options. tables: on BENCH/tables; twin: with our simulations at the tables'
    values; method: of METHODS, "surface": piles by a publication's steps; ranges,
    priors: {name: (a, b)}."""

    bench: Path | Observed
    out: Path
    tables: bool = False
    twin: bool = False
    rendered: bool = False
    quick: bool = False
    whole_pile: bool = False
    next_test: bool = False
    method: str = "posterior"
    ranges: Pairs = field(default_factory=dict)
    priors: Pairs = field(default_factory=dict)
    engine: str = "benchtwin"
    ranks: int = 1


def calibrate_command(asked: Asked, simulator: Simulator | None = None) -> int:
    """Calibrate a bench folder; returns the exit code. simulator: instead of the
    campaign."""

    def work() -> int:
        found, drawn = calibrate_into(asked, simulator)
        if not asked.quiet:
            show(found, asked.out, reported=drawn)
        return DONE if drawn else FAILED

    return exit_code("calibrate", asked.out, work)


def calibrate_into(
    asked: Asked, simulator: Simulator | None = None
) -> tuple[Calibration, bool]:
    """Calibrate a bench folder and write the result into `asked.out`; also says whether
    its report could be drawn.

    Raises FileNotFoundError, FileExistsError or Misuse before anything runs; ValueError
    or RuntimeError where nothing can be calibrated; OSError where `out` cannot be
    written."""
    _make_room(asked)
    if asked.tables and not asked.twin:
        found = calibrate_tables(asked.bench, seed=asked.rng)
    else:
        found = _simulated(asked, simulator)
    asked.out.mkdir(parents=True, exist_ok=True)
    write_result(found, asked.out)
    write_workbook(asked.out / WORKBOOK, sheets(found))
    return found, _reported(found, asked.out)


def _make_room(asked: Asked) -> None:
    """Tables of other rigs than this time's would stand beside the new result; runs are
    kept."""
    check_bench(asked.bench, asked.out)
    there = check_out(asked.out, OURS, "calibration", "result.json", asked.overwrite)
    if "result.json" in there:
        shutil.rmtree(asked.out / "tables", ignore_errors=True)
        for name in ("result.json", WORKBOOK):
            (asked.out / name).unlink(missing_ok=True)


def _reported(found: Calibration, out: Path) -> bool:
    """Write the report; a fault of ours in drawing it costs neither the results nor a
    simulation."""
    if found.finished:
        kept = f"the numbers are in {out / 'result.json'}"
    else:
        kept = "the calibration goes on"
    return reported(lambda: write_page(out, render(found)), kept, "calibrate")


def _simulated(asked: Asked, simulator: Simulator | None) -> Calibration:
    """The procedure with simulations; the report is written anew after every rig."""
    engine, effort = _engine(asked), _effort(asked)
    recorded = {k: v for k, v in vars(asked).items() if k in RECORDED and v}
    prescribed, printed = _prescribed(asked, recorded | engine.told), None
    if asked.twin:
        printed = calibrate_tables(asked.bench, seed=asked.rng)
        prescribed = _as_tabulated(prescribed, printed)
    converted: list[str] = []
    with _progress(asked.quiet) as (say, told), ExitStack() as stack:
        simulate = simulator or stack.enter_context(
            campaign(
                asked.out / "runs",
                rendered=asked.rendered,
                workers=asked.workers,
                scheduler=asked.scheduler,
                progress=told,
                engine=engine,
                say=converted.append,
            )
        )

        def so_far(calibration: Calibration) -> None:
            asked.out.mkdir(parents=True, exist_ok=True)
            _reported(calibration, asked.out)

        found = calibrate_simulated(
            asked.bench,
            simulate,
            effort=effort,
            seed=asked.rng,
            prescribed=prescribed,
            say=say,
            so_far=so_far,
        )
        if simulator is None:  # a stand-in has no twin to show
            shown, why = pairs(found, asked.out / "twin", effort, say, engine)
            found = found.adding(pairs=shown).saying(*why)
    found = found.saying(*converted)
    return beside_tables(found, printed) if printed else found


def _engine(asked: Asked) -> Engine:
    """The engine asked for; Misuse where there is none such, Unavailable where it has
    to run here and cannot."""
    try:
        engine = Engine(asked.engine, asked.ranks)
    except ValueError as error:
        raise Misuse(error) from None
    if asked.scheduler is None:
        engine.ready(asked.workers)
    return engine


def _effort(asked: Asked) -> Effort:
    if asked.method not in METHODS:
        raise Misuse(f"--method {asked.method}: one of {', '.join(METHODS)}")
    effort = replace(
        QUICK if asked.quick else FULL,
        surface=asked.twin or asked.method == "surface",
        unrecorded=asked.next_test,
    )
    return replace(effort, slab=None) if asked.whole_pile else effort


def _prescribed(asked: Asked, options: dict) -> Prescribed:
    """Ranges and priors as typed; Misuse where they do not fit."""
    ranges, priors = dict(asked.ranges), dict(asked.priors)
    try:
        checked_ranges(ranges)
        Prior(Box.of(dict.fromkeys(PARAMETERS, (0.0, 1.0))), priors)
    except ValueError as error:
        raise Misuse(error) from None
    return Prescribed(ranges=ranges, priors=priors, options=options)


def _as_tabulated(prescribed: Prescribed, printed: Calibration) -> Prescribed:
    """The tables' own values, path, design and published optimum."""
    values = {n: tuple(f.rows[f.rig.parameter]) for n, f in printed.steel.items()}
    trimmed = {n: r.trimmed for n, r in printed.bench.rigs.items()}
    prescribed = replace(prescribed, values=values, trimmed=trimmed)
    if (fit := printed.surface) is None:
        return prescribed
    path = None
    if fit.path is not None:
        path = fit.path.errors.drop(columns=[PILE.response, "relative_error"])
    return replace(prescribed, path=path, levels=fit.box, near=fit.optimum.point)


@contextmanager
def _progress(
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


def show(c: Calibration, out: Path, *, reported: bool = True) -> None:
    """The answer in the terminal, and where to look."""
    console = Terminal()
    show_parameters(console, parameters(c).to_dict("records"))
    # columns and keys as the files have them
    refused = [f"not calibrated: {rig}: {why}" for rig, why in c.refused.items()]
    shape = verdict(c.more["shape_effect"]) if "shape_effect" in c.more else []
    lines = [
        *(line for line in c.findings if line not in c.refused.values()),
        *(*c.flags, *c.options.get("said", []), *shape),
    ]
    lines += [
        f"printed {r.item} = {r.printed} does not follow; recomputed {r.recomputed:.4g}"
        for r in c.not_following.itertuples()
    ]
    if c.joint is not None:
        lines += [*ties_in_words(c.joint.ties), *in_words(c.joint.next_tests)]
    left = f"report: {out / PAGE}" if reported else f"tables: {out / 'tables'}"
    print_lines(console, *refused, *map(words, lines), left)


def show_parameters(console: Terminal, rows: list[dict]) -> None:
    """A line a parameter. rows: as `parameters` has them."""
    shown = Table(box=None, pad_edge=False)
    for heading in ("parameter", "median (95 % interval)", "most probable set", ""):
        shown.add_column(heading)
    for row in rows:
        ends = row["low"], row["high"]
        shown.add_row(
            name(row["parameter"]),
            with_interval(row["value"], *ends),
            beside_interval(row["most_probable_set"], *ends),
            in_status(row["status"], row["remark"]),
        )
    console.print(shown)
