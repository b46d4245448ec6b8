"""`benchtwin calibrate` as a person meets it: what was typed, the progress, the answer, the exit code."""

import shutil
import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table

from calibrate.procedure import Calibration, calibrate_tables, parameters
from calibrate.report import write_report
from calibrate.report.draw import name
from calibrate.report.numbers import with_interval
from calibrate.result_file import write_result

DONE, STOPPED, MISUSED = 0, 1, 2
OURS = {"result.json", "report.html", "tables", "runs"}  # what a calibration leaves in its folder


def calibrate_command(bench: Path, out: Path, *, tables: bool, rng: int, overwrite: bool, quiet: bool) -> int:
    """Calibrate a bench folder into the folder `out`; returns the exit code."""
    try:
        _check(bench, out, overwrite)
        found = calibrate_tables(bench, seed=rng)
        out.mkdir(parents=True, exist_ok=True)
        write_result(found, out)
        write_report(found, out)
    except KeyboardInterrupt:
        print(f"\nbenchtwin calibrate: stopped; the same command goes on where it stopped ({out})", file=sys.stderr)
        return STOPPED
    except (FileNotFoundError, FileExistsError) as error:
        print(f"benchtwin calibrate: {error}", file=sys.stderr)
        return MISUSED
    except ValueError as error:
        print(f"benchtwin calibrate: {error}", file=sys.stderr)
        return STOPPED
    except OSError as error:
        print(f"benchtwin calibrate: {error.filename or out}: {error.strerror or error}", file=sys.stderr)
        return STOPPED
    if not quiet:
        show(found, out)
    return DONE


def _check(bench: Path, out: Path, overwrite: bool) -> None:
    """FileNotFoundError without a bench folder; FileExistsError where `out` holds something that must not be replaced."""
    if not bench.is_dir():
        raise FileNotFoundError(f"{bench}: {'is not a folder' if bench.exists() else 'no such folder'}")
    if out.exists() and not out.is_dir():
        raise FileExistsError(f"{out}: is a file; --out names a folder")
    there = {p.name for p in out.iterdir() if not p.name.startswith(".")} if out.is_dir() else set()
    if there - OURS:
        raise FileExistsError(f"{out}: holds {sorted(there - OURS)[0]}, which no calibration wrote; choose another --out")
    if "result.json" in there:
        if not overwrite:
            raise FileExistsError(f"{out}: holds a result already; choose another --out, or say --overwrite")
        # tables of other rigs than this time's would stand beside the new result; the finished runs are kept
        shutil.rmtree(out / "tables", ignore_errors=True)
        (out / "result.json").unlink()


def show(c: Calibration, out: Path) -> None:
    """The answer in the terminal, and where to look."""
    console = Console(width=None if sys.stdout.isatty() else 160, highlight=False)
    shown = Table(box=None, pad_edge=False)
    for heading in ("parameter", "value (95 % interval)", ""):
        shown.add_column(heading)
    for row in parameters(c).itertuples():
        shown.add_row(name(row.parameter), with_interval(row.value, row.low, row.high), row.status)
    console.print(shown)
    for rig, why in c.refused.items():
        console.print(f"not calibrated: {rig}: {why}", markup=False, soft_wrap=True)
    for line in (*c.findings, *c.flags):
        console.print(line, markup=False, soft_wrap=True)
    wrong = c.checks[~c.checks["follows"].astype(bool)] if len(c.checks) else c.checks
    for row in wrong.itertuples():
        console.print(
            f"printed {row.item} = {row.printed} does not follow; recomputed {row.recomputed:.4g}", markup=False, soft_wrap=True
        )
    console.print(f"report: {out / 'report.html'}", markup=False, soft_wrap=True)
