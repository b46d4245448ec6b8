"""Who computes: processes of this user here, which speak through pipes (no port is
open, and nobody else can hand them work), or whoever has joined a dask scheduler
elsewhere; from then on one code path, that of `concurrent.futures`."""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import (
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.process import BaseProcess
from typing import Any

from benchtwin.sim.lammps.program import cores_here
from benchtwin.twin.campaign.store import CampaignStopped

LIVES = 4  # processes that one job may cost before it is given up


class WorkerDied(RuntimeError):
    """Every process that a job was given to has died."""


class Processes(Executor):
    """So many processes, each with a thread here that hands it one job after the other.
    A job whose process dies begins again in another: a pool of several would end with
    the first of them."""

    def __init__(self, count: int) -> None:
        self._threads = ThreadPoolExecutor(count, "campaign", _hide_interrupts)
        self._mine = threading.local()  # each thread's pool of one process
        self._started: set[BaseProcess] = set()
        self._starting = threading.Lock()
        self._closed = False

    def submit(
        self, work: Callable[..., Any], /, *args: Any, **kwargs: Any
    ) -> Future[Any]:
        """Have `work`, importable by its name, called in one of the processes."""
        return self._threads.submit(self._done, work, args, kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = True) -> None:
        """End the processes at once, whatever they are doing."""
        with self._starting:
            self._closed = True
        self._threads.shutdown(wait=False, cancel_futures=cancel_futures)
        for process in self._started:
            process.kill()
        for process in self._started if wait else ():
            process.join()
        self._threads.shutdown(wait)

    def _done(self, work: Callable[..., Any], args: tuple, kwargs: dict) -> Any:
        for _ in range(LIVES):
            pool = getattr(self._mine, "pool", None) or self._start()
            try:
                return pool.submit(work, *args, **kwargs).result()
            except BrokenProcessPool:
                pool.shutdown()
                self._mine.pool = None
        raise WorkerDied(
            "every worker process that ran it died (memory, or a crash in compiled"
            " code)"
        )

    def _start(self) -> ProcessPoolExecutor:
        """A process for this thread."""
        with self._starting:
            if self._closed:
                raise WorkerDied("the campaign has ended")
            before = set(active_children())
            pool = ProcessPoolExecutor(1, get_context("spawn"), _begin)
            pool.submit(os.getpid)  # starts it
            self._started |= set(active_children()) - before
        self._mine.pool = pool
        return pool


def _hide_interrupts() -> None:
    """Ctrl-C in a terminal reaches the whole group; until it is ready, a process that
    this thread starts would answer with a traceback of its own."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


def _begin() -> None:
    """A worker's beginning: one BLAS thread, deaf to Ctrl-C, gone with who started
    it."""
    import scipy.linalg  # noqa: F401  # only a library that is loaded is limited
    from threadpoolctl import threadpool_limits

    threadpool_limits(1, user_api="blas")
    signal.signal(signal.SIGINT, lambda *_: None)  # unlike SIG_IGN, not handed on
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


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
