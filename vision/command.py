"""`benchtwin measure` as a person meets it: what was typed, the progress, the short table, the exit code."""

import math
import re
import sys
from functools import partial
from pathlib import Path

import pandas as pd
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from vision.batch import (
    Results,
    find_all,
    measured_anything,
    observe,
    observe_or_fail,
    observe_seeds_photo,
    of_all,
    remember,
    unread_notes,
)  # fmt: skip
from vision.measurement import DOUBTFUL, FAILED, GOOD, MeasurementError, Observation
from vision.pile.repose import PileOptions
from vision.recording import Recording
from vision.summary import Line

MEASURED, NOTHING, MISUSED = 0, 1, 2
_ORDER = {FAILED: 0, DOUBTFUL: 1, GOOD: 2}


def measure_command(
    paths: list[Path], out: Path, window: str, roi: str, baseline: str, trim: bool, seeds: bool, overwrite: bool, quiet: bool
) -> int:
    """Measure everything under `paths` into the folder `out`; returns the exit code."""
    try:
        options = PileOptions(_window(window), _roi(roi), _baseline(baseline))
        if missing := [p for p in paths if not p.exists()]:
            raise MeasurementError(f"{missing[0]}: no such file or folder")
        results = Results(out, paths, overwrite)
    except (MeasurementError, OSError) as error:
        print(f"benchtwin measure: {error}", file=sys.stderr)
        return MISUSED
    try:
        table = _run(paths, results, options, trim, seeds, quiet)
    except OSError as error:
        print(f"benchtwin measure: cannot write to {out}: {error.strerror or error}", file=sys.stderr)
        return MISUSED
    except KeyboardInterrupt:
        print(f"\nbenchtwin measure: stopped; nothing was written to {out}", file=sys.stderr)
        return NOTHING
    finally:
        results.abandon()
    if not quiet:
        _show(table, results.notes)
        _show_summary(results.summary)
        _show_places(table, out)
    elif not measured_anything(table):
        print(f"benchtwin measure: nothing could be measured; the reasons are in {out / 'measurements.csv'}", file=sys.stderr)
    return MEASURED if measured_anything(table) else NOTHING


def _run(paths: list[Path], results: Results, options: PileOptions, trim: bool, seeds: bool, quiet: bool) -> pd.DataFrame:
    entries = find_all(paths)
    results.notes += unread_notes(paths, entries)
    rolls: list[tuple[Recording, Observation]] = []
    bar = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.completed:.0f}/{task.total}"), TimeRemainingColumn())
    with Progress(*bar, console=Console(stderr=True), disable=quiet, transient=True) as progress:
        task = progress.add_task("measuring", total=len(entries))
        for i, entry in enumerate(entries):
            progress.update(task, description=getattr(entry, "id", "?")[:40])
            advance = partial(_advance, progress, task, i)
            measure = observe_seeds_photo if seeds else partial(observe, options=options, trim=trim, progress=advance)
            observation = observe_or_fail(entry, measure, "seeds" if seeds else None)
            results.add(observation)
            remember(rolls, entry, observation)
            progress.update(task, completed=i + 1)
    for together in of_all(rolls):
        results.add(together)
    return results.finish()


def _advance(progress: Progress, task, done: int, share: float) -> None:
    progress.update(task, completed=done + share)


def _show(table: pd.DataFrame, notes: list[tuple[str, str]]) -> None:
    """The short table, doubtful ones first."""
    console = _console()
    shown = Table(box=None, pad_edge=False)
    for heading in ("recording", "quantity", "value", "± sd", "unit"):
        shown.add_column(heading, justify="right" if heading in ("value", "± sd") else "left", no_wrap=True)
    shown.add_column("quality")
    colours = {GOOD: "green", DOUBTFUL: "yellow", FAILED: "red"}
    rank = table["quality"].map(_ORDER)
    for row in table.assign(rank=rank).sort_values("rank", kind="stable").itertuples():
        value, sd = _rounded(row.value, row.sd)
        reason = f": {row.reason}" if row.reason else ""
        shown.add_row(
            _plain(row.recording), row.quantity, value, sd, "" if row.unit == "1" else row.unit,
            f"[{colours[row.quality]}]{row.quality}[/]{_plain(reason)}",
        )  # fmt: skip
    console.print(shown)
    for recording, note in notes:
        console.print(f"[dim]{_plain(recording)}: {_plain(note)}[/]")


