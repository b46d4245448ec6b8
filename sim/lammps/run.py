"""Running stages: inputs written, LAMMPS run, its own restart files taken up where it
was stopped, its frames read."""

import filecmp
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchtwin.sim.engine.world import Placed
from benchtwin.sim.lammps import program
from benchtwin.sim.lammps.follow import Way, parts, read_way
from benchtwin.sim.lammps.seeds import write_seeds
from benchtwin.sim.lammps.stage import Stage, script
from benchtwin.sim.rigs.bench import Watch


@dataclass(frozen=True)
class Lammps:
    """Where LAMMPS runs (the folder is kept, and gone on from when it holds the very
    same input), and on how many ranks."""

    folder: Path
    ranks: int = 1

    def run(self, stage: Stage, title: str, watch: Watch) -> Way:
        """The stage's frames; run, gone on with, or read where it was done before.
        RuntimeError with LAMMPS's own words."""
        placed = stage.world.seeds[0]
        assert isinstance(placed, Placed)
        program.needed(self.ranks)
        self.folder.mkdir(parents=True, exist_ok=True)
        self._written(stage, placed, title)
        count = len(np.asarray(placed.positions))
        level = np.tile([1.0, 0, 0, 0], (count, 1))
        start = (
            level if placed.orientations is None else np.asarray(placed.orientations)
        )
        while not self._done(stage.name):
            self._go(stage, title, watch)
        return read_way(self.folder, stage.name, start)

    def still(self, stage: Stage) -> bool:
        """Whether the stage ended because nothing moved."""
        told = (self.folder / f"{stage.name}.done").read_text()
        return told.split() == ["still", "1"]

    def _done(self, name: str) -> bool:
        return (self.folder / f"{name}.done").exists()

    def _written(self, stage: Stage, placed: Placed, title: str) -> None:
        """Write the input; what another input has left of this stage is taken away."""
        new = self.folder / f"{stage.name}.new"
        new.mkdir(exist_ok=True)
        (new / f"{stage.name}.in").write_text(script(stage, self.ranks, title))
        if stage.begin is None:
            write_seeds(new, stage.name, placed)
        made = sorted(new.iterdir())
        there = [(file, self.folder / file.name) for file in made]
        if not all(old.exists() and filecmp.cmp(new, old, False) for new, old in there):
            for old in self.folder.glob(f"{stage.name}.*"):
                if old.is_file():
                    old.unlink()
            for file in made:
                file.rename(self.folder / file.name)
        for file in new.iterdir():
            file.unlink()
        new.rmdir()

    def _go(self, stage: Stage, title: str, watch: Watch) -> None:
        """One start of LAMMPS; on an error without any new restart file RuntimeError,
        else it may be started again."""
        before, done = self._restarts(stage), parts(self.folder, stage.name)
        part = int(done[-1].name.split(".")[-3]) + 1 if before and done else 1
        if not before:
            for old in done:
                old.unlink()
        log = self.folder / f"{stage.name}.{part}.log"
        arguments = ["-in", f"{stage.name}.in", "-log", log.name]
        arguments += ["-var", "part", str(part)]
        if before:
            arguments += ["-var", "from", before[0].name]
        words = program.run(
            self.folder,
            arguments,
            ranks=self.ranks,
            look=lambda: watch(title, min(_time(log) / stage.longest_s, 0.99)),
        )
        if words is None and self._done(stage.name):
            return
        after = self._restarts(stage)
        if not after or (
            before and after[0].stat().st_mtime_ns == before[0].stat().st_mtime_ns
        ):
            raise RuntimeError(
                f"LAMMPS stopped in {self.folder / stage.files[0]}:"
                f" {words or 'without a word'}"
            )

    def _restarts(self, stage: Stage) -> list[Path]:
        """Restart files that were written to the end, the newest first: the bodies'
        file is written after the atoms'."""
        whole = [
            file
            for name in stage.files[1:]
            if (file := self.folder / name).exists()
            and (bodies := file.with_name(name + ".rigid")).exists()
            and bodies.stat().st_mtime_ns >= file.stat().st_mtime_ns
            and _whole(bodies)
        ]
        return sorted(whole, key=lambda file: -file.stat().st_mtime_ns)


def _whole(bodies: Path) -> bool:
    """Whether a file of bodies holds as many as it says."""
    lines = [
        line
        for line in bodies.read_text().splitlines()
        if line.strip() and not line.startswith("#")
    ]
    return bool(lines) and len(lines) == int(lines[0].split()[0]) + 1


def _time(log: Path) -> float:
    """The simulated time [s] that a log has come to."""
    try:
        with log.open("rb") as file:
            file.seek(max(log.stat().st_size - 4000, 0))
            lines = file.read().decode(errors="replace").splitlines()
    except OSError:
        return 0.0
    for line in reversed(lines):
        words = line.split()
        if 3 <= len(words) <= 5:
            try:
                return [float(word) for word in words][1]
            except ValueError:
                continue
    return 0.0
