"""Command line of `benchtwin diagnose`: options, progress, printed result, exit
code."""

import json
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from benchtwin.bench.rigs import RIGS
from benchtwin.bench.terminal import Terminal
from benchtwin.bench.whole_file import write_whole
from benchtwin.report.template import PAGE, PRINTED, write_page
from benchtwin.twin.command import (
    DONE,
    FAILED,
    Misuse,
    check_bench,
    check_out,
    exit_code,
    print_lines,
    progress_line,
    reported,
    say,
)

if TYPE_CHECKING:
    from benchtwin.diagnose.bench import Diagnosis
    from benchtwin.twin.bench_folder import Observed

OURS = {"diagnosis.json", PAGE, PRINTED, "twin"}  # what a diagnosis leaves
RIG_NAMES = tuple(rig.name for rig in RIGS.values() if rig.diagnose)


@dataclass(frozen=True)
class Asked:
    """Options. rigs: only these; twin: simulate again; quick: without rendered
    pictures."""

    bench: "Path | Observed"
    out: Path
    rigs: tuple[str, ...] = ()
    rng: int = 1
    twin: bool = True
    quick: bool = False
    overwrite: bool = False
    quiet: bool = False


def diagnose_command(asked: Asked) -> int:
    """Diagnose a bench folder; returns the exit code."""
    stopped = "no diagnosis was written to {out}"
    return exit_code(
        "diagnose", asked.out, lambda: _diagnose(asked), stopped=stopped, failures=()
    )


def _diagnose(asked: Asked) -> int:
    found, drawn = diagnose_into(asked)
    _show(found, asked, drawn)
    return DONE if found.findings and drawn else FAILED


def diagnose_into(asked: Asked) -> tuple["Diagnosis", bool]:
    """Diagnose a bench folder and write diagnosis and report into `asked.out`; also
    says whether the report could be drawn.

    Raises FileNotFoundError, FileExistsError or Misuse before anything runs; OSError
    where `out` cannot be written."""
    from benchtwin.diagnose.bench import diagnose_bench

    _check(asked)
    with progress_line(asked.quiet) as show:
        found = diagnose_bench(asked.bench, seed=asked.rng, only=asked.rigs, say=show)
        found = _modelled(asked, found, show) if asked.twin else found
    asked.out.mkdir(parents=True, exist_ok=True)
    for name in ("diagnosis.json", PAGE, PRINTED):  # of an older one
        (asked.out / name).unlink(missing_ok=True)
    write_whole(
        asked.out / "diagnosis.json",
        json.dumps(found.to_json(), indent=1, allow_nan=False),
    )
    return found, _reported(found, asked.out)


def _check(asked: Asked) -> None:
    """FileNotFoundError without a bench folder; FileExistsError where `out` holds
    something that must not be replaced."""
    if wrong := [rig for rig in asked.rigs if rig not in RIG_NAMES]:
        raise Misuse(f"--rig {wrong[0]}: no such rig; there are {', '.join(RIG_NAMES)}")
    if asked.rng < 0:
        raise Misuse(f"--rng {asked.rng}: a whole number from 0 up")
    check_bench(asked.bench, asked.out)
    check_out(asked.out, OURS, "diagnosis", "diagnosis.json", asked.overwrite)


def _modelled(asked: Asked, found, say):
    """Run the simulation again with what was found; failures become notes."""
    from benchtwin.diagnose.rerun import resimulate_all

    shutil.rmtree(asked.out / "twin", ignore_errors=True)  # films of an older diagnosis
    return resimulate_all(found, asked.out / "twin", pictures=not asked.quick, say=say)


def _reported(found, out: Path) -> bool:
    """Write the report; a fault in drawing it is one line, and the verdict stays."""
    from benchtwin.report.diagnosis import render

    return reported(
        lambda: write_page(out, render(found)),
        f"the verdict is in {out / 'diagnosis.json'}",
        "diagnose",
    )


def _show(found, asked: Asked, drawn: bool) -> None:
    """Print verdicts and where to look; problems go to stderr where nothing was
    found."""
    from benchtwin.diagnose.words import lines

    if not found.findings:
        for line in (*lines(found), f"nothing could be diagnosed in {asked.bench}"):
            say("diagnose", line, FAILED)
    elif not asked.quiet:
        report = asked.out / (PAGE if drawn else "diagnosis.json")
        print_lines(Terminal(), *lines(found), f"report: {report}")
