"""run_campaign: jobs in, a table out. What is stored is not computed again; what is
interrupted goes on at the next call."""

import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Future
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from filelock import Timeout

from benchtwin.sim.lammps.program import cores_here
from benchtwin.twin.campaign.attempt import (
    Order,
    Reply,
    Work,
    attempt,
    recorded,
    simulate_and_measure,
)
from benchtwin.twin.campaign.interrupt import kept_interrupt
from benchtwin.twin.campaign.processes import Workers, joined, local
from benchtwin.twin.campaign.progress import Progress, Tally
from benchtwin.twin.campaign.results import DONE, Outcome, Results, in_order
from benchtwin.twin.campaign.store import CampaignStopped, Store, open_store

LOOK_S = 0.5  # how often progress is told


def run_campaign(jobs: Sequence, store: str | Path, **options: Any) -> Results:
    """Run all jobs, or find them in the store; returns a row a job, in their order.
    Options and errors: `stream_campaign`."""
    outcomes = {
        outcome.key: outcome for outcome in stream_campaign(jobs, store, **options)
    }
    return in_order([job.key for job in jobs], outcomes)


def read_campaign(jobs: Sequence, store: str | Path) -> Results:
    """What the store holds of these jobs now, while others may be computing;
    CampaignStopped when there is no store."""
    keys = [job.key for job in jobs]
    if not (Path(store) / "campaign.json").is_file():
        return in_order(keys, {})
    return in_order(keys, _opened(store).find(keys))


def stream_campaign(
    jobs: Sequence,
    store: str | Path,
    *,
    workers: int | Workers | None = None,
    scheduler: str | None = None,
    progress: Callable[[Progress], None] = lambda progress: None,
    work: Work = simulate_and_measure,
) -> Iterator[Outcome]:
    """Outcomes as they come, one a key: first what the store has, then what is
    computed.

    workers: local processes, None for one a core; or Workers that stay for other
    campaigns, too. scheduler: "tcp://host:port" of a dask scheduler whose workers see
    the store, in place of local ones. progress: called with every batch of
    outcomes, and every LOOK_S. work(job, folder, threads): what a job does,
    importable by the workers. Raises CampaignStopped when the store cannot be written
    or the workers are gone, ValueError for an unknown option."""
    if isinstance(workers, int) and workers < 1:
        raise ValueError(f"workers = {workers}: at least 1")
    opened = _opened(store)
    by_key = {job.key: job for job in jobs}
    order = Order(str(opened.root), opened.id, work, 1, _now(opened))
    tally = Tally({key: _kind(job) for key, job in by_key.items()})
    for key, outcome in opened.find(by_key).items():
        if outcome.status == DONE or recorded(opened, order, key):
            tally.add(outcome, found=True)
            yield outcome
    progress(tally.progress(0, 0))
    opened.sweep()
    todo = [by_key[key] for key in by_key if key in tally.open]
    if not todo:
        return
    try:
        with (
            kept_interrupt() as check,
            _workers(len(todo), workers, scheduler) as found,
        ):
            run = _Run(opened, order, found, tally, progress, check)
            try:
                yield from run.outcomes(todo)
            finally:
                run.cancel()
    finally:
        opened.sweep()


def _workers(
    jobs: int, workers: int | Workers | None, scheduler: str | None
) -> AbstractContextManager[Workers]:
    if scheduler is not None:
        return joined(scheduler)
    if isinstance(workers, Workers):
        return nullcontext(workers)
    return local(min(workers or cores_here(), jobs))


