"""Reads what a card needs from DIR/result.json; a missing key is named with its file
and what it should hold."""

import hashlib
import json
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from benchtwin.bench.outlets import one_line
from benchtwin.calibrate.export.conventions import GIVEN, Solid, rolling_friction


@dataclass(frozen=True)
class Number:
    """A calibrated parameter, dimensionless.

    value: in the set of all parameters that is most probable together, which is what an
    engine gets; alone: its median, with the interval low to high; status: how far to
    trust it, in words."""

    value: float
    alone: float
    low: float
    high: float
    status: str


@dataclass(frozen=True)
class Pair:
    """What happens between two materials; the rolling friction in the result's own
    convention."""

    restitution: Number
    static_friction: Number
    rolling_friction: Number


@dataclass(frozen=True)
class Shape:
    """The seed: balls (x, y, z, r) [m] about the centre of mass, along the principal
    axes.

    mass_kg and inertia_kg_m2 (three principal moments) are those of the balls' union.
    """

    balls_m: tuple[tuple[float, float, float, float], ...]
    mass_kg: float
    inertia_kg_m2: tuple[float, float, float]

    @property
    def mean_radius_m(self) -> float:
        return sum(ball[3] for ball in self.balls_m) / len(self.balls_m)


@dataclass(frozen=True, kw_only=True)
class Calibrated:
    """All that a card is written from. on_wall, on_seed: seed against wall and seed;
    rolling: "edem", "type_a" or "type_c"."""

    on_wall: Pair
    on_seed: Pair
    seed: Solid
    wall: Solid
    rolling: str
    shape: Shape
    source: str

    def rolling_friction(self, length: str, *, on_wall: bool) -> float:
        """μ_r of the seed against wall or seed in an engine's convention, by its
        `length`."""
        given = (self.on_wall if on_wall else self.on_seed).rolling_friction.value
        return rolling_friction(given, self.rolling, length, on_wall=on_wall)

    @property
    def rolling_with_r_star(self) -> str:
        """Both conversions to an engine that takes R*, in words."""
        seed, wall = self.on_seed.rolling_friction, self.on_wall.rolling_friction
        on_seed, on_wall = (
            self.rolling_friction("effective", on_wall=at) for at in (False, True)
        )
        return (
            f"seed on seed {seed.value:.6g} -> {on_seed:.6g}, on wall"
            f" {wall.value:.6g} -> {on_wall:.6g}"
        )


# what a number may be, from the first to the second, in words
NUMBERS = {
    "restitution": (math.ulp(0.0), 1.0, "a number above 0, up to 1"),
    "static_friction": (0.0, 5.0, "a number from 0 to 5"),
    "rolling_friction": (0.0, 2.0, "a number from 0 to 2"),
}
SOLID = {
    "density_kg_m3": (1.0, 3e4, "a density, 1 to 30000 kg/m3"),
    "shear_modulus_pa": (1e3, 1e12, "a shear modulus, 1e3 to 1e12 Pa"),
    "poisson_ratio": (0.0, 0.5, "Poisson's ratio, 0 to 0.5"),
}


def read_result(folder: Path) -> Calibrated:
    """The calibrated parameters in folder/result.json; FileNotFoundError or ValueError
    says what is missing or wrong."""
    file = folder / "result.json"
    if not file.is_file():
        raise FileNotFoundError(
            f"{file}: not there; DIR is a folder that `benchtwin calibrate … --out DIR`"
            " wrote"
        )
    raw = file.read_bytes()
    try:
        content = json.loads(raw)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{file}: not readable as JSON: {error}") from error
    # The hash says which result a card came from after both have been copied elsewhere.
    digest = hashlib.sha256(raw).hexdigest()[:12]
    # it stands in comments of cards, which are programs
    return calibrated_from(content, str(file), f"{one_line(file)} (sha256 {digest})")


