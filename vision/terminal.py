"""What `benchtwin measure` prints: means over repeats, doubtful and failed results, and
where the files are."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import pandas as pd
from rich.table import Table
from rich.text import Text

from benchtwin.bench.language import tr
from benchtwin.bench.numbers import with_interval, with_sd
from benchtwin.bench.outlets import plain
from benchtwin.bench.rigs import RIGS
from benchtwin.bench.terminal import Terminal
from benchtwin.vision.measurement import DOUBTFUL, FAILED, GOOD
from benchtwin.vision.summary import Line

MOST_ROWS = 30  # single results; of more, only doubtful and failed ones are printed
MOST_NOTES = 10
# of each rig, in groups of which the first measured one is printed
MAIN_QUANTITIES = {rig.name: rig.printed for rig in RIGS.values()}
COLOURS = {GOOD: "green", DOUBTFUL: "yellow", FAILED: "red"}
Notes = Sequence[tuple[str, str]]


def show_results(
    table: pd.DataFrame, means: Sequence[Line], notes: Notes, not_read: Notes, out: Path
) -> None:
    """Print the results of a batch; of a long one only the main quantities and what is
    doubtful or failed. table: the rows of measurements.csv; not_read: those of the
    notes that name files which were left out; out: the folder."""
    console = Terminal()
    short = len(table) <= MOST_ROWS
    look = table["quality"] != GOOD
    if short:
        _show_rows(console, table[~look])
    lines = list(means) if short else _main_results(means)
    lines = lines if any(line.n > 1 for line in lines) else []
    _show_means(console, lines)
    if look.any():
        console.print(tr("\nlook at these:") if (~look).any() else "")
        _show_rows(console, table[look])
    shown_notes = notes if len(notes) <= MOST_NOTES else not_read
    for recording, note in shown_notes:
        console.print(f"{recording}: {note}", style="dim")
    counts = ", ".join(
        f"{(table['quality'] == q).sum()} {tr(q)}" for q in (GOOD, DOUBTFUL, FAILED)
    )
    assumed = tr("{} notes on what was assumed", len(notes))
    files = {
        "Numbers": "measurements.csv",
        "means": "summary.csv",
        "pictures": "overlays/index.html",
        **({assumed: "notes.csv"} if len(shown_notes) < len(notes) else {}),
    }
    places = "; ".join(
        f"{tr(what)}: {out / name}"
        for what, name in files.items()
        if (out / name).exists()
    )
    console.print(f"\n{counts}. {places}")


def _main_results(means: Sequence[Line]) -> list[Line]:
    """The lines of the main quantities of each bench, rig and level of a condition."""
    kept = []
    for place in dict.fromkeys(
        (line.bench, line.rig, line.conditions) for line in means
    ):
        inside = {
            line.quantity: line
            for line in means
            if (line.bench, line.rig, line.conditions) == place
        }
        groups = MAIN_QUANTITIES.get(place[1], tuple((name,) for name in inside))
        found = [
            next((inside[name] for name in group if name in inside), None)
            for group in groups
        ]
        kept += [line for line in found if line is not None]
    return kept


def _show_rows(console: Terminal, table: pd.DataFrame) -> None:
    shown = Table(box=None, pad_edge=False)
    for heading in ("recording", "quantity", "value", "± sd", "unit"):
        right = heading in ("value", "± sd")
        shown.add_column(
            tr(heading), justify="right" if right else "left", no_wrap=True
        )
    shown.add_column(tr("quality"))
    for row in table.itertuples():
        value, sd = with_sd(row.value, row.sd)
        reason = f": {row.reason}" if row.reason else ""
        shown.add_row(
            row.recording,
            row.quantity,
            value,
            sd,
            "" if row.unit == "1" else row.unit,
            Text.assemble((tr(row.quality), COLOURS[row.quality]), plain(reason)),
        )
    if len(table):
        console.print(shown)


def _show_means(console: Terminal, lines: Sequence[Line]) -> None:
    """Print the means over repeats."""
    if not lines:
        return
    several = len({line.bench for line in lines}) > 1
    shown = Table(box=None, pad_edge=False)
    for heading in (
        "mean over repeats",
        "value (95 % interval)",
        "unit",
        "n",
        "sd between repeats",
        "sd of reading",
        "",
    ):
        words = heading in ("mean over repeats", "unit", "")
        side: Literal["left", "right"] = "left" if words else "right"
        shown.add_column(tr(heading), justify=side, no_wrap=bool(heading))
    for line in lines:
        bench = line.bench if several else ""
        name = " ".join(part for part in (bench, line.rig, line.quantity) if part)
        doubts = [
            text
            for count, text in (
                (line.doubtful, tr("{} of {} doubtful", line.doubtful, line.n)),
                (line.not_measured, tr("{} not measured", line.not_measured)),
                (line.all_equal, tr("one number {} times: it counts as one", line.n)),
                (
                    len(line.outliers),
                    tr("far from the others: {}", ", ".join(line.outliers)),
                ),
            )
            if count
        ]
        shown.add_row(
            f"{name}, {line.conditions}" if line.conditions else name,
            with_interval(line.mean, line.low, line.high),
            "" if line.unit == "1" else line.unit,
            str(line.n),
            *(
                "–" if math.isnan(v) else f"{v:.2g}"
                for v in (0.0 if line.all_equal else line.scatter, line.measuring)
            ),
            "; ".join(doubts),
        )
    console.print()
    console.print(shown)
