"""What `benchtwin measure` prints: the means over repeats, then what is doubtful or failed, then where everything stands."""

import math
import sys
from collections.abc import Sequence
from pathlib import Path

import pandas as pd
from rich.console import Console
from rich.table import Table

from vision.measurement import DOUBTFUL, FAILED, GOOD
from vision.summary import Line

MOST_ROWS = 30  # single results in the terminal; with more, only those that somebody must look at
MOST_NOTES = 10
ANSWERS = {  # of each rig the quantities that recordings are made for, in groups: of a group the first that was measured
    "drop": (("restitution", "restitution_normal", "rebound_height", "fall_acceleration"),),
    "slide": (("static_friction", "slide_angle"),),
    "roll": (("rolling_resistance", "rolling_friction", "run_out", "acceleration"), ("slope",)),
    "drum": (("flowing_angle",),),
    "pile": (("repose_angle", "height_over_radius_angle"), ("centroid_angle",)),
}
COLOURS = {GOOD: "green", DOUBTFUL: "yellow", FAILED: "red"}
Notes = Sequence[tuple[str, str]]


def show_results(table: pd.DataFrame, means: Sequence[Line], notes: Notes, not_read: Notes, out: Path) -> None:
    """Print a batch's results; a long batch in a dozen lines and what needs a look, a short one whole.

    table: the rows of measurements.csv; not_read: those of the notes that name files which were left out; out: the folder.
    """
    console = Console(width=None if sys.stdout.isatty() else 160)
    short = len(table) <= MOST_ROWS
    look = table["quality"] != GOOD
    if short:
        _show_rows(console, table[~look])
    _show_means(console, [line for line in means if line.n > 1] if short else _answers(means))
    if look.any():
        console.print("\nlook at these:" if (~look).any() else "")
        _show_rows(console, table[look]) if short else _show_reasons(console, table[look])
    told = notes if len(notes) <= MOST_NOTES else not_read
    for recording, note in told:
        console.print(f"[dim]{_plain(recording)}: {_plain(note)}[/]")
    counts = ", ".join(f"{(table['quality'] == q).sum()} {q}" for q in (GOOD, DOUBTFUL, FAILED))
    console.print(f"\n{len(table)} quantities: {counts}", highlight=False)
    files = {"overlays/index.html": "what was found on each, in pictures", "measurements.csv": "", "summary.csv": ""}
    files |= {} if len(told) == len(notes) else {"notes.csv": f"{len(notes)} notes on what was assumed"}
    there = [f"{name} ({what})" if what else name for name, what in files.items() if (out / name).exists()]
    console.print(_plain(f"in {out}: {', '.join(there)}"), highlight=False, soft_wrap=True)


def _answers(means: Sequence[Line]) -> list[Line]:
    """Of each bench, rig and level of a condition the lines of the quantities that it was recorded for."""
    kept = []
    for place in dict.fromkeys((line.bench, line.rig, line.conditions) for line in means):
        inside = {line.quantity: line for line in means if (line.bench, line.rig, line.conditions) == place}
        groups = ANSWERS.get(place[1], tuple((name,) for name in inside))
        found = [next((inside[name] for name in group if name in inside), None) for group in groups]
        kept += [line for line in found if line is not None]
    return kept


def _show_rows(console: Console, table: pd.DataFrame) -> None:
    shown = Table(box=None, pad_edge=False)
    for heading in ("recording", "quantity", "value", "± sd", "unit"):
        shown.add_column(heading, justify="right" if heading in ("value", "± sd") else "left", no_wrap=True)
    shown.add_column("quality")
    for row in table.itertuples():
        value, sd = _rounded(row.value, row.sd)
        reason = f": {row.reason}" if row.reason else ""
        shown.add_row(
            _plain(row.recording), row.quantity, value, sd, "" if row.unit == "1" else row.unit,
            f"[{COLOURS[row.quality]}]{row.quality}[/]{_plain(reason)}",
        )  # fmt: skip
    if len(table):
        console.print(shown)


def _show_reasons(console: Console, table: pd.DataFrame) -> None:
    """One line for each recording and reason: what is doubtful or failed there, and why."""
    for (recording, quality, reason), rows in table.groupby(["recording", "quality", "reason"], sort=False):
        what = ", ".join(rows["quantity"])
        console.print(f"{_plain(recording)}: {what} [{COLOURS[quality]}]{quality}[/]: {_plain(reason)}", highlight=False)


def _show_means(console: Console, lines: Sequence[Line]) -> None:
    """What a paper prints: the mean over the repeats."""
    if not lines:
        return
    several = len({line.bench for line in lines}) > 1
    shown = Table(box=None, pad_edge=False)
    for heading in ("mean over repeats", "± 95 %", "unit", "n", "sd between repeats", "sd of reading", ""):
        shown.add_column(heading, justify="left" if heading in ("mean over repeats", "unit", "") else "right", no_wrap=bool(heading))
    for line in lines:
        name = " ".join(part for part in (line.bench if several else "", line.rig, line.quantity) if part)
        mean, half = _rounded(line.mean, (line.high - line.low) / 2)
        doubts = (
            *([f"{line.doubtful} of {line.n} doubtful"] if line.doubtful else []),
            *([f"{line.not_measured} not measured"] if line.not_measured else []),
            *([f"far from the others: {', '.join(line.outliers)}"] if line.outliers else []),
        )
        shown.add_row(
            _plain(f"{name}, {line.conditions}" if line.conditions else name),
            f"{mean} ± {half}" if half else mean, "" if line.unit == "1" else line.unit, str(line.n),
            _figure(line.scatter), _figure(line.measuring), _plain("; ".join(doubts)),
        )  # fmt: skip
    console.print()
    console.print(shown)


def _figure(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.2g}"


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
