"""Command line of `benchtwin diagnose`: options, progress, printed result, exit code."""

import json
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from twin.command import Misuse, check_folders, reported

if TYPE_CHECKING:
    from diagnose.bench import Diagnosis

DONE, FAILED, MISUSED = 0, 1, 2
OURS = {"diagnosis.json", "report.html", "twin"}  # what a diagnosis leaves in its folder
RIG_NAMES = ("drop", "slide", "roll", "pile")


@dataclass(frozen=True)
class Asked:
    """Options. rigs: only these; twin: simulate again; quick: without rendered pictures."""

    bench: Path
    out: Path
    rigs: tuple[str, ...] = ()
    rng: int = 1
    twin: bool = True
    quick: bool = False
    overwrite: bool = False
    quiet: bool = False


def diagnose_command(asked: Asked) -> int:
    """Diagnose a bench folder; returns the exit code."""
    try:
        found, drawn = diagnose_into(asked)
    except KeyboardInterrupt:
        return _say(f"stopped; no diagnosis was written to {asked.out}", FAILED)
    except (FileNotFoundError, FileExistsError, Misuse) as error:
        return _say(error, MISUSED)
    except OSError as error:
        return _say(f"{error.filename or asked.out}: {error.strerror or error}", FAILED)
    _show(found, asked, drawn)
    return DONE if found.findings and drawn else FAILED


def diagnose_into(asked: Asked) -> tuple["Diagnosis", bool]:
    """Diagnose a bench folder and write diagnosis and report into `asked.out`; also says whether the report could be drawn.

    Raises FileNotFoundError, FileExistsError or Misuse before anything runs; OSError where `out`
    cannot be written.
    """
    from diagnose.bench import diagnose_bench

    _check(asked)
    with _progress(asked.quiet) as say:
        found = diagnose_bench(asked.bench, seed=asked.rng, only=asked.rigs, say=say)
        if asked.twin:
            from diagnose.rerun import resimulate_all

            shutil.rmtree(asked.out / "twin", ignore_errors=True)  # films of an older diagnosis
            pictures = not asked.quick
            found = resimulate_all(found, asked.out / "twin", pictures=pictures, say=say)
    asked.out.mkdir(parents=True, exist_ok=True)
    file, part = asked.out / "diagnosis.json", asked.out / ".diagnosis.json.part"
    for older in (file, asked.out / "report.html"):
        older.unlink(missing_ok=True)
    part.write_text(json.dumps(found.to_json(), indent=1, allow_nan=False), encoding="utf8")
    part.replace(file)
    from report.diagnosis import write_report

    kept = f"the verdict is in {file}"
    return found, reported(lambda: write_report(found, asked.out), kept, "diagnose")


def _check(asked: Asked) -> None:
    """FileNotFoundError without a bench folder; FileExistsError where `out` holds something that must not be replaced."""
    bench, out = asked.bench, asked.out
    if wrong := [rig for rig in asked.rigs if rig not in RIG_NAMES]:
        raise Misuse(f"--rig {wrong[0]}: no such rig; there are {', '.join(RIG_NAMES)}")
    if asked.rng < 0:
        raise Misuse(f"--rng {asked.rng}: a whole number from 0 up")
    there = check_folders(bench, out, OURS, "diagnosis")
    if "diagnosis.json" in there and not asked.overwrite:
        raise FileExistsError(f"{out}: holds a diagnosis already; choose another --out, or say --overwrite")


def _show(found, asked: Asked, drawn: bool) -> None:
    """Print verdicts and where to look; problems go to stderr where nothing was found."""
    from diagnose.words import lines

    if not found.findings:
        for line in (*lines(found), f"nothing could be diagnosed in {asked.bench}"):
            _say(line, FAILED)
    elif not asked.quiet:
        console = Console(width=None if sys.stdout.isatty() else 160, highlight=False)
        report = asked.out / ("report.html" if drawn else "diagnosis.json")
        for line in (*lines(found), f"report: {report}"):
            console.print(line, markup=False, soft_wrap=True)


def _say(error, code: int) -> int:
    print(f"benchtwin diagnose: {error}", file=sys.stderr)
    return code


@contextmanager
def _progress(quiet: bool) -> Iterator:
    """A function that shows the current stage."""
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), disable=quiet, transient=True) as progress:
        task = progress.add_task("", total=None)
        yield lambda text: progress.update(task, description=text)
