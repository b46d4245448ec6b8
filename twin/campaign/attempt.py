"""One job against the store, in a worker process: found, claimed and computed (the twin
run, the recording measured, of the evidence left what is asked for), left to whoever
has it, or recorded as failed."""

import errno
import json
import math
import os
import shutil
import socket
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from benchtwin.bench.rigs import variant_of
from benchtwin.sim.lammps.program import Unavailable
from benchtwin.twin.campaign.results import Measured, Measurement, Outcome
from benchtwin.twin.campaign.store import Store, open_store

Work = Callable[[object, Path, int], Measured]

FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO, errno.ESTALE}
REFUSED = {errno.EACCES, errno.EPERM}


@dataclass(frozen=True)
class Order:
    """What all jobs of one campaign have in common; small, for it travels with every
    job.

    since_s: when the campaign began, by the store's clock; failures recorded later
    count. alone: a failed job that is run by itself: earlier failures do not count, and
    all of its pictures stay. wait: for who has the job."""

    root: str
    id: str
    work: Work
    threads: int
    since_s: float
    alone: bool = False
    wait: bool = False


@dataclass(frozen=True)
class Reply:
    """outcome; or busy: another process has the job; or stop: why no job can be
    stored."""

    key: str
    outcome: Outcome | None = None
    busy: bool = False
    stop: str = ""
    computed: bool = False


def attempt(order: Order, job: Any, key: str) -> Reply:
    """Have this job's outcome, by computing it if nobody else has. key: the job's, as
    the campaign knows it."""
    # a result under another key would be lost, or stand for what it is not
    if job.key != key:
        here = f"{socket.gethostname()}, process {os.getpid()}"
        return Reply(
            key,
            stop=(
                f"the worker on {here} has another version of benchtwin: a job's key is"
                f" {job.key} there, not {key}"
            ),
        )
    try:
        store = open_store(Path(order.root), id=order.id)
        # asked once the claim is ours: a winner releases it after publishing
        with store.claim(key, wait=order.wait):
            known = recorded(store, order, key)
            return Reply(key, known) if known else _compute(store, order, job)
    except Timeout:
        return Reply(key, busy=True)
    except OSError as error:  # what a job raises is recorded; this is the store
        why = error.strerror or str(error)
        return Reply(
            key,
            stop=(
                f"{order.root}: cannot be written by {socket.gethostname()}: {why}"
                f" ({error.filename or 'data'})"
            ),
        )


def recorded(store: Store, order: Order, key: str) -> Outcome | None:
    """What the store holds for a key that this campaign takes as its answer."""
    again = order.alone
    return store.finished(
        key, since_s=order.since_s if again else 0.0
    ) or store.failure(key, lasting=not again, since_s=order.since_s)


def _compute(store: Store, order: Order, job: Any) -> Reply:
    begin = time.perf_counter()
    with store.part(job.key) as part:
        folder = Path(part) / job.key
        try:
            measured = order.work(job, folder, order.threads)
            _check_numbers(measured)
            if not (order.alone or measured.reason):
                thin(folder, measured)
        except Exception as error:  # whatever ends one job must not end the others
            if is_of_the_store(error, order.root):
                raise
            outcome = store.put_failure(job.key, _failure(order, job, error))
            return Reply(job.key, outcome, computed=True)
        seconds = time.perf_counter() - begin - measured.warming_s
        more = {"host": socket.gethostname(), "work": name_of(order.work)}
        outcome = store.put(folder, job, measured, seconds, more)
        return Reply(job.key, outcome, computed=True)


def is_of_the_store(error: Exception, root: str) -> bool:
    """Whether no other job could be stored either: a full or unwritable disk, not one
    job's own trouble."""
    if not isinstance(error, OSError):
        return False
    return error.errno in FULL or (
        error.errno in REFUSED and str(error.filename or "").startswith(root)
    )


def _check_numbers(measured: Measured) -> None:
    for m in measured.measurements:
        if not math.isfinite(m.value) and m.quality != "failed":
            raise ValueError(f"{m.name} = {m.value}: a number was expected")


