"""Workers: a local cluster of processes, or whoever has joined a scheduler elsewhere;
from then on one code path."""

import contextlib
import logging
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from benchtwin.twin.campaign.store import CampaignStopped

PATIENCE_S = 30.0
CLOSING_S = 10.0  # dask would wait without end for a worker that does not answer


@dataclass(frozen=True)
class Connection:
    """client: of dask.distributed; cores: over which few jobs may spread."""

    client: Any
    cores: int

    def slots(self) -> int:
        """How many jobs run at a time."""
        return sum(self.client.nthreads().values())


@contextmanager
def connected(
    jobs: int, workers: int | None, scheduler: str | None
) -> Iterator[Connection]:
    """Workers for that many jobs: local processes of one thread each, or those of a
    scheduler ("tcp://host:port").

    CampaignStopped when the scheduler does not answer or no worker joins it within
    PATIENCE_S."""
    from distributed import Client

    if scheduler is not None:
        with _joined(scheduler) as client:
            yield Connection(client, sum(client.nthreads().values()))
        return
    cores = _cores()
    with (
        _local(min(workers or cores, jobs)) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        try:
            yield Connection(client, cores)
        finally:
            # all is stored, or given up: closing politely would wait for jobs of
            # minutes
            _kill(cluster)


def _joined(scheduler: str) -> Any:
    from distributed import Client

    try:
        client = Client(scheduler, timeout=PATIENCE_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise CampaignStopped(
            f"scheduler {scheduler}: does not answer ({error}); expected"
            " tcp://host:port"
        ) from error
    try:
        client.wait_for_workers(1, timeout=PATIENCE_S)
    except TimeoutError as error:
        client.close()
        why = (
            f"no worker has joined within {PATIENCE_S:g} s; start one by  dask worker"
            f" {scheduler}"
        )
        raise CampaignStopped(f"scheduler {scheduler}: {why}") from error
    return client


@contextmanager
def _local(workers: int) -> Iterator[Any]:
    from distributed import LocalCluster

    cluster = LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        processes=True,
        protocol="tcp",
        # None takes port 8787 all the same, and warns when another campaign has it
        dashboard_address="127.0.0.1:0",
        # dask's limit is about data between tasks, of which there is none; it would
        # only pause our jobs
        memory_limit=0,
        silence_logs=logging.CRITICAL,
    )
    try:
        yield cluster
    finally:
        with contextlib.suppress(TimeoutError):
            cluster.close(timeout=CLOSING_S)


def workers_for(ranks: int) -> int:
    """Workers of this machine whose jobs take so many cores each."""
    return max(_cores() // ranks, 1)


def _kill(cluster) -> None:
    """End the worker processes at once; what they were writing is swept afterwards."""
    for nanny in cluster.workers.values():
        nanny.close_gracefully()  # says only that it is not to start another
        if nanny.pid:
            with contextlib.suppress(ProcessLookupError):
                os.kill(nanny.pid, signal.SIGKILL)


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
