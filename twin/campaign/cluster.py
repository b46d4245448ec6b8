"""Who computes: processes of this user here, or whoever has joined a dask scheduler
elsewhere; from then on one code path, that of `concurrent.futures`."""

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass

from benchtwin.sim.lammps.program import cores_here
from benchtwin.twin.campaign.processes import Processes
from benchtwin.twin.campaign.store import CampaignStopped

PATIENCE_S = 30.0


@dataclass(frozen=True)
class Workers:
    """executor: takes jobs; cores: over which few jobs may spread; slots: how many jobs
    run at a time."""

    executor: Executor
    cores: int
    slots: Callable[[], int]


@contextmanager
def local(workers: int) -> Iterator[Workers]:
    """Processes of one thread each, started as jobs come, until the block ends: at
    once, for all that counts is stored."""
    processes = Processes(workers)
    try:
        yield Workers(processes, cores_here(), lambda: workers)
    finally:
        processes.shutdown()


@contextmanager
def joined(scheduler: str) -> Iterator[Workers]:
    """The workers of a dask scheduler, "tcp://host:port", or "tls://host:port" with the
    certificates that dask's own settings name.

    CampaignStopped when it does not answer or no worker joins it within PATIENCE_S."""
    from distributed import Client

    try:
        client = Client(scheduler, timeout=PATIENCE_S, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:  # TypeError: no certificates
        raise CampaignStopped(
            f"scheduler {scheduler}: does not answer ({error}); expected"
            " tcp://host:port"
        ) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE_S)
        except TimeoutError as error:
            why = (
                f"no worker has joined within {PATIENCE_S:g} s; start one by  dask"
                f" worker {scheduler}"
            )
            raise CampaignStopped(f"scheduler {scheduler}: {why}") from error

        def slots() -> int:
            try:
                return sum(client.nthreads().values())
            except OSError as error:
                raise CampaignStopped(
                    f"the scheduler {scheduler} is gone; what is finished is kept"
                ) from error

        yield Workers(client.get_executor(pure=False), slots(), slots)


def workers_for(ranks: int) -> int:
    """Workers of this machine whose jobs take so many cores each."""
    return max(cores_here() // ranks, 1)
