"""`benchtwin calibrate` as a person meets it: what was typed, the progress, the answer, the exit code."""

import shutil
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from calibrate.procedure import Calibration, calibrate_tables, parameters
from calibrate.procedure.rigs import PARAMETERS, PILE_RESPONSE
from calibrate.procedure.shape_effect import verdict
from calibrate.result_file import write_result
from report import write_report
from report.draw import name
from report.numbers import with_interval, words
from twin.command import Misuse, check_folders, reported
from twin.engine import Engine

DONE, STOPPED, MISUSED = 0, 1, 2
RECORDED = ("twin", "rendered", "quick", "whole_pile", "design", "ranges", "priors")  # options of a calibration, for the record
OURS = {"result.json", "report.html", "tables", "runs", "twin"}  # what a calibration leaves in its folder


@dataclass(frozen=True)
class Asked:
    """What was typed. tables: on BENCH/tables; twin: with our simulations at the tables' values; ranges, priors: "NAME=A:B"."""

    bench: Path
    out: Path
    tables: bool = False
    twin: bool = False
    rendered: bool = False
    quick: bool = False
    whole_pile: bool = False
    design: str = "box-behnken"
    ranges: tuple[str, ...] = ()
    priors: tuple[str, ...] = ()
    rng: int = 1
    workers: int | None = None
    scheduler: str | None = None
    engine: str = "benchtwin"
    ranks: int = 1
    overwrite: bool = False
    quiet: bool = False


def calibrate_command(asked: Asked, simulator=None) -> int:
    """Calibrate a bench folder; returns the exit code. simulator: in the place of the campaign, for tests."""
    try:
        found, drawn = calibrate_into(asked, simulator)
    except KeyboardInterrupt:
        return _say(f"stopped; the same command goes on where it stopped ({asked.out})", STOPPED)
    except (FileNotFoundError, FileExistsError, Misuse) as error:
        return _say(error, MISUSED)
    except (ValueError, RuntimeError) as error:  # nothing could be calibrated; the campaign stopped
        return _say(error, STOPPED)
    except OSError as error:
        return _say(f"{error.filename or asked.out}: {error.strerror or error}", STOPPED)
    if not asked.quiet:
        show(found, asked.out, reported=drawn)
    return DONE if drawn else STOPPED


def calibrate_into(asked: Asked, simulator=None) -> tuple[Calibration, bool]:
    """Calibrate a bench folder and write the result into `asked.out`; also says whether its report could be drawn.

    Raises FileNotFoundError, FileExistsError or Misuse before anything runs; ValueError or RuntimeError where nothing can be
    calibrated; OSError where `out` cannot be written.
    """
    _check(asked)
    found = calibrate_tables(asked.bench, seed=asked.rng) if asked.tables and not asked.twin else _simulated(asked, simulator)
    asked.out.mkdir(parents=True, exist_ok=True)
    write_result(found, asked.out)
    return found, _reported(found, asked.out)


def _reported(found: Calibration, out: Path) -> bool:
    """Write the report; a fault of ours in drawing it must cost neither the results nor a simulation, and is told in one line."""
    kept = f"the numbers are in {out / 'result.json'}" if found.finished else "the calibration goes on"
    return reported(lambda: write_report(found, out), kept, "calibrate")


def _say(error, code: int) -> int:
    print(f"benchtwin calibrate: {error}", file=sys.stderr)
    return code


def _check(asked: Asked) -> None:
    """FileNotFoundError without a bench folder; FileExistsError where `out` holds something that must not be replaced."""
    bench, out = asked.bench, asked.out
    there = check_folders(bench, out, OURS, "calibration")
    if "result.json" in there:
        if not asked.overwrite:
            raise FileExistsError(f"{out}: holds a result already; choose another --out, or say --overwrite")
        # tables of other rigs than this time's would stand beside the new result; the finished runs are kept
        shutil.rmtree(out / "tables", ignore_errors=True)
        (out / "result.json").unlink()


