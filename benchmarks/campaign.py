"""Campaigns: two workers beside one on the same drops, what a job costs besides its
work, and looking up 10,000 finished jobs.

    python benchmarks/campaign.py [--drops 24] [--tiny 500]

One and two workers are timed in turns, from the first outcome on, so that starting
processes and compiling are not counted (both stand in a column of their own). Drops can
run 1.8 times as quick only where two cores are free: the load average is printed, and
jobs that only sleep show what the campaign itself costs."""

import argparse
import os
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from benchtwin.twin.campaign import (
    Measured,
    Measurement,
    read_campaign,
    stream_campaign,
)
from benchtwin.twin.campaign.attempt import simulate_and_measure
from benchtwin.twin.campaign.store import open_store


@dataclass(frozen=True)
class Nothing:
    """A job without work."""

    number: int

    @property
    def key(self) -> str:
        return f"{self.number:016x}"

    @property
    def input(self) -> dict:
        return {"rig": "nothing", "number": self.number}


def nothing(job, folder: Path, threads: int) -> Measured:
    folder.mkdir()
    return Measured(
        tuple(Measurement(f"quantity_{k}", 1.0, 0.1, "mm") for k in range(4)),
        {"truth_mm": 1.0},
    )


def asleep(job, folder: Path, threads: int) -> Measured:
    """A job that needs no core: what the ratio would be if cores were free."""
    time.sleep(0.2)
    return nothing(job, folder, threads)


def timed(jobs: list, work, workers: int) -> tuple[float, float, float]:
    """Seconds to the first outcome, and from there on a job; how many seconds the jobs'
    own work took, each."""
    with tempfile.TemporaryDirectory() as store:
        begin, times, own = time.perf_counter(), [], []
        for outcome in stream_campaign(
            jobs, Path(store) / "store", workers=workers, work=work
        ):
            times.append(time.perf_counter())
            own.append(outcome.seconds)
    warm = 2 * workers  # every worker has had its first
    return (
        times[0] - begin,
        (times[-1] - times[warm - 1]) / (len(times) - warm),
        median(own),
    )


def side_by_side(name: str, jobs: list, work, rounds: int) -> None:
    print(
        f"\n{name}, {len(jobs)} jobs, median of {rounds}; load {os.getloadavg()[0]:.1f}"
        f" on {os.cpu_count()} cores"
    )
    print(
        f"{'workers':>8} {'first outcome s':>16} {'then s a job':>13}"
        f" {'own s a job':>12}"
    )
    taken: dict[int, list] = {1: [], 2: []}
    for _ in range(rounds):
        for workers in taken:
            taken[workers].append(timed(jobs, work, workers))
    for workers, rows in taken.items():
        first, each, own = (median(column) for column in zip(*rows))
        print(f"{workers:>8} {first:>16.1f} {each:>13.4f} {own:>12.4f}")
    ratio = median(a[1] / b[1] for a, b in zip(taken[1], taken[2]))
    print(f"two workers are {ratio:.2f} times as quick as one")


def lookup(count: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        store = open_store(Path(folder))
        jobs = [Nothing(n) for n in range(count)]
        whole = nothing(jobs[0], Path(folder) / "first", 1)
        for job in jobs:
            with store.part(job.key) as part:
                store.put(Path(part) / job.key, job, whole, 1.0, {})
        begin = time.perf_counter()
        results = read_campaign(jobs, folder)
        found = time.perf_counter() - begin
        table = results.table
        print(
            f"\n{len(table)} finished jobs: found in {found:.2f} s, as a table after"
            f" {time.perf_counter() - begin:.2f} s"
        )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--drops", type=int, default=24)
    parser.add_argument("--tiny", type=int, default=500)
    parser.add_argument("--finished", type=int, default=10_000)
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    if arguments.drops < 5:
        parser.error(
            f"--drops {arguments.drops}: at least 5, as the first two of each worker"
            " only warm it"
        )
    lookup(arguments.finished)
    side_by_side(
        "nothing to do",
        [Nothing(n) for n in range(max(arguments.tiny, 20))],
        nothing,
        arguments.rounds,
    )
    side_by_side(
        "0.2 s asleep",
        [Nothing(n) for n in range(max(arguments.tiny // 10, 20))],
        asleep,
        arguments.rounds,
    )
    from benchtwin.twin import Parameters
    from benchtwin.twin.job import Job

    any_way = {"drop": {"orientation": "any"}}
    drops = [
        Job("drop", Parameters(), any_way, rng=(1, n), rendered=False)
        for n in range(arguments.drops)
    ]
    side_by_side(
        "drops without pictures", drops, simulate_and_measure, arguments.rounds
    )


if __name__ == "__main__":
    main()
