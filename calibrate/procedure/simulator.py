"""Simulated runs for the procedure: what it asks for, and the campaign that answers."""

import hashlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.calibrate.procedure.rigs import STEEL
from benchtwin.twin.engine import OWN, Engine

CONVERTED_ALIKE = (
    "these numbers are the first run's; others are converted in the same way"
)


@dataclass(frozen=True)
class Run:
    """One run: rig; values of contact parameters by name; rng: seed numbers of its
    generator (the same ones: the same packing); description: sections of its
    recording.toml."""

    rig: str
    values: dict[str, float]
    rng: tuple[int, ...]
    description: dict = field(default_factory=dict)


Simulator = Callable[[Sequence[Run]], pd.DataFrame]
"""Runs in, a row a run out, in their order: status ("done" where it was measured),
reason, rerun, and the measured columns."""


class Unreachable(ValueError):
    """No physical value of the parameter gives the bench's mean: a finding for
    diagnosis."""


class SimulationFailed(RuntimeError):
    """So many runs of a stage came to nothing that it cannot go on."""


@contextmanager
def campaign(
    store: Path,
    *,
    base: dict | None = None,
    rendered: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[object], None] = lambda told: None,
    engine: Engine = OWN,
    say: Callable[[str], None] = lambda text: None,
) -> Iterator[Simulator]:
    """A simulator over the store: each run is computed once, whoever asks again. base:
    further fields of `Parameters`. say: told once what the engine converts of the law,
    with the first run's numbers.

    Local workers are started with the first runs that the store has not, and stay for
    all that follow: they load their compiled kernels once."""
    # imported here: dask and the compiled engine, which `--help` must not wait for
    from benchtwin.twin import Parameters
    from benchtwin.twin.campaign import run_campaign
    from benchtwin.twin.campaign.processes import local, workers_for
    from benchtwin.twin.job import Job

    def job(r: Run) -> Job:
        parameters = Parameters(**(base or {}) | rounded(r.values))
        return Job(r.rig, parameters, _begun(r), r.rng, rendered, engine)

    with local(workers or workers_for(engine.ranks)) as here:
        told = False

        def simulate(runs: Sequence[Run]) -> pd.DataFrame:
            nonlocal told
            jobs = [job(r) for r in runs]
            if jobs and not told and (converted := jobs[0].converted()):
                told = True
                for line in (*converted, tr(CONVERTED_ALIKE)):
                    say(line)
            return run_campaign(
                jobs, store, workers=here, scheduler=scheduler, progress=progress
            ).table

        yield simulate


def rounded(values: dict[str, float]) -> dict[str, float]:
    """Nine digits: what differs by less is the same input, and the same job."""
    return {name: float(f"{value:.9g}") for name, value in values.items()}


def _begun(run: Run) -> dict:
    """The run's description, the rig's section as a run at its values begins."""
    if (rig := STEEL.get(run.rig)) is None:
        return run.description
    value = run.values.get(rig.parameter, rig.assumed)
    section = rig.begun(run.description.get(run.rig, {}), value)
    return run.description | {run.rig: section}


def usable(
    table: pd.DataFrame, response: str, *, least: float = 0.5
) -> tuple[pd.Series, list[str]]:
    """Which rows have a finite response, and what to say of the others.

    Raises SimulationFailed when fewer than the share `least` have one, naming a failure
    and how to run it alone."""
    there = table["status"].eq("done")
    there &= table[response].notna() if response in table else False
    notes = []
    if not there.all():
        first = table[~there].iloc[0]
        again = tr("; run it alone: {}", first["rerun"]) if first.get("rerun") else ""
        notes.append(
            tr(
                "{} of {} simulated runs gave nothing ({}{})",
                (~there).sum(),
                len(table),
                first["reason"] or first["status"],
                again,
            )
        )
    if there.mean() < least:
        raise SimulationFailed(notes[0])
    return there, notes


def seed_numbers(seed: int, *words: object) -> tuple[int, ...]:
    """Seed numbers of a run, from what it is: another stage, value or repeat has
    others, whatever was run before.

    >>> one = seed_numbers(1, "curve", 0.5, 3)
    >>> one == seed_numbers(1, "curve", 0.5, 3) != seed_numbers(1, "curve", 0.5, 4)
    True
    """
    text = " ".join(f"{w:.9g}" if isinstance(w, float) else str(w) for w in words)
    return (seed, int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "little"))
