"""Jobs without physics: numbers to be squared, with trouble on request, and a log of
who computed what."""

import errno
import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

from benchtwin.twin.campaign import Measured, Measurement


@dataclass(frozen=True)
class Square:
    """number: to be squared. log: a file that gets a line whenever work on it ends.
    trouble: what happens instead."""

    number: int
    log: str = ""
    takes_s: float = 0.0
    trouble: str = ""

    @property
    def key(self) -> str:
        return f"{self.number:016x}"

    @property
    def input(self) -> dict:
        return {"rig": "square", "number": self.number}


def square(job: Square, folder: Path, threads: int) -> Measured:
    """The square of the job's number, after a half-written folder has stood there for a
    while."""
    folder.mkdir(parents=True)
    (folder / "half.txt").write_text("half")
    time.sleep(job.takes_s)
    if job.trouble == "raise":
        raise RuntimeError(f"number {job.number} cannot be squared")
    if job.trouble == "memory":
        raise MemoryError("no room")
    if job.trouble == "full":
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(folder / "half.txt"))
    if job.trouble == "large":
        (folder / "large.bin").write_bytes(bytes(2_000_000))
    once = Path(f"{job.log}.{job.key}.once")
    if job.trouble == "kill once" and not once.exists():
        once.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if job.trouble == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    if job.log:
        with Path(job.log).open("a") as log:
            log.write(f"{job.key} {os.getpid()}\n")
    value = float("nan") if job.trouble == "nan" else job.number**2 + 0.1
    measured = (
        Measurement("area", value, 0.25, "mm²"),
        Measurement("restitution", 1 / 3, 0.5, "1", "doubtful", "for a reason"),
    )
    return Measured(measured, {"area_mm2": float(job.number**2)}, ("squared",))


def computed(log: Path) -> list[str]:
    """Keys in the order in which work on them ended."""
    return (
        [line.split()[0] for line in log.read_text().splitlines()]
        if log.exists()
        else []
    )


def nothing_half_written(store: Path) -> bool:
    """No temporary folders, no claims, and every run whole."""
    temporary = [*(store / "parts").iterdir(), *(store / "claims").iterdir()]
    return not temporary and all(
        (run / "measurements.json").is_file() for run in (store / "runs").iterdir()
    )
