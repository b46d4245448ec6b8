"""Command line of `benchtwin simulate`: options, progress, resuming, exit code."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.progress import BarColumn, Progress, TimeElapsedColumn

from benchtwin.bench.rigs import RIGS
from benchtwin.bench.terminal import Terminal, Words
from benchtwin.twin import Parameters
from benchtwin.twin.command import DONE, Misuse, exit_code
from benchtwin.twin.engine import OURS, Engine
from benchtwin.twin.job import (
    RIG_NAMES,
    Job,
    assigned,
    described,
    jobs,
    rig_named,
)
from benchtwin.twin.parameters import said_of

MOST_REPEATS = 10_000
SAVED = "vtkhdf"  # the format of a saved state


def simulate_command(
    rig: str,
    out: Path,
    numbers: dict[str, float | None],
    *,
    repeats: int,
    rng: int,
    settings: Mapping[str, Any],
    like: Path | None,
    rendered: bool,
    threads: int,
    engine: str,
    ranks: int,
    quiet: bool,
    save: str | None = None,
    start: Path | None = None,
) -> int:
    """Simulate `repeats` recordings of a rig into the bench folder `out`; returns the
    exit code."""

    def simulated() -> None:
        computed = Engine(engine, ranks)
        jobs = jobs_of(
            rig, numbers, repeats, rng, settings, like, rendered, computed, start
        )
        check_ready(jobs, save)
        for line in () if quiet else jobs[0].converted():
            print(line)
        run_jobs(jobs, rig, out, threads, quiet, save)
        for line in () if quiet else said_of(jobs[0].description.get("seed", {})):
            print(line)

    def work() -> int:
        try:
            simulated()
        except FileExistsError:
            raise
        except OSError as error:
            why = f"{error.strerror or error}; nothing half-written is left"
            raise Misuse(f"cannot write to {out}: {why}") from error
        return DONE

    return exit_code("simulate", out, work, misuses=(ValueError, FileExistsError))


def jobs_of(
    rig: str,
    numbers: dict,
    repeats: int,
    rng: int,
    settings: Mapping[str, Any],
    like: Path | None,
    rendered: bool,
    engine: Engine,
    start: Path | None = None,
) -> list[Job]:
    """A job a recording. numbers: fields of `Parameters`, None for its default;
    settings: {key: value} of anything else; start: a file with the heap to begin with.

    Raises ValueError for what does not fit, and for a `like` that describes another
    rig."""
    if rig not in RIG_NAMES:
        raise ValueError(f"{rig}: no such rig; there are {', '.join(RIG_NAMES)}")
    if not 1 <= repeats <= MOST_REPEATS:
        raise ValueError(f"--repeats {repeats}: 1 to {MOST_REPEATS:,}")
    of, description = described(like) if like else (None, {})
    if of is not None and of != rig_named(rig)[0]:
        raise ValueError(f"{like} describes a {of}, not a {rig}")
    for key in settings:
        section = key.partition(".")[0].strip()
        if section in RIGS and section != rig_named(rig)[0]:
            raise ValueError(f"setting {key}: is of a {section}, not of a {rig}")
        if key == "camera.readout_s":
            raise ValueError(
                f"setting {key}: a simulated camera reads all rows at once"
            )
    given = {name: value for name, value in numbers.items() if value is not None}
    parameters, description = assigned(Parameters(**given), description, settings)
    return jobs(
        rig,
        parameters,
        description,
        repeats=repeats,
        rng=rng,
        rendered=rendered,
        engine=engine,
        start=start,
    )


def check_ready(jobs: list[Job], save: str | None) -> None:
    """ValueError for a state that cannot be saved so; Unavailable where the engine is
    not there."""
    if save not in (None, SAVED):
        raise ValueError(f"--save {save}: {SAVED} is what there is")
    if save and jobs[0].engine.name != OURS and not jobs[0].heaps:
        raise ValueError(f"--save: of LAMMPS only heaps, not a {jobs[0].rig}")
    jobs[0].engine.ready()


def run_jobs(
    jobs: list[Job],
    rig: str,
    out: Path,
    threads: int,
    quiet: bool,
    save: str | None = None,
) -> None:
    """Run the jobs into RIG-01, RIG-02 … below the bench folder `out`; those that are
    done already are left as they are. save: "vtkhdf" for the state at the end, too."""
    if out.exists() and not out.is_dir():
        raise FileExistsError(f"{out}: is a file; --out names a folder")
    out.mkdir(parents=True, exist_ok=True)
    columns = (
        Words("{task.description}"),
        BarColumn(),
        Words("{task.percentage:3.0f} %"),
        TimeElapsedColumn(),
    )
    with Progress(
        *columns, console=Terminal(stderr=True), disable=quiet, transient=True
    ) as progress:
        for n, job in enumerate(jobs, start=1):
            name = f"{rig}-{n:0{max(2, len(str(len(jobs))))}d}"
            task = progress.add_task(name, total=1.0)

            def watch(stage: str, share: float, task=task, name=name) -> None:
                progress.update(
                    task, description=f"{name} of {len(jobs)}: {stage}", completed=share
                )

            there = job.is_done(out / name)
            job.run(out / name, watch=watch, threads=threads, save=bool(save))
            progress.remove_task(task)
            if not quiet:
                progress.console.print(
                    f"{out / name}" + (": was there already" if there else "")
                )
