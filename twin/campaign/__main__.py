"""Run one failed job alone, in this process, with its whole traceback.

    python -m benchtwin.twin.campaign DIR/failed/KEY.json

A result goes into the store like any other. Exit code 0: it ran; 1: it failed again; 2:
that file does not name a job."""

import json
import sys
from pathlib import Path
from typing import Any

from benchtwin.bench.terminal import gated
from benchtwin.twin.campaign.attempt import Order, attempt, simulate_and_measure
from benchtwin.twin.campaign.results import FAILED
from benchtwin.twin.campaign.store import open_store


def main(arguments: list[str]) -> int:
    """Run the job in a file of a store alone; returns the exit code."""
    try:
        file = Path(*arguments).absolute()
        told = json.loads(file.read_text(encoding="utf8"))
        job = job_of(told["input"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        print(
            f"{__doc__}\n{' '.join(arguments) or 'no file given'}: {error}",
            file=sys.stderr,
        )
        return 2
    store = open_store(file.parent.parent)
    root = str(store.root)
    order = Order(root, store.id, simulate_and_measure, 1, store.now_s(), alone=True)
    reply = attempt(order, job, told.get("key", job.key))
    if reply.outcome is None:
        print(
            reply.stop or f"{job.key}: another process is running it", file=sys.stderr
        )
        return 1
    if reply.outcome.status == FAILED:
        print(json.loads(file.read_text(encoding="utf8"))["traceback"], file=sys.stderr)
        return 1
    for m in reply.outcome.measurements:
        print(
            f"{m.name} = {m.value:.6g} ± {m.sd:.2g} {m.unit} ({m.quality}) {m.reason}"
        )
    print(reply.outcome.reason or reply.outcome.folder)
    return 0


def job_of(told: dict) -> Any:
    """The job of an `input` as stored."""
    from benchtwin.twin import Parameters
    from benchtwin.twin.engine import Engine
    from benchtwin.twin.job import Job

    more = {
        "description": told["description"],
        "rng": tuple(told["rng"]),
        "rendered": told["rendered"],
    }
    parameters = Parameters(**told["parameters"])
    return Job(told["rig"], parameters, engine=Engine(**told.get("engine", {})), **more)


if __name__ == "__main__":
    with gated():
        sys.exit(main(sys.argv[1:]))