class _Run:
    """The jobs that are with the workers, and those that another campaign has."""

    def __init__(
        self,
        store: Store,
        order: Order,
        workers: Workers,
        tally: Tally,
        progress: Callable,
        check: Callable[[], None],
    ) -> None:
        self.store, self.order, self.workers = store, order, workers
        self.tally, self.progress, self.check_interrupt = tally, progress, check
        self.slots = workers.slots()
        self.looked = time.monotonic()
        self.keys: dict[Future, str] = {}  # of jobs that are with the workers
        self.ended: SimpleQueue[Future] = SimpleQueue()
        self.elsewhere: set[str] = set()

    def outcomes(self, todo: list) -> Iterator[Outcome]:
        """Outcomes as they come, until every job has one."""
        self.order = replace(
            self.order, threads=threads_each(len(todo), self.workers.cores)
        )
        self.jobs = {job.key: job for job in todo}
        self.submit(list(self.jobs))
        while self.tally.open:
            self.check_interrupt()
            yield from self.settle(self.replies())
            if self.elsewhere and not self.keys:  # nothing else is left to do
                self.order = replace(self.order, wait=True)
                self.submit(sorted(self.elsewhere))
            if time.monotonic() - self.looked > LOOK_S:
                self.slots, self.looked = self.workers.slots(), time.monotonic()
                self.tell()

    def submit(self, keys: list[str]) -> None:
        for key in keys:
            job = self.jobs[key]
            future = self.workers.executor.submit(attempt, self.order, job, key)
            self.keys[future] = key
            future.add_done_callback(self.ended.put)

    def tell(self) -> None:
        self.progress(self.tally.progress(self.slots, len(self.elsewhere)))

    def cancel(self) -> None:
        """Take back what no worker has begun."""
        for future in self.keys:
            future.cancel()

    def replies(self) -> list[Reply]:
        """What has come back, awaited for LOOK_S at most."""
        try:
            ended = [self.ended.get(timeout=LOOK_S)]
        except Empty:
            return []
        while not self.ended.empty():
            ended.append(self.ended.get())
        return [self.reply(future) for future in ended]

    def reply(self, future: Future) -> Reply:
        """What a job came back with; its worker's death or a fault on the way is the
        job's failure."""
        key = self.keys.pop(future)
        try:
            return future.result()
        except CancelledError:
            raise CampaignStopped(
                "the scheduler is gone; what is finished is kept"
            ) from None
        except Exception as error:
            return self.failed(key, f"{type(error).__name__}: {error}")

    def failed(self, key: str, reason: str) -> Reply:
        told = {"reason": reason, "lasting": False, "input": self.jobs[key].input}
        try:
            with self.store.claim(key):
                return Reply(key, self.store.put_failure(key, told))
        except Timeout:
            return Reply(key, busy=True)
        except OSError as error:
            return Reply(key, stop=f"{self.store.root}: cannot be written: {error}")

    def settle(self, replies: list[Reply]) -> Iterator[Outcome]:
        """Take replies in: outcomes go out, busy jobs are waited for; CampaignStopped
        when nothing can be stored."""
        for reply in replies:
            self.elsewhere.discard(reply.key)
            if reply.busy:
                self.elsewhere.add(reply.key)
            elif reply.outcome is not None:
                self.tally.add(reply.outcome, found=not reply.computed)
        if replies:
            self.tell()
        yield from (reply.outcome for reply in replies if reply.outcome is not None)
        for reply in replies:
            if reply.stop:
                raise CampaignStopped(
                    f"{reply.stop}; what is finished is kept, and the same call goes on"
                    " from there"
                )


def threads_each(jobs: int, cores: int) -> int:
    """Threads a job: one where there are jobs for all cores, else an equal share
    (results do not depend on it)."""
    return max(1, cores // jobs)


def _opened(store: str | Path) -> Store:
    try:
        return open_store(Path(store).absolute())
    except OSError as error:
        raise CampaignStopped(
            f"{store}: cannot be written: {error.strerror or error}"
        ) from error


def _now(store: Store) -> float:
    try:
        return store.now_s()
    except OSError as error:
        raise CampaignStopped(
            f"{store.root}: cannot be written: {error.strerror or error}"
        ) from error


def _kind(job) -> str:
    """Jobs that take about as long as one another."""
    return f"{job.input.get('rig')} {job.input.get('rendered')}"
