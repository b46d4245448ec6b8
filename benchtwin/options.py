"""Options that several commands share, and what is typed as values."""

import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, TypeAlias

import typer

if TYPE_CHECKING:  # what a function takes from Python
    from benchtwin.calibrating import CalibrationSummary
    from benchtwin.measuring import Measurements

    Place = str | Path
    Paths = Place | Sequence[Place]
    Bench: TypeAlias = (
        "Place | Measurements"  # what may be calibrated, diagnosed or audited
    )
    Calibrated: TypeAlias = "Place | CalibrationSummary"
    Rows = Place | Sequence[Mapping[str, float]]
    Names = Sequence[str]
    Values = Mapping[str, object]
    Pairs = Mapping[str, tuple[float, float]]
    Window = tuple[float, float]
    Region = tuple[int, int, int, int]
    Line = tuple[float, float, float, float]
else:  # what the command line hands on
    Place = Bench = Calibrated = Rows = Path
    Paths, Names, Values, Pairs = list[Path], list[str], list[str], list[str]
    Window = Region = Line = str


def said(help: str, *names: str, **more: Any) -> Any:
    """An option with its help; names: where they are not those of the parameter."""
    return typer.Option(*names, help=help, **more)


def given(help: str, **more: Any) -> Any:
    """An argument with its help."""
    return typer.Argument(help=help, **more)


def _not(asked: bool) -> bool:
    return not asked


BENCH = "Bench folder: recordings of drop, slide, roll and pile."
BenchFolder = Annotated[Bench, given(BENCH, metavar="BENCH")]
ENGINES = "What computes the runs: benchtwin, or lammps (docs/lammps.md)."
EngineName = Annotated[str, said(ENGINES)]
QUIET = "Print nothing but errors."
Quiet = Annotated[bool, said(QUIET)]
# of a function that Python calls, too: there nothing is printed unless asked for
Progress = Annotated[bool, said(QUIET, "--quiet/--no-quiet", callback=_not)]
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


def window_of(text: str) -> tuple[float, float]:
    """Two heights in %.

    >>> window_of("20-80"), window_of("30 % – 70 %")
    ((20.0, 80.0), (30.0, 70.0))
    """
    from benchtwin.measuring import fractions

    parts = re.fullmatch(r"\s*([\d.]+)\s*%?\s*[-–,:]\s*([\d.]+)\s*%?\s*", text)
    try:
        low, high = map(float, parts.groups() if parts else ())
        fractions((low, high))
    except ValueError:
        raise typer.BadParameter(
            f"--window {text}: expected two heights in %, at least 10 apart, such as"
            " 20-80"
        ) from None
    return low, high


def region_of(text: str) -> tuple[int, ...]:
    """X,Y,WIDTH,HEIGHT."""
    return tuple(int(n) for n in _numbers(text, "--roi", (4,)))


def line_of(text: str) -> tuple[float, ...]:
    """X1,Y1,X2,Y2, or Y alone of a level line."""
    numbers = _numbers(text, "--baseline", (1, 4))
    x1, y1, x2, y2 = numbers if len(numbers) == 4 else (0.0, *numbers, 1e3, *numbers)
    if abs(x2 - x1) < 10 * abs(y2 - y1):
        raise typer.BadParameter(
            f"--baseline {text}: the two points must lie side by side (X1,Y1,X2,Y2)"
        )
    return x1, y1, x2, y2


def _numbers(text: str, option: str, counts: tuple[int, ...]) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in counts or not all(abs(n) < 1e6 for n in numbers):
        wanted = " or ".join(map(str, counts))
        raise typer.BadParameter(
            f"{option} {text}: expected {wanted} numbers with commas between"
        )
    return numbers


KEYS = "KEY=VALUE of anything else: pile.fill_height_mm=80, drum.speed_rpm=20 …"
Settings = Annotated[
    Values | None, said(KEYS, "--set", parser=setting_of, metavar="KEY=VALUE")
]
