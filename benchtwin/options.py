"""Options that several commands share, and what is typed as values."""

import tomllib
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

BenchFolder = Annotated[
    Path,
    typer.Argument(
        metavar="BENCH", help="Bench folder: recordings of drop, slide, roll and pile."
    ),
]
EngineName = Annotated[
    str,
    typer.Option(help="What computes the runs: benchtwin, or lammps (docs/lammps.md)."),
]
Quiet = Annotated[bool, typer.Option(help="Print nothing but errors.")]
Ranks = Annotated[
    int, typer.Option(min=1, help="Of LAMMPS: processes that share one run.")
]
Rendered = Annotated[
    bool, typer.Option(help="Film every run and measure the pictures: slower.")
]
Rng = Annotated[
    int,
    typer.Option(
        min=0, help="Seed of the random numbers: the same one gives the same result."
    ),
]
Scheduler = Annotated[
    str | None, typer.Option(help="tcp://host:port of a dask scheduler to simulate on.")
]
Workers = Annotated[
    int | None, typer.Option(min=1, help="Processes that simulate; else one a core.")
]


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
    except tomllib.TOMLDecodeError:
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


Settings = Annotated[
    list[Setting],
    typer.Option(
        "--set",
        parser=setting_of,
        metavar="KEY=VALUE",
        help="KEY=VALUE of anything else: pile.fill_height_mm=80, drum.speed_rpm=20 …",
    ),
]