def _simulated(asked: Asked, simulator) -> Calibration:
    """The procedure with simulations; the report is written anew after every rig."""
    from calibrate.procedure.beside import beside_tables
    from calibrate.procedure.effort import FULL, QUICK
    from calibrate.procedure.pile_runs import DESIGNS
    from calibrate.procedure.simulated import Wishes, calibrate_simulated, checked_ranges
    from calibrate.procedure.simulator import campaign
    from calibrate.statistics.box import Box
    from calibrate.statistics.prior import Prior

    engine = _engine(asked)
    if asked.design not in DESIGNS:
        raise Misuse(f"--design {asked.design}: one of {', '.join(DESIGNS)}")
    effort = replace(QUICK if asked.quick else FULL, design=asked.design)
    effort = replace(effort, slab=None) if asked.whole_pile else effort
    options = {k: v for k, v in vars(asked).items() if k in RECORDED and v} | engine.told
    wishes = Wishes(_pairs(asked.ranges, "--range"), _pairs(asked.priors, "--prior"), options=options)
    try:
        checked_ranges(wishes.ranges)
        Prior(Box.of(dict.fromkeys(PARAMETERS, (0.0, 1.0))), wishes.held)
    except ValueError as error:
        raise Misuse(error) from None
    printed = None
    if asked.twin:
        printed = calibrate_tables(asked.bench, seed=asked.rng)
        wishes = _as_tabulated(wishes, printed)
    converted: list[str] = []
    with _progress(asked.quiet) as (say, told), ExitStack() as stack:
        simulate = simulator or stack.enter_context(
            campaign(
                asked.out / "runs", rendered=asked.rendered, workers=asked.workers, scheduler=asked.scheduler, progress=told,
                engine=engine, say=converted.append,
            )
        )  # fmt: skip

        def so_far(calibration: Calibration) -> None:
            asked.out.mkdir(parents=True, exist_ok=True)
            _reported(calibration, asked.out)

        found = calibrate_simulated(asked.bench, simulate, effort=effort, seed=asked.rng, wishes=wishes, say=say, so_far=so_far)
        if simulator is None:  # a stand-in has no twin to show
            found = _with_pairs(found, asked.out / "twin", effort, say, engine)
        found = replace(found, options={**found.options, "said": [*found.options.get("said", []), *converted]})
    return beside_tables(found, printed) if printed else found


def _engine(asked: Asked) -> Engine:
    """The engine asked for; Misuse where there is none such, Unavailable where it has to run here and cannot."""
    try:
        engine = Engine(asked.engine, asked.ranks)
    except ValueError as error:
        raise Misuse(error) from None
    if asked.scheduler is None:
        engine.ready(asked.workers)
    return engine


def _with_pairs(found: Calibration, out: Path, effort, say, engine: Engine) -> Calibration:
    """With recordings of the bench beside their twins; a rig that cannot be shown says why."""
    from calibrate.procedure.pairs import pairs

    shown, why = pairs(found, out, effort, say, engine)
    options = {**found.options, "said": [*found.options.get("said", []), *why]}
    return replace(found, more={**found.more, "pairs": shown}, options=options)


def _as_tabulated(wishes, printed: Calibration):
    """The tables' own values, path, design and published optimum."""
    values = {n: tuple(fit.rows[fit.rig.parameter]) for n, fit in printed.steel.items()}
    wishes = replace(wishes, values=values, trimmed={n: r.trimmed for n, r in printed.bench.rigs.items()})
    if printed.pile is None:
        return wishes
    pile = printed.pile
    path = pile.path.errors.drop(columns=[PILE_RESPONSE, "relative_error"]) if pile.path is not None else None
    return replace(wishes, path=path, levels=pile.box, near=pile.optimum.point)


def _pairs(texts: tuple[str, ...], option: str) -> dict[str, tuple[float, float]]:
    """ "name=a:b" → {name: (a, b)}."""
    out = {}
    for text in texts:
        key, _, ends = text.partition("=")
        try:
            a, b = (float(v) for v in ends.split(":"))
        except ValueError:
            raise Misuse(f"{option} {text}: expected NAME=NUMBER:NUMBER, such as seed_restitution=0.4:0.7") from None
        out[key.strip()] = (a, b)
    return out


@contextmanager
def _progress(quiet: bool) -> Iterator[tuple]:
    """Two functions: one told of every stage, one of the campaign's progress."""
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), disable=quiet, transient=True) as progress:
        task, stage = progress.add_task("", total=None), [""]

        def say(text: str) -> None:
            stage[0] = text
            progress.update(task, description=text)
            if not progress.console.is_terminal:  # where nothing moves
                progress.console.print(text, highlight=False)

        yield say, lambda told: progress.update(task, description=f"{stage[0]}: {told}")


def show(c: Calibration, out: Path, *, reported: bool = True) -> None:
    """The answer in the terminal, and where to look."""
    console = Console(width=None if sys.stdout.isatty() else 160, highlight=False)
    show_parameters(console, parameters(c).to_dict("records"))
    refused = [f"not calibrated: {rig}: {why}" for rig, why in c.refused.items()]  # columns and keys as the files have them
    lines = [*(line for line in c.findings if line not in c.refused.values()), *c.flags, *c.options.get("said", [])]
    lines += verdict(c.more["shape_effect"]) if "shape_effect" in c.more else []
    wrong = c.checks[~c.checks["follows"].astype(bool)] if len(c.checks) else c.checks
    lines += [f"printed {r.item} = {r.printed} does not follow; recomputed {r.recomputed:.4g}" for r in wrong.itertuples()]
    for line in (*refused, *map(words, lines), f"report: {out / 'report.html'}" if reported else f"tables: {out / 'tables'}"):
        console.print(line, markup=False, soft_wrap=True)


def show_parameters(console: Console, rows: list[dict]) -> None:
    """A line a parameter. rows: parameter, value, low, high, status."""
    shown = Table(box=None, pad_edge=False)
    for heading in ("parameter", "value (95 % interval)", ""):
        shown.add_column(heading)
    for row in rows:
        shown.add_row(name(row["parameter"]), with_interval(row["value"], row["low"], row["high"]), row["status"])
    console.print(shown)
