"""A comparison of two engines written into its folder, and in the terminal."""

import json
from collections.abc import Iterable
from pathlib import Path

import pandas as pd
from rich.table import Table

from benchtwin.bench.outlets import csv_text
from benchtwin.bench.terminal import Terminal
from benchtwin.bench.whole_file import write_whole
from benchtwin.twin.command import print_lines
from benchtwin.twin.compare.differences import QUANTITIES, verdict
from benchtwin.twin.engine import LAMMPS, Engine
from benchtwin.twin.engine import OURS as OUR_ENGINE
from benchtwin.twin.versions import versions

OURS = {"runs", "compared.csv", "runs.csv", "compared.html", "compared.json"}


def write(out: Path, table: pd.DataFrame, runs: pd.DataFrame, notes: list[str]) -> None:
    """Write what `differences` made of the runs, and the runs, into `out`."""
    write_whole(out / "compared.csv", csv_text(table))
    write_whole(out / "runs.csv", csv_text(runs))
    programs = versions() | {"lammps": Engine(LAMMPS).version}
    told = {"versions": programs, "notes": notes, "verdict": verdict(table)}
    (out / "compared.json").write_text(json.dumps(told, indent=1), encoding="utf8")


def show(
    table: pd.DataFrame, runs: pd.DataFrame, failed: Iterable[str], out: Path
) -> None:
    """The differences in the terminal, and where to look."""
    console = Terminal()
    shown = Table(box=None, pad_edge=False)
    for heading in (
        "row",
        "quantity",
        "pairs",
        "ours",
        "LAMMPS",
        "difference (95 % interval)",
        "",
    ):
        shown.add_column(
            heading, justify="left" if heading in ("row", "quantity", "") else "right"
        )
    for r in table.itertuples():
        if r.low == r.low:
            apart = f"{r.difference:+.2f} ({r.low:+.2f} to {r.high:+.2f})"
        else:
            apart = f"{r.difference:+.2f}"
        numbers = (
            str(r.pairs),
            f"{r.ours:.2f}",
            f"{r.lammps:.2f}",
            apart,
            "apart" if r.parts else "",
        )
        shown.add_row(f"{r.row} {r.parameters}", QUANTITIES[str(r.quantity)], *numbers)
    console.print(shown)
    took = runs.groupby("engine")["seconds"].mean()
    seconds = f"seconds a pile: ours {took[OUR_ENGINE]:.0f}, LAMMPS {took[LAMMPS]:.0f}"
    written = f"picture: {out / 'compared.html'}; table: {out / 'compared.csv'}"
    print_lines(console, *failed, verdict(table), seconds, written)
