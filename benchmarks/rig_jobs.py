"""Many simulated runs for a study: each once, on all cores, kept by key in a folder, so
that a study that is stopped goes on."""

import json
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

from benchtwin.twin import Parameters
from benchtwin.twin.job import Job
from benchtwin.twin.run import RECORD

STORE = Path("benchmark-runs")
WORKERS = int(os.environ.get("WORKERS", os.cpu_count() or 1))
SLAB = {
    "box_mm": [105, 30, 200],
    "gate_mm": [30, 200],
    "plate_mm": [200, 30],
    "fill_height_mm": 60,
    "slab": True,
}


def pile(settings: dict, packing: int, description: dict | None = None) -> Job:
    """A reduced pile: a 30 mm slab between smooth sides, 60 mm high, of one packing."""
    return Job(
        "pile",
        Parameters(**settings),
        {"pile": {**SLAB, **(description or {})}},
        (9, packing),
        rendered=False,
    )


def truths(jobs: list[Job], workers: int = WORKERS) -> list[dict]:
    """What the simulation knows of each job, in order; {"failed": reason} where one
    stopped."""
    STORE.mkdir(exist_ok=True)
    todo = list({job.key: job for job in jobs if not _file(job).exists()}.values())
    begin = time.time()
    with ProcessPoolExecutor(workers) as pool:
        running = [pool.submit(_run, job) for job in todo]
        for n, done in enumerate(as_completed(running), start=1):
            done.result()
            left = (time.time() - begin) / n * (len(todo) - n)
            print(
                f"\r{n} of {len(todo)} runs, {left / 60:.0f} min left ",
                end="",
                file=sys.stderr,
                flush=True,
            )
    if todo:
        print(file=sys.stderr)
    return [json.loads(_file(job).read_text()) for job in jobs]


def _file(job: Job) -> Path:
    return STORE / f"{job.key}.json"


def _run(job: Job) -> None:
    """Run one job, keep its truth and processor time."""
    out, begin = STORE / job.key, time.process_time()
    try:
        job.run(out, threads=1)
        truth = json.loads((out / RECORD).read_text())["truth"]
    except (ValueError, RuntimeError) as error:
        truth = {"failed": str(error)}
    part = _file(job).with_suffix(".part")
    part.write_text(json.dumps(truth | {"processor_s": time.process_time() - begin}))
    part.replace(_file(job))
