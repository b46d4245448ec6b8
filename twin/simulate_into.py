"""Simulated recordings of a rig in a bench folder: what is asked for, checked; and the
runs, resumed where they were stopped."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.progress import BarColumn, Progress, TimeElapsedColumn

from benchtwin.bench.rigs import RIGS
from benchtwin.bench.terminal import Terminal, Words
from benchtwin.twin import Parameters
from benchtwin.twin.command import print_lines
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


def jobs_of(
    rig: str,
    parameters: Parameters,
    settings: Mapping[str, Any],
    *,
    repeats: int,
    rng: int,
    like: Path | None,
    rendered: bool,
    engine: Engine,
    start: Path | None = None,
    save: str | None = None,
) -> list[Job]:
    """A job a recording. settings: {key: value} of anything that is no contact
    parameter; start: a file with the heap to begin with.

    Raises ValueError for what does not fit, for a `like` that describes another rig,
    and for a state that cannot be saved so; Unavailable where the engine is not
    there."""
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
    parameters, description = assigned(parameters, description, settings)
    made = jobs(
        rig,
        parameters,
        description,
        repeats=repeats,
        rng=rng,
        rendered=rendered,
        engine=engine,
        start=start,
    )
    if save not in (None, SAVED):
        raise ValueError(f"--save {save}: {SAVED} is what there is")
    if save and engine.name != OURS and not made[0].heaps:
        raise ValueError(f"--save: of LAMMPS only heaps, not a {made[0].rig}")
    engine.ready()
    return made


def run_jobs(
    jobs: list[Job],
    rig: str,
    out: Path,
    threads: int,
    *,
    quiet: bool,
    save: str | None = None,
) -> tuple[str, ...]:
    """Run the jobs into RIG-01, RIG-02 … below the bench folder `out`, and name these;
    those that are done already are left as they are. save: "vtkhdf" for the state at
    the end, too."""
    if out.exists() and not out.is_dir():
        raise FileExistsError(f"{out}: is a file; --out names a folder")
    digits = max(2, len(str(len(jobs))))
    named = {f"{rig}-{n:0{digits}d}": job for n, job in enumerate(jobs, start=1)}
    columns = (
        Words("{task.description}"),
        BarColumn(),
        Words("{task.percentage:3.0f} %"),
        TimeElapsedColumn(),
    )
    console = Terminal(stderr=True, quiet=quiet)
    print_lines(console, *jobs[0].converted())
    with Progress(*columns, console=console, disable=quiet, transient=True) as progress:
        for name, job in named.items():
            task = progress.add_task(name, total=1.0)

            def watch(stage: str, share: float, task=task, name=name) -> None:
                progress.update(
                    task, description=f"{name} of {len(jobs)}: {stage}", completed=share
                )

            there = job.is_done(out / name)
            try:
                out.mkdir(parents=True, exist_ok=True)
                job.run(out / name, watch=watch, threads=threads, save=bool(save))
            except FileExistsError:
                raise
            except OSError as error:
                why = f"{error.strerror or error}; nothing half-written is left"
                raise OSError(f"cannot write to {out}: {why}") from error
            progress.remove_task(task)
            console.print(f"{out / name}" + (": was there already" if there else ""))
    print_lines(console, *said_of(jobs[0].description.get("seed", {})))
    return tuple(named)