def _failure(order: Order, job: Any, error: Exception) -> dict:
    return {
        "reason": f"{type(error).__name__}: {error}",
        "lasting": not isinstance(
            error, OSError | MemoryError | Unavailable
        ),  # the machine's, and may not come again
        "input": job.input,
        "work": name_of(order.work),
        "host": socket.gethostname(),
        "traceback": "".join(traceback.format_exception(error)),
    }


def name_of(work: Work) -> str:
    """Module and name of what a job does, as its record states it."""
    name = getattr(work, "__qualname__", repr(work))
    return f"{getattr(work, '__module__', '?')}:{name}"


LONGEST_WAIT_S = 300.0
TRACK_COLUMNS = {"t_s", "x_mm", "y_mm"}

_compiled: set[str] = set()


def simulate_and_measure(job: Any, folder: Path, threads: int) -> Measured:
    """Run a `twin.job.Job` into `folder` and measure what it filmed; raises what the
    run raises."""
    from benchtwin.twin import observe
    from benchtwin.twin.job import MeasurementError

    with one_compiles(kernels_of(job)) as warming:
        recording = job.run(
            folder, watch=lambda stage, share: warming.over(), threads=threads
        )
    truth = json.loads((folder / "simulation.json").read_text(encoding="utf8"))["truth"]
    truth = {
        name: float("nan") if value is None else value for name, value in truth.items()
    }
    try:
        seen = observe(recording)
    except (
        MeasurementError
    ) as error:  # the run itself is good, and is kept to be looked at
        why = f"it ran, but could not be measured: {error}"
        return Measured(truth=truth, reason=why, warming_s=warming.took_s)
    found = tuple(
        Measurement(q.name, float(q.value), float(q.sd), q.unit, q.quality, q.reason)
        for q in seen.quantities
    )
    return Measured(
        found, truth, tuple(seen.notes), seen.track, warming_s=warming.took_s
    )


def thin(folder: Path, measured: Measured) -> None:
    """Remove frames. The measured track, if there is one in millimetres, takes their
    place, so that the folder remains a recording."""
    frames = folder / "frames"
    if frames.is_dir():
        shutil.rmtree(frames)
        if measured.track is not None and set(measured.track.columns) >= TRACK_COLUMNS:
            measured.track.to_csv(
                folder / "track.csv", index=False, float_format="%.9g"
            )


def kernels_of(job: Any) -> str:
    """What decides which kernels a job needs: rig, conventions, laws. Rather too fine
    than too coarse."""
    parameters, described = job.input["parameters"], job.input["description"]
    air = described.get("air", {}).get("density_kg_m3") == 0
    kind = variant_of(job.input["rig"], described)
    if job.input.get("engine", {}).get("name") == "lammps":
        return "lammps"
    laws, vacuum = sorted(parameters["laws"]), ["vacuum"] if air else []
    return "-".join([kind, parameters["rolling_convention"], *laws, *vacuum])


@dataclass
class Warming:
    """A process's first job with these kernels, until `over` is called. took_s: how
    long that was [s]; 0 for later ones."""

    kernels: str
    lock: FileLock | None
    begin: float
    took_s: float = 0.0

    def over(self) -> None:
        """The kernels are compiled: whoever waits for them may load them."""
        if self.lock is not None and self.kernels not in _compiled:
            _compiled.add(self.kernels)
            self.took_s = time.perf_counter() - self.begin
            self.lock.release()


@contextmanager
def one_compiles(kernels: str) -> Iterator[Warming]:
    """On one machine, only one process at a time compiles a set of kernels (20 s); the
    others find them on disk.

    `over()` of what it yields is to be called as soon as they are compiled. Waits at
    most LONGEST_WAIT_S: the lock saves work, and no more depends on it."""
    from benchtwin.sim.engine.compiled import cache_folder

    begin, lock = time.perf_counter(), None
    if kernels not in _compiled:
        lock = FileLock(cache_folder() / f"{kernels}.lock")
        with suppress(Timeout):
            lock.acquire(timeout=LONGEST_WAIT_S)
    try:
        yield Warming(kernels, lock, begin)
    finally:
        if lock is not None:
            lock.release()