def calibrated_from(content: Any, file: str, source: str = "") -> Calibrated:
    """`Calibrated` of a result's content; errors name `file`."""
    result = _Result(content, file)
    seed, wall = (_solid(result, who) for who in ("seed", "wall"))
    one_of = f"one of {', '.join(GIVEN)}"
    rolling = result.entry("conventions.rolling", one_of, lambda v: v in [*GIVEN])
    on_wall, on_seed = (
        Pair(*(_parameter(result, prefix + name, name) for name in NUMBERS))
        for prefix in ("", "seed_")
    )
    shape = _shape(result, seed.density_kg_m3)
    return Calibrated(
        on_wall=on_wall,
        on_seed=on_seed,
        seed=seed,
        wall=wall,
        rolling=rolling,
        shape=shape,
        source=source or file,
    )


@dataclass(frozen=True)
class _Result:
    """A result's content, and the file that errors name."""

    content: Any
    file: str

    def entry(self, path: str, holds: str, fits: Callable[[Any], bool]) -> Any:
        """The entry at a dotted path. ValueError where there is none, or one that does
        not fit what it should hold."""
        at = self.content
        for key in path.split("."):
            if not isinstance(at, dict) or key not in at:
                raise ValueError(
                    f"{self.file}: {path} is missing: it should hold {holds}"
                )
            at = at[key]
        if not fits(at):
            raise ValueError(f"{self.file}: {path} = {at!r}: must be {holds}")
        return at


def _parameter(result: _Result, name: str, kind: str) -> Number:
    low, high, holds = NUMBERS[kind]
    where = f"parameters.{name}"
    result.entry(f"{where}.unit", '"1": it has no dimension', lambda v: v == "1")
    value, alone = (
        float(result.entry(f"{where}.{key}", holds, partial(_is_number, low, high)))
        for key in ("most_probable_set", "value")
    )
    anywhere = partial(_is_number, -sys.float_info.max, sys.float_info.max)
    least, most = (
        float(result.entry(f"{where}.{key}", f"the interval's {key} end", anywhere))
        for key in ("low", "high")
    )
    if not least <= alone <= most:
        raise ValueError(
            f"{result.file}: {where}: the interval {least:g} to {most:g} does not hold"
            f" the value {alone:g}"
        )
    status, remark = (
        result.entry(f"{where}.{key}", "one line of text", _is_line)
        for key in ("status", "remark")
    )
    said = f"{status}: {remark}" if remark else status
    return Number(value, alone, least, most, said)


def _solid(result: _Result, who: str) -> Solid:
    where, name = f"materials.{who}", "the material's name, one line of text"
    return Solid(
        result.entry(f"{where}.name", name, lambda v: _is_line(v) and bool(v.strip())),
        *(
            float(result.entry(f"{where}.{key}", holds, partial(_is_number, low, high)))
            for key, (low, high, holds) in SOLID.items()
        ),
    )


def _shape(result: _Result, density_kg_m3: float) -> Shape:
    # imported here: it brings the simulation, which listing the engines need not load
    from benchtwin.twin.result_sections import weighed

    path, holds = "seed_shape.spheres", "the seed's balls, a list of [x, y, z, r] in mm"
    rows = result.entry(path, holds, _are_balls)
    metres = [[1e-3 * v for v in row] for row in rows]
    try:
        found, mass, (ix, iy, iz) = weighed(metres, density_kg_m3)
    except ValueError as error:
        raise ValueError(f"{result.file}: {path}: {error}") from error
    balls = tuple((x, y, z, r) for x, y, z, r in found)
    return Shape(balls, mass, (ix, iy, iz))


def _are_balls(value: Any) -> bool:
    number = partial(_is_number, -sys.float_info.max, sys.float_info.max)
    rows = value if isinstance(value, list) else []
    return bool(rows) and all(
        isinstance(row, list) and len(row) == 4 and all(map(number, row))
        for row in rows
    )


def _is_line(value: Any) -> bool:
    return isinstance(value, str) and value.isprintable()


def _is_number(low: float, high: float, value: Any) -> bool:
    plain = isinstance(value, int | float) and not isinstance(value, bool)
    return plain and low <= value <= high
