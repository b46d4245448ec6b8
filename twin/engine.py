"""Which engine computes a run: our own, or LAMMPS; what it converts of the law, and
what is kept of its inputs."""

import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from benchtwin.bench.exits import Misuse
from benchtwin.bench.whole_file import own_folder
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.world import World
from benchtwin.sim.lammps.contact import in_lammps_law
from benchtwin.sim.lammps.engine import LammpsEngine
from benchtwin.sim.lammps.program import Unavailable, cores_here, lammps_version, needed
from benchtwin.sim.lammps.run import Lammps
from benchtwin.sim.motion import Motion
from benchtwin.sim.rigs.bench import Bench
from benchtwin.sim.rigs.engine import Ours, forget
from benchtwin.sim.rigs.filling import Filled
from benchtwin.twin.parameters import Parameters, bench
from benchtwin.twin.scene import rig_of, setup_of
from benchtwin.twin.setup import setup_for
from benchtwin.vision.recording import Recording

OURS, LAMMPS = "benchtwin", "lammps"
NAMES = (OURS, LAMMPS)
# what is kept of a LAMMPS run: its inputs, and what it said
BY_HAND = (".in", ".data", ".bodies", ".log")


@dataclass(frozen=True)
class Engine:
    """name: "benchtwin" or "lammps"; ranks of LAMMPS for one heap; shared_law: our own
    engine with the law that LAMMPS has too (with LAMMPS there is no other)."""

    name: str = OURS
    ranks: int = 1
    shared_law: bool = False

    def __post_init__(self) -> None:
        if self.name not in NAMES:
            raise Misuse(
                f"--engine {self.name}: no such engine; there are {' and '.join(NAMES)}"
            )
        if self.ranks < 1:
            raise Misuse(f"--ranks {self.ranks}: at least 1")
        if self.name == OURS and self.ranks > 1:
            raise Misuse(
                f"--ranks {self.ranks}: ranks are LAMMPS's, say --engine lammps; our"
                " own engine has --threads"
            )

    def for_rig(self, rig: str) -> "Engine":
        """The same with one rank for a rig of one seed or block, which ranks cannot
        share."""
        return self if setup_for(rig).many else replace(self, ranks=1)

    @property
    def told(self) -> dict:
        """What decides a run's outcome beside its other inputs; {} for our own engine
        with its own law."""
        if self.name == LAMMPS:
            return {"engine": {"name": LAMMPS, "ranks": self.ranks}}
        return {"engine": {"name": OURS, "shared_law": True}} if self.shared_law else {}

    @property
    def version(self) -> str:
        return lammps_version() if self.name == LAMMPS else version("benchtwin")

    def ready(self, workers: int | None = None) -> None:
        """Unavailable where this machine cannot run it, or so many at a time."""
        if self.name == LAMMPS:
            needed(self.ranks)
            if (
                self.ranks > 1
                and workers is not None
                and workers * self.ranks > cores_here()
            ):
                each = f"--workers {workers} with --ranks {self.ranks} each"
                raise Unavailable(
                    f"{each}: this machine has {cores_here()} cores; ranks that share a"
                    " core wait for each other"
                )

    def bench(
        self, parameters: Parameters, recording: Recording
    ) -> tuple[Bench, tuple[str, ...]]:
        """The bench with the law that is computed with, and what was converted;
        ValueError for what the engine has not."""
        own = bench(parameters, recording.need_rig(), recording.seed, recording.air)
        setup = setup_of(recording)
        if self.name == LAMMPS and not setup.in_lammps:
            raise ValueError(
                "--engine lammps: its inputs are not written for a"
                f" {setup.describe.__name__}"
            )
        return (
            in_lammps_law(own) if self.name == LAMMPS or self.shared_law else (own, ())
        )

    def run(
        self,
        recording: Recording,
        on_bench: Bench,
        rng: np.random.Generator,
        *,
        fps: float,
        watch: Callable,
        threads: int,
        scratch: Path | None,
        keep: Callable[[World, State], object] = forget,
        lying: Filled | None = None,
    ) -> Motion:
        """The rig's motion. LAMMPS works in the folder `scratch`, and goes on from what
        it left there; None: one that is removed. keep: is told how the run ended, of
        LAMMPS a heap's; lying: a heap to begin with."""
        rig, run = rig_of(recording), setup_of(recording).run
        how: dict[str, Any] = {"fps": fps, "watch": watch}
        how |= {"lying": lying} if lying is not None else {}
        if self.name == OURS:
            return run(rig, on_bench, rng, engine=Ours(threads, keep), **how)
        with tempfile.TemporaryDirectory() as passing:
            place = own_folder(scratch) if scratch else Path(passing)
            lammps = Lammps(place, self.ranks)
            return run(rig, on_bench, rng, engine=LammpsEngine(lammps, keep), **how)


OWN = Engine()


def kept_inputs(scratch: Path, folder: Path) -> None:
    """Move what runs by hand from `scratch`, where there is one, to `folder`, and
    remove the rest of it."""
    if not scratch.is_dir():
        return
    folder.mkdir()
    for file in sorted(scratch.iterdir()):
        if file.suffix in BY_HAND:
            shutil.move(file, folder / file.name)
    shutil.rmtree(scratch)
