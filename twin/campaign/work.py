"""What one job does in a worker: run the twin, measure the recording, and leave of the
evidence what is asked for."""

import json
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from benchtwin.bench.rigs import variant_of
from benchtwin.twin.campaign.results import Measured, Measurement

LONGEST_WAIT_S = 300.0
KEEP = ("photos", "all", "numbers")
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


def thin(folder: Path, measured: Measured, keep: str) -> None:
    """Remove pictures: "photos" keeps photos but not frames, "numbers" neither, "all"
    both. What could not be measured keeps all.

    The measured track, if there is one in millimetres, takes the place of the frames,
    so that the folder remains a recording."""
    if keep == "all" or measured.reason:
        return
    frames = folder / "frames"
    if frames.is_dir():
        shutil.rmtree(frames)
        if measured.track is not None and set(measured.track.columns) >= TRACK_COLUMNS:
            measured.track.to_csv(
                folder / "track.csv", index=False, float_format="%.9g"
            )
    if keep == "numbers":
        for photo in folder.glob("photo*"):
            photo.unlink()


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
