"""The piles of two engines that are compared: the same rows of parameters, the same
packings."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchtwin.bench.tells import by_surface
from benchtwin.twin.campaign import run_campaign
from benchtwin.twin.campaign.cluster import workers_for
from benchtwin.twin.campaign.results import DONE
from benchtwin.twin.compare.differences import QUANTITIES
from benchtwin.twin.compare.rows import Row, label
from benchtwin.twin.engine import LAMMPS, OURS, Engine
from benchtwin.twin.job import Job, assigned
from benchtwin.twin.parameters import Parameters

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
