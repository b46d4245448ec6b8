"""Command-line front end of `benchtwin compare-engines`: options, progress, printed table, exit code."""

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from twin.campaign import run_campaign
from twin.campaign.cluster import workers_for
from twin.campaign.results import DONE
from twin.compare.differences import QUANTITIES, differences, verdict
from twin.compare.picture import page
from twin.compare.rows import label, read_rows
from twin.engine import LAMMPS, OURS, Engine
from twin.job import Job, assigned
from twin.parameters import Parameters
from twin.versions import versions

FINISHED, STOPPED, MISUSED = 0, 1, 2
SLICE = {"box_mm": [105.0, 30.0, 200.0], "gate_mm": [30.0, 200.0], "plate_mm": [200.0, 30.0], "fill_height_mm": 60.0, "slab": True}
OURS_IN_OUT = {"runs", "compared.csv", "runs.csv", "compared.html", "compared.json"}


@dataclass(frozen=True)
class Compared:
    """What was typed. rows: a CSV; packings: piles of each row; settings: "KEY=VALUE" as `benchtwin simulate --set` takes them."""

    out: Path
    rows: Path | None = None
    packings: int = 4
    rng: int = 1
    settings: tuple[str, ...] = ()
    ranks: int = 1
    workers: int | None = None
    scheduler: str | None = None
    quiet: bool = False


def compare_command(asked: Compared) -> int:
    """Run the piles of both engines, or find them in OUT/runs; write and print how they differ. Returns the exit code."""
    try:
        _check_out(asked.out)
        rows, ignored = read_rows(asked.rows)
        todo = {name: _jobs(asked, rows, engine) for name, engine in _engines(asked).items()}
        converted = todo[LAMMPS][0].converted()
        said = [*(f"{name}: no parameter, not used" for name in ignored), *converted]
        said += ["these numbers are row 1's; other rows are converted in the same way"] if len(rows) > 1 else []
        for line in [] if asked.quiet else said:
            print(line)
        runs, failed = _runs(asked, rows, todo)
        table = differences(runs)
        if table.empty:
            raise RuntimeError(f"no pile of both engines was measured: {failed[0] if failed else 'none was run'}")
        _write(asked.out, table, runs, [*said, *failed])
    except KeyboardInterrupt:
        return _say(f"stopped; the same command goes on where it stopped ({asked.out})", STOPPED)
    except (ValueError, FileExistsError) as error:
        return _say(error, MISUSED)
    except RuntimeError as error:  # LAMMPS is not there, the campaign stopped
        return _say(error, STOPPED)
    except OSError as error:
        return _say(f"{error.filename or asked.out}: {error.strerror or error}", STOPPED)
    if not asked.quiet:
        _show(table, runs, failed, asked.out)
    return FINISHED


def _say(error: object, code: int) -> int:
    print(f"benchtwin compare-engines: {error}", file=sys.stderr)
    return code


def _check_out(out: Path) -> None:
    if out.exists() and not out.is_dir():
        raise FileExistsError(f"{out}: is a file; --out names a folder")
    others = {p.name for p in out.iterdir() if not p.name.startswith(".")} - OURS_IN_OUT if out.is_dir() else set()
    if others:
        raise FileExistsError(f"{out}: holds {sorted(others)[0]}, which no comparison wrote; choose another --out")


def _engines(asked: Compared) -> dict[str, Engine]:
    if not 1 <= asked.packings <= 1000:
        raise ValueError(f"--packings {asked.packings}: 1 to 1000")
    theirs = Engine(LAMMPS, asked.ranks)
    if asked.scheduler is None:
        theirs.ready(asked.workers)
    return {OURS: Engine(shared_law=True), LAMMPS: theirs}


def _jobs(asked: Compared, rows: list[dict[str, Any]], engine: Engine) -> list[Job]:
    """Row after row, packing after packing; a packing has the same random numbers in every row and engine."""
    made = []
    for row in rows:
        parameters, description = assigned(Parameters(**row), {"pile": dict(SLICE)}, list(asked.settings))
        made += [Job("pile", parameters, description, (asked.rng, k), False, engine) for k in range(asked.packings)]
    return made


def _runs(asked: Compared, rows: list[dict[str, Any]], todo: dict[str, list[Job]]) -> tuple[pd.DataFrame, list[str]]:
    """A line a run: row, parameters, packing, engine, quantities, seconds; and sentences on runs that failed."""
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), disable=asked.quiet, transient=True) as progress:
        task = progress.add_task("", total=None)
        found = run_campaign(
            [job for jobs in todo.values() for job in jobs], asked.out / "runs", scheduler=asked.scheduler,
            workers=asked.workers or workers_for(asked.ranks),
            progress=lambda told: progress.update(task, description=str(told)),
        ).table  # fmt: skip
    place = [(n + 1, label(row), k, engine) for engine in todo for n, row in enumerate(rows) for k in range(asked.packings)]
    runs = pd.DataFrame(place, columns=["row", "parameters", "packing", "engine"])
    runs["status"] = found["status"]
    for name in (*QUANTITIES, "lies_still", "photo_s"):
        runs[name] = pd.to_numeric(found[f"true_{name}"]) if f"true_{name}" in found else float("nan")
    for name in ("seconds", "reason", "rerun", "key"):
        runs[name] = found[name]
    failed = [
        f"{r.engine}, row {r.row}, packing {r.packing}: {r.reason or r.status}; run it alone: {r.rerun}"
        for r in runs[runs["status"] != DONE].itertuples()
    ]
    return runs, failed


def _write(out: Path, table: pd.DataFrame, runs: pd.DataFrame, said: list[str]) -> None:
    table.to_csv(out / "compared.csv", index=False, float_format="%.6g")
    runs.to_csv(out / "runs.csv", index=False, float_format="%.6g")
    (out / "compared.html").write_text(page(table, runs, verdict(table), said), encoding="utf8")
    told = {"versions": versions() | {"lammps": Engine(LAMMPS).version}, "said": said, "verdict": verdict(table)}
    (out / "compared.json").write_text(json.dumps(told, indent=1), encoding="utf8")


def _show(table: pd.DataFrame, runs: pd.DataFrame, failed: list[str], out: Path) -> None:
    console = Console(width=None if sys.stdout.isatty() else 160, highlight=False)
    shown = Table(box=None, pad_edge=False)
    for heading in ("row", "quantity", "pairs", "ours", "LAMMPS", "difference (95 % interval)", ""):
        shown.add_column(heading, justify="left" if heading in ("row", "quantity", "") else "right")
    for r in table.itertuples():
        apart = f"{r.difference:+.2f} ({r.low:+.2f} to {r.high:+.2f})" if r.low == r.low else f"{r.difference:+.2f}"
        numbers = (str(r.pairs), f"{r.ours:.2f}", f"{r.lammps:.2f}", apart, "apart" if r.parts else "")
        shown.add_row(f"{r.row} {r.parameters}", QUANTITIES[str(r.quantity)], *numbers)
    console.print(shown)
    took = runs.groupby("engine")["seconds"].mean()
    seconds = f"seconds a pile: ours {took[OURS]:.0f}, LAMMPS {took[LAMMPS]:.0f}"
    for line in (*failed, verdict(table), seconds, f"picture: {out / 'compared.html'}; table: {out / 'compared.csv'}"):
        console.print(line, markup=False, soft_wrap=True)
