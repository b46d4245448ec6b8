"""Reads what a card needs from DIR/result.json; a missing key is named with its file
and what it should hold."""

import hashlib
import json
import sys
from dataclasses import dataclass
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


# what a value may be: above the first (or equal, for frictions), up to the second
NUMBERS = {
    "restitution": (0.0, 1.0, "a number above 0, up to 1"),
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
    seed, wall = (_solid(content, who, file) for who in ("seed", "wall"))
    one_of = f"one of {', '.join(GIVEN)}"
    rolling = _take(content, "conventions.rolling", file, one_of)
    if rolling not in GIVEN:
        raise ValueError(f"{file}: conventions.rolling = {rolling!r}: must be {one_of}")
    on_wall, on_seed = (
        Pair(*(_parameter(content, prefix + name, name, file) for name in NUMBERS))
        for prefix in ("", "seed_")
    )
    return Calibrated(
        on_wall=on_wall,
        on_seed=on_seed,
        seed=seed,
        wall=wall,
        rolling=rolling,
        shape=_shape(content, seed.density_kg_m3, file),
        source=source or file,
    )


def _parameter(content: Any, name: str, kind: str, file: str) -> Number:
    low, high, holds = NUMBERS[kind]
    where = f"parameters.{name}"
    unit = _take(content, f"{where}.unit", file, 'the unit "1": it has no dimension')
    if unit != "1":
        raise ValueError(f'{file}: {where}.unit = {unit!r}: must be "1"')
    value, alone = (
        _number(content, f"{where}.{key}", file, holds)
        for key in ("most_probable_set", "value")
    )
    for key, v in (("most_probable_set", value), ("value", alone)):
        if not low <= v <= high or (kind == "restitution" and v == 0.0):
            raise ValueError(f"{file}: {where}.{key} = {v:g}: must be {holds}")
    of = "end of the value's interval, a number"
    least = _number(content, f"{where}.low", file, f"the low {of}")
    most = _number(content, f"{where}.high", file, f"the high {of}")
    if not least <= alone <= most:
        raise ValueError(
            f"{file}: {where}: the interval {least:g} to {most:g} does not hold the"
            f" value {alone:g}"
        )
    status, remark = (
        _line(content, f"{where}.{key}", file) for key in ("status", "remark")
    )
    said = f"{status}: {remark}" if remark else status
    return Number(value, alone, least, most, said)


def _line(content: Any, path: str, file: str) -> str:
    """One line of text at a dotted path."""
    text = _take(content, path, file, "one line of text")
    if not isinstance(text, str) or not (text.isprintable() or text == ""):
        raise ValueError(f"{file}: {path} = {text!r}: must be one line of text")
    return text


def _solid(content: Any, who: str, file: str) -> Solid:
    name = _take(content, f"materials.{who}.name", file, "the material's name, a text")
    if not isinstance(name, str) or not name.strip() or not name.isprintable():
        raise ValueError(
            f"{file}: materials.{who}.name = {name!r}: must be the material's name, one"
            " line of text"
        )
    values = []
    for key, (low, high, holds) in SOLID.items():
        values.append(_number(content, f"materials.{who}.{key}", file, holds))
        if not low <= values[-1] <= high:
            raise ValueError(
                f"{file}: materials.{who}.{key} = {values[-1]:g}: must be {holds}"
            )
    return Solid(name, *values)


def _shape(content: Any, density_kg_m3: float, file: str) -> Shape:
    # imported here: it brings the simulation, which listing the engines need not load
    from benchtwin.twin.result_sections import weighed

    holds = "the seed's balls, a list of [x, y, z, r] in mm"
    rows = _take(content, "seed_shape.spheres", file, holds)
    listed = isinstance(rows, list) and rows
    if not listed or not all(isinstance(row, list) and len(row) == 4 for row in rows):
        raise ValueError(f"{file}: seed_shape.spheres: must be {holds}")
    if not all(_is_number(v) for row in rows for v in row):
        raise ValueError(f"{file}: seed_shape.spheres: must be {holds}")
    metres = [[1e-3 * v for v in row] for row in rows]
    try:
        found, mass, (ix, iy, iz) = weighed(metres, density_kg_m3)
    except ValueError as error:
        raise ValueError(f"{file}: seed_shape.spheres: {error}") from error
    balls = tuple((x, y, z, r) for x, y, z, r in found)
    return Shape(balls, mass, (ix, iy, iz))


def _take(content: Any, path: str, file: str, holds: str) -> Any:
    """The entry at a dotted path."""
    at = content
    for key in path.split("."):
        if not isinstance(at, dict) or key not in at:
            raise ValueError(f"{file}: {path} is missing: it should hold {holds}")
        at = at[key]
    return at


def _number(content: Any, path: str, file: str, holds: str) -> float:
    value = _take(content, path, file, holds)
    if not _is_number(value):
        raise ValueError(f"{file}: {path} = {value!r}: it should hold {holds}")
    return float(value)


def _is_number(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= sys.float_info.max
