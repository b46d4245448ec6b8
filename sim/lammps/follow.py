"""A stage's dumps, read back: where every seed was at every frame, in our frames of the
seeds, each moment once."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchtwin.sim.rigs.bench import Columns
from benchtwin.sim.rotation import product

COLUMNS = 14  # mol, place (3), quaternion (4), velocity (3), spin (3)


@dataclass(frozen=True, eq=False)
class Way:
    """Frames of one stage: steps (frames,), rows (frames, seeds, 13): place,
    quaternion, velocity, spin; NaN once it has left."""

    steps: np.ndarray
    rows: np.ndarray

    def columns(self, step_s: float) -> Columns:
        r = self.rows
        return Columns(
            t_s=self.steps * step_s,
            positions_m=r[:, :, 0:3],
            orientations=r[:, :, 3:7],
            velocities_m_s=r[:, :, 7:10],
            spins_rad_s=r[:, :, 10:13],
        )


def read_way(folder: Path, name: str, orientations: np.ndarray) -> Way:
    """All parts of a stage, one after the other; orientations (seeds, 4) at its begin,
    in our frames.

    LAMMPS names a body's principal axes as it likes, anew after every restart: so only
    turns since a part's first frame are taken from it. What a stopped part wrote after
    the restart file that the next one went on from is left out."""
    steps: list[int] = []
    rows: list[np.ndarray] = []
    for file in parts(folder, name):
        frames = read_dump(file, len(orientations))
        if not frames:
            continue
        first, reference = frames[0]
        while steps and steps[-1] >= first:
            last_step, last = steps.pop(), rows.pop()
            if last_step == first:
                orientations = np.where(
                    np.isfinite(last[:, 3:7]), last[:, 3:7], orientations
                )
        inverse = reference[:, 3:7] * np.array([1.0, -1.0, -1.0, -1.0])
        for step, frame in frames:
            turn = product(frame[:, 3:7], inverse)
            steps.append(step)
            turned = product(turn, orientations)
            rows.append(np.concatenate([frame[:, :3], turned, frame[:, 7:]], axis=1))
    if not steps:
        raise RuntimeError(f"{folder}: LAMMPS has left no frame of {name}")
    return Way(np.array(steps), np.stack(rows))


def parts(folder: Path, name: str) -> list[Path]:
    """The dumps of a stage in the order in which they were written."""
    return sorted(
        folder.glob(f"{name}.*.bodies.dump"),
        key=lambda file: int(file.name.split(".")[-3]),
    )


def read_dump(file: Path, count: int) -> list[tuple[int, np.ndarray]]:
    """(step, rows (count, 13)) of every whole frame in a `dump local`; the last one may
    be cut off."""
    found = []
    with file.open() as lines:
        while lines.readline().startswith("ITEM: TIMESTEP"):
            head = [lines.readline() for _ in range(8)]
            if not head[-1].startswith("ITEM: ENTRIES"):
                break
            n = int(head[2])
            text = [lines.readline() for _ in range(n)]
            if text and not text[-1].endswith("\n"):
                break
            numbers = np.array("".join(text).split(), float).reshape(n, COLUMNS)
            rows = np.full((count, COLUMNS - 1), np.nan)
            rows[numbers[:, 0].astype(int) - 1] = numbers[:, 1:]
            found.append((int(head[0]), rows))
    return found


def read_pushes(
    folder: Path, name: str, steps: np.ndarray, step_s: float
) -> np.ndarray:
    """Time integral [N s] of the seeds' push on each wall at these steps, (frames,
    walls, 3), from the mean loads in between."""
    found: dict[int, list[float]] = {}
    for dump in parts(folder, name):
        file = dump.with_name(dump.name.replace(".bodies.dump", ".push.txt"))
        for line in file.read_text().splitlines():
            numbers = line.split()
            if numbers and numbers[0] != "#":
                found[int(numbers[0])] = [-float(v) for v in numbers[1:]]
    taken = np.array([found[int(step)] for step in steps[1:]]).reshape(
        len(steps) - 1, -1, 3
    )
    pushes = np.diff(steps)[:, None, None] * step_s * taken
    return np.concatenate([np.zeros((1, *pushes.shape[1:])), np.cumsum(pushes, axis=0)])
