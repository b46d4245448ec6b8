"""Options that several commands share, and what is typed as values."""

import tomllib
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer


def said(help: str, *names: str, **more: Any) -> Any:
    """An option with its help; names: where they are not those of the parameter."""
    return typer.Option(*names, help=help, **more)


def given(help: str, **more: Any) -> Any:
    """An argument with its help."""
    return typer.Argument(help=help, **more)


BENCH = "Bench folder: recordings of drop, slide, roll and pile."
BenchFolder = Annotated[Path, given(BENCH, metavar="BENCH")]
ENGINES = "What computes the runs: benchtwin, or lammps (docs/lammps.md)."
EngineName = Annotated[str, said(ENGINES)]
Quiet = Annotated[bool, said("Print nothing but errors.")]
Ranks = Annotated[int, said("Of LAMMPS: processes that share one run.", min=1)]
FILMED = "Film every run and measure the pictures: slower."
Rendered = Annotated[bool, said(FILMED)]
SEED = "Seed of the random numbers: the same one gives the same result."
Rng = Annotated[int, said(SEED, min=0)]
DASK = "tcp://host:port of a dask scheduler to simulate on."
Scheduler = Annotated[str | None, said(DASK)]
PROCESSES = "Processes that simulate; else one a core."
Workers = Annotated[int | None, said(PROCESSES, min=1)]


class Setting(NamedTuple):
    """A key, and the value that it is set to."""

    key: str
    value: Any


class Pair(NamedTuple):
    """A parameter's name, and two numbers."""

    name: str
    numbers: tuple[float, float]


def setting_of(text: str) -> Setting:
    """A key and its value, in TOML; a bare word is taken as text.

    >>> setting_of("pile.gate_mm=[30, 200]").value, setting_of("seed.kind=maize").value
    ([30, 200], 'maize')
    """
    key, sign, value = (part.strip() for part in text.partition("="))
    if not sign:
        raise typer.BadParameter(
            f"{text}: expected key=value, such as pile.fill_height_mm=80"
        )
    try:
        return Setting(key, tomllib.loads(f"x = {value}")["x"])
    except (ValueError, RecursionError):
        return Setting(key, value)


def pair_of(text: str) -> Pair:
    """A name and two numbers.

    >>> pair_of("seed_restitution=0.45:0.7")
    Pair(name='seed_restitution', numbers=(0.45, 0.7))
    """
    name, _, ends = text.partition("=")
    try:
        low, high = (float(end) for end in ends.split(":"))
    except ValueError:
        raise typer.BadParameter(
            f"{text}: expected NAME=NUMBER:NUMBER, such as seed_restitution=0.4:0.7"
        ) from None
    return Pair(name.strip(), (low, high))


KEYS = "KEY=VALUE of anything else: pile.fill_height_mm=80, drum.speed_rpm=20 …"
Settings = Annotated[
    list[Setting], said(KEYS, "--set", parser=setting_of, metavar="KEY=VALUE")
]
