"""Command-line front end of `benchtwin compare-engines`: options, progress, printed
table, exit code."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd
from rich.table import Table

from benchtwin.bench.outlets import csv_text
from benchtwin.bench.tells import by_surface
from benchtwin.bench.terminal import Terminal
from benchtwin.bench.whole_file import write_whole
from benchtwin.twin.campaign import run_campaign
from benchtwin.twin.campaign.cluster import workers_for
from benchtwin.twin.campaign.results import DONE
from benchtwin.twin.command import (
    CampaignOptions,
    check_out,
    exit_code,
    print_lines,
    progress_line,
)
from benchtwin.twin.compare.differences import QUANTITIES, differences, verdict
from benchtwin.twin.compare.picture import page
from benchtwin.twin.compare.rows import label, read_rows
from benchtwin.twin.engine import LAMMPS, OURS, Engine
from benchtwin.twin.job import Job, assigned
from benchtwin.twin.parameters import Parameters
from benchtwin.twin.versions import versions

FINISHED = 0
WIDTH_MM, FILL_MM = 30.0, 60.0  # of the slice of a heap that is compared
OURS_IN_OUT = {"runs", "compared.csv", "runs.csv", "compared.html", "compared.json"}


@dataclass(frozen=True)
class Compared(CampaignOptions):
    """What was typed. rows: a CSV; packings: piles of each row; settings: {key: value}
    as `twin.job.assigned` takes them."""

    out: Path
    rows: Path | None = None
    packings: int = 4
    settings: Mapping[str, Any] = field(default_factory=dict)
    ranks: int = 1


def compare_command(asked: Compared) -> int:
    """Run the piles of both engines, or find them in OUT/runs; write and print how they
    differ. Returns the exit code."""
    misuses = (ValueError, FileExistsError)
    return exit_code(
        "compare-engines", asked.out, lambda: _compare(asked), misuses=misuses
    )


@dataclass(frozen=True, eq=False)
class Comparison:
    """table: as `differences` makes it; runs: a line a run; notes: what was converted
    or left out; failed: sentences on runs that failed."""

    table: pd.DataFrame
    runs: pd.DataFrame
    notes: tuple[str, ...]
    failed: tuple[str, ...]


def _compare(asked: Compared) -> int:
    rows, ignored = read_rows(asked.rows)

    def say(note: str) -> None:
        if not asked.quiet:
            print(note)

    for name in ignored:
        say(f"{name}: no parameter, not used")
    found = compare_into(asked, rows, say)
    if not asked.quiet:
        _show(found.table, found.runs, list(found.failed), asked.out)
    return FINISHED


def compare_into(
    asked: Compared,
    rows: list[dict[str, Any]],
    say: Callable[[str], None] = lambda note: None,
) -> Comparison:
    """Run the piles of both engines at `rows` of parameters, and write how they differ
    into `asked.out`; say: told each note before anything runs.

    Raises FileExistsError where `out` holds something else; ValueError for what cannot
    be simulated; RuntimeError where LAMMPS is not there, or nothing was measured."""
    check_out(asked.out, OURS_IN_OUT, "comparison")
    jobs = {
        name: _jobs(asked, rows, engine) for name, engine in _engines(asked).items()
    }
    notes = list(jobs[LAMMPS][0].converted())
    if len(rows) > 1:
        notes.append(
            "these numbers are row 1's; other rows are converted in the same way"
        )
    for note in notes:
        say(note)
    runs, failed = _runs(asked, rows, jobs)
    table = differences(runs)
    if table.empty:
        why = failed[0] if failed else "none was run"
        raise RuntimeError(f"no pile of both engines was measured: {why}")
    _write(asked.out, table, runs, [*notes, *failed])
    return Comparison(table, runs, tuple(notes), tuple(failed))


def _engines(asked: Compared) -> dict[str, Engine]:
    if not 1 <= asked.packings <= 1000:
        raise ValueError(f"--packings {asked.packings}: 1 to 1000")
    theirs = Engine(LAMMPS, asked.ranks)
    if asked.scheduler is None:
        theirs.ready(asked.workers)
    return {OURS: Engine(shared_law=True), LAMMPS: theirs}


def _jobs(asked: Compared, rows: list[dict[str, Any]], engine: Engine) -> list[Job]:
    """Row after row, packing after packing; a packing has the same random numbers in
    every row and engine."""
    made, pile = [], next(iter(by_surface().values()))
    section, _ = pile.simulated({}, WIDTH_MM, FILL_MM)
    for row in rows:
        parameters, description = assigned(
            Parameters(**row), {pile.name: section}, asked.settings
        )
        made += [
            Job(pile.name, parameters, description, (asked.rng, k), False, engine)
            for k in range(asked.packings)
        ]
    return made


def _runs(
    asked: Compared, rows: list[dict[str, Any]], jobs: dict[str, list[Job]]
) -> tuple[pd.DataFrame, list[str]]:
    """A line a run: row, parameters, packing, engine, quantities, seconds; and
    sentences on runs that failed."""
    with progress_line(asked.quiet) as show:
        found = run_campaign(
            [job for of_engine in jobs.values() for job in of_engine],
            asked.out / "runs",
            progress=show,
            scheduler=asked.scheduler,
            workers=asked.workers or workers_for(asked.ranks),
        ).table
    place = [
        (n + 1, label(row), k, engine)
        for engine in jobs
        for n, row in enumerate(rows)
        for k in range(asked.packings)
    ]
    runs = pd.DataFrame(place, columns=["row", "parameters", "packing", "engine"])
    runs["status"] = found["status"]
    for name in (*QUANTITIES, "lies_still", "photo_s"):
        runs[name] = (
            pd.to_numeric(found[f"true_{name}"])
            if f"true_{name}" in found
            else float("nan")
        )
    for name in ("seconds", "reason", "rerun", "key"):
        runs[name] = found[name]
    failed = [
        f"{r.engine}, row {r.row}, packing {r.packing}: {r.reason or r.status}; run it"
        f" alone: {r.rerun}"
        for r in runs[runs["status"] != DONE].itertuples()
    ]
    return runs, failed


def _write(
    out: Path, table: pd.DataFrame, runs: pd.DataFrame, notes: list[str]
) -> None:
    write_whole(out / "compared.csv", csv_text(table))
    write_whole(out / "runs.csv", csv_text(runs))
    (out / "compared.html").write_text(
        page(table, runs, verdict(table), notes), encoding="utf8"
    )
    programs = versions() | {"lammps": Engine(LAMMPS).version}
    told = {"versions": programs, "notes": notes, "verdict": verdict(table)}
    (out / "compared.json").write_text(json.dumps(told, indent=1), encoding="utf8")


def _show(
    table: pd.DataFrame, runs: pd.DataFrame, failed: list[str], out: Path
) -> None:
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
    seconds = f"seconds a pile: ours {took[OURS]:.0f}, LAMMPS {took[LAMMPS]:.0f}"
    written = f"picture: {out / 'compared.html'}; table: {out / 'compared.csv'}"
    print_lines(console, *failed, verdict(table), seconds, written)
