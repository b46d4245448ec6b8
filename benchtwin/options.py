"""Options that several commands share."""

from typing import Annotated

import typer

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
