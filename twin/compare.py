"""benchtwin compare-engines: the same piles, of the same law and packings, through our
engine and LAMMPS: rows of parameters, runs, differences paired by packing with 95 %
intervals (Student's t)."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from benchtwin.bench.outlets import csv_text
from benchtwin.bench.tells import by_surface
from benchtwin.bench.whole_file import write_whole
from benchtwin.twin.bench_folder import read_numbers
from benchtwin.twin.campaign import run_campaign
from benchtwin.twin.campaign.processes import workers_for
from benchtwin.twin.campaign.results import DONE
from benchtwin.twin.engine import LAMMPS, OURS, Engine
from benchtwin.twin.job import Job, assigned
from benchtwin.twin.parameters import Parameters
from benchtwin.twin.versions import versions

PARAMETERS = (
    "restitution",
    "static_friction",
    "rolling_friction",
    "seed_restitution",
    "seed_static_friction",
    "seed_rolling_friction",
)

LIMITS = (0.0, 5.0)  # of any of them

Row = dict[str, Any]


def rows_of(
    rows: str | Path | Sequence[Mapping[str, float]] | None,
) -> tuple[list[Row], list[str]]:
    """Values by name, a dict a row, and the columns of a file that are no parameters;
    [{}] (the defaults) without any. ValueError for what cannot be used."""
    if isinstance(rows, str | Path):
        return read_rows(Path(rows))
    return [_checked(row) for row in rows or ()] or [{}], []


def _checked(row: Mapping[str, float]) -> Row:
    """A row of parameters; ValueError for a name or a number that is none."""
    if wrong := [name for name in row if name not in PARAMETERS]:
        there = ", ".join(PARAMETERS)
        raise ValueError(f"rows: no parameter {wrong[0]!r}; there are {there}")
    numbers: Row = {name: float(value) for name, value in row.items()}
    Parameters(**numbers)  # so that it is refused now
    return numbers


def read_rows(file: Path) -> tuple[list[Row], list[str]]:
    """The rows of a CSV, and its columns that are no parameters. ValueError names a
    file, row and column that cannot be used."""
    if not file.is_file():
        raise ValueError(f"{file}: no such file")
    table = read_numbers(file, {}, dict.fromkeys(PARAMETERS, LIMITS))
    if table.empty:
        raise ValueError(f"{file}: no row, or no column of {', '.join(PARAMETERS)}")
    rows: list[Row] = [
        {str(name): float(value) for name, value in row.items()}
        for row in table.to_dict("records")
    ]
    for number, row in enumerate(rows, start=2):
        try:
            Parameters(**row)
        except ValueError as error:
            raise ValueError(
                f"{file}, row {number} (the heading is row 1): {error}"
            ) from None
    heading = pd.read_csv(file, nrows=0, sep=None, engine="python", comment="#")
    return rows, [str(name) for name in heading if name not in table]


def label(row: Row) -> str:
    """A row in a word or two: only what it states."""
    short = {name: "".join(word[0] for word in name.split("_")) for name in PARAMETERS}
    return (
        ", ".join(f"{short[name]} {value:g}" for name, value in row.items())
        or "the paper's optimum"
    )


WIDTH_MM, FILL_MM = 30.0, 60.0  # of the slice of a heap that is compared


def engines(
    ranks: int, workers: int | None, scheduler: str | None
) -> dict[str, Engine]:
    """Ours and LAMMPS by name; RuntimeError where LAMMPS has to run here and cannot."""
    theirs = Engine(LAMMPS, ranks)
    if scheduler is None:
        theirs.ready(workers)
    return {OURS: Engine(shared_law=True), LAMMPS: theirs}


def piles(
    rows: list[Row],
    engine: Engine,
    packings: int,
    rng: int,
    settings: Mapping[str, Any],
) -> list[Job]:
    """Row after row, packing after packing; a packing has the same random numbers in
    every row and engine. settings: as `twin.job.assigned` takes them."""
    made, pile = [], next(iter(by_surface().values()))
    section, _ = pile.simulated({}, WIDTH_MM, FILL_MM)
    for row in rows:
        parameters, description = assigned(
            Parameters(**row), {pile.name: section}, settings
        )
        made += [
            Job(pile.name, parameters, description, (rng, k), False, engine)
            for k in range(packings)
        ]
    return made


def converted(jobs: Mapping[str, list[Job]], rows: list[Row]) -> Iterator[str]:
    """What LAMMPS takes otherwise than the law is written."""
    yield from jobs[LAMMPS][0].converted()
    if len(rows) > 1:
        yield "these numbers are row 1's; other rows are converted in the same way"


def run(
    jobs: Mapping[str, list[Job]],
    rows: list[Row],
    out: Path,
    *,
    workers: int | None,
    scheduler: str | None,
    progress: Callable[[object], None],
) -> tuple[pd.DataFrame, list[str]]:
    """A line a run: row, parameters, packing, engine, quantities, seconds; and
    sentences on runs that failed."""
    found = run_campaign(
        [job for of_engine in jobs.values() for job in of_engine],
        out / "runs",
        progress=progress,
        scheduler=scheduler,
        workers=workers or workers_for(jobs[LAMMPS][0].engine.ranks),
    ).table
    place = [
        (row + 1, label(rows[row]), packing, engine)
        for engine, made in jobs.items()
        for row, packing in np.ndindex(len(rows), len(made) // len(rows))
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


QUANTITIES = {
    "repose_angle_deg": "angle of repose (°)",
    "centroid_angle_deg": "centroid's angle (°)",
    "crest_mm": "crest's height (mm)",
    "filled_mass_g": "mass filled in (g)",
    "retained_mass_g": "mass left (g)",
}
ALL = "all rows"
COLUMNS = [
    "row",
    "parameters",
    "quantity",
    "pairs",
    "ours",
    "lammps",
    "difference",
    "low",
    "high",
    "parts",
]


def differences(runs: pd.DataFrame) -> pd.DataFrame:
    """A line a row and quantity, then a line a quantity of all rows together.

    runs: row, parameters, packing, engine ("benchtwin", "lammps") and a column a
    quantity; one without a partner is left out. difference: mean of LAMMPS − ours over
    packings; low, high: its 95 % interval, NaN of fewer than two pairs; parts: whether
    that leaves out 0. All rows: packings are what repeats, so each counts once, by its
    mean over the rows that have it."""
    lines = []
    for quantity in QUANTITIES:
        wide = paired(runs, quantity)
        lines += [
            _line(str(row), parameters, quantity, pairs)
            for (row, parameters), pairs in wide.groupby(
                ["row", "parameters"], sort=True
            )
        ]
        if wide["row"].nunique() > 1:
            means = wide.groupby("packing")[["benchtwin", "lammps"]].mean()
            lines.append(_line(ALL, "", quantity, means))
    return pd.DataFrame(lines, columns=COLUMNS)


def paired(runs: pd.DataFrame, quantity: str) -> pd.DataFrame:
    """A line a pair of piles of one packing: row, parameters, packing, benchtwin,
    lammps."""
    wide = runs.pivot_table(
        index=["row", "parameters", "packing"],
        columns="engine",
        values=quantity,
        dropna=False,
    )
    return wide.reindex(columns=["benchtwin", "lammps"]).dropna().reset_index()


def _line(row: str, parameters: str, quantity: str, pairs: pd.DataFrame) -> tuple:
    apart = (pairs["lammps"] - pairs["benchtwin"]).to_numpy(float)
    n, mean = len(apart), float(apart.mean())
    if n > 1:
        half = float(stats.t.ppf(0.975, n - 1) * apart.std(ddof=1) / np.sqrt(n))
    else:
        half = float("nan")
    # False of a single pair, which tells nothing of scatter
    parts = bool(abs(mean) > half)
    return (
        row,
        parameters,
        quantity,
        n,
        pairs["benchtwin"].mean(),
        pairs["lammps"].mean(),
        mean,
        mean - half,
        mean + half,
        parts,
    )


def verdict(table: pd.DataFrame) -> str:
    """Where the engines part, and how often chance alone would make them seem to."""
    known = table[table["low"].notna()]
    if known.empty:
        return "a single packing tells nothing of scatter: give --packings 2 or more"
    single = known[known["row"] != ALL]
    by_row = single[single["parts"]]
    where = (
        ", ".join(
            f"row {r.row}: {QUANTITIES[r.quantity]} {r.difference:+.2g}"
            for r in by_row.itertuples()
        )
        or "nowhere"
    )
    chance = (
        f"{len(by_row)} of {len(single)} intervals leave out 0, by chance alone"
        f" {0.05 * len(single):.1g} would"
    )
    of_all = known[(known["row"] == ALL) & known["parts"]]
    text = f"the engines part: {where} ({chance})"
    if len(known) > len(single):
        together = (
            ", ".join(
                f"{QUANTITIES[r.quantity]} {r.difference:+.2g}"
                for r in of_all.itertuples()
            )
            or "nowhere"
        )
        text += f"; all rows together: {together}"
    return text


FILES = {"runs", "compared.csv", "runs.csv", "compared.html", "compared.json"}


def write(out: Path, table: pd.DataFrame, runs: pd.DataFrame, notes: list[str]) -> None:
    """Write what `differences` made of the runs, and the runs, into `out`."""
    write_whole(out / "compared.csv", csv_text(table))
    write_whole(out / "runs.csv", csv_text(runs))
    programs = versions() | {"lammps": Engine(LAMMPS).version}
    told = {"versions": programs, "notes": notes, "verdict": verdict(table)}
    (out / "compared.json").write_text(json.dumps(told, indent=1), encoding="utf8")