def _show_summary(lines: list[Line]) -> None:
    """What a paper prints: the mean over the repeats, where there are any."""
    repeated = [line for line in lines if line.n > 1]
    if not repeated:
        return
    several = len({line.bench for line in repeated}) > 1
    shown = Table(box=None, pad_edge=False)
    for heading in ("mean over repeats", "95 % interval", "unit", "n", "scatter", "of it measuring", ""):
        shown.add_column(heading, justify="left" if heading in ("mean over repeats", "unit", "") else "right", no_wrap=bool(heading))
    for line in repeated:
        name = " ".join(part for part in (line.bench if several else "", line.rig, line.quantity) if part)
        mean, half = _rounded(line.mean, (line.high - line.low) / 2)
        doubts = (
            *([f"{line.doubtful} of {line.n} doubtful"] if line.doubtful else []),
            *([f"{line.not_measured} not measured"] if line.not_measured else []),
            *([f"far from the others: {', '.join(line.outliers)}"] if line.outliers else []),
        )
        shown.add_row(
            _plain(f"{name}, {line.conditions}" if line.conditions else name),
            f"{mean} ± {half}", "" if line.unit == "1" else line.unit, str(line.n), f"{line.scatter:.2g}",
            "–" if math.isnan(line.measuring) else f"{line.measuring:.2g}", _plain("; ".join(doubts)),
        )  # fmt: skip
    console = _console()
    console.print()
    console.print(shown)


def _show_places(table: pd.DataFrame, out: Path) -> None:
    counts = ", ".join(f"{(table['quality'] == q).sum()} {q}" for q in (GOOD, DOUBTFUL, FAILED))
    console = _console()
    numbers, means = (_plain(str(out / name)) for name in ("measurements.csv", "summary.csv"))
    console.print(f"\n{counts}.  Numbers: {numbers}  Means: {means}", highlight=False)
    if (out / "overlays").is_dir():
        console.print(f"Look at what was found: {_plain(str(out / 'overlays' / 'index.html'))}", highlight=False)


def _console() -> Console:
    return Console(width=None if sys.stdout.isatty() else 160)


def _plain(text: str) -> str:
    """Square brackets are colour marks to rich; a file may be named with them."""
    return text.replace("[", r"\[")


def _rounded(value: float, sd: float) -> tuple[str, str]:
    """Value and sd to two figures of the sd."""
    if not math.isfinite(value):
        return "–", ""
    if not math.isfinite(sd) or sd <= 0:
        return f"{value:.4g}", ""
    places = max(0, 1 - math.floor(math.log10(sd)))
    return f"{value:.{places}f}", f"{sd:.{places}f}"


def _numbers(text: str, option: str, counts: tuple[int, ...]) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in counts or not all(abs(n) < 1e6 for n in numbers):
        wanted = " or ".join(str(c) for c in counts)
        raise MeasurementError(f"{option} {text}: expected {wanted} numbers with commas between")
    return numbers


def _window(text: str) -> tuple[float, float]:
    parts = re.fullmatch(r"\s*([\d.]+)\s*%?\s*[-–,:]\s*([\d.]+)\s*%?\s*", text)
    try:
        low, high = (float(part) / 100 for part in parts.groups()) if parts else (0.0, 0.0)
    except ValueError:
        low, high = 0.0, 0.0
    if not 0 <= low < high <= 1 or high - low < 0.1:
        raise MeasurementError(f"--window {text}: expected two heights in %, at least 10 apart, such as 20-80")
    return low, high


def _roi(text: str) -> tuple[int, int, int, int] | None:
    if not text:
        return None
    x, y, width, height = (int(n) for n in _numbers(text, "--roi", (4,)))
    return x, y, width, height


def _baseline(text: str) -> tuple[float, float, float, float] | None:
    if not text:
        return None
    numbers = _numbers(text, "--baseline", (1, 4))
    x1, y1, x2, y2 = numbers if len(numbers) == 4 else (0.0, numbers[0], 1000.0, numbers[0])
    if abs(x2 - x1) < 10 * abs(y2 - y1):
        raise MeasurementError(f"--baseline {text}: the two points must lie side by side (X1,Y1,X2,Y2)")
    return x1, y1, x2, y2
