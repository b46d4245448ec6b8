"""Walls as LAMMPS's regions: a rectangle is a block with one face, a tube a cylinder
without ends, which may turn about its axis; both felt from both sides.

A tilted rectangle is a level one that is turned about the edge's axis, the same way in
which a plate is raised."""

import math
from dataclasses import dataclass

import numpy as np

from benchtwin.sim.engine.walls import (
    Cylinder,
    Plane,
    Rectangle,
    Slide,
    Turn,
    Vector,
    Wall,
    unit,
)
from benchtwin.sim.engine.world import World
from benchtwin.sim.lammps.contact import words

AXES = "xyz"


@dataclass(frozen=True)
class Turned:
    """By which angle [rad] about an axis (0 x, 1 y, 2 z; right-handed) through `pivot`
    a level wall stands as it is at t = 0."""

    angle: float
    axis: int
    pivot: Vector


def name_of(wall: Wall) -> str:
    """The name of its region and its fix."""
    return wall.name.replace(" ", "_")


def wall_lines(world: World, *, contacts: bool = False) -> list[str]:
    """The commands that make all walls; ValueError names one that cannot be written.
    contacts: loads are asked for."""
    lines = []
    for wall in world.walls:
        name, moves = name_of(wall), _slides(wall)
        turned = _turn_of(wall)
        lines += [
            f"variable {name}_{axis} equal {text}" for axis, text in moves.items()
        ]
        keyword = (
            " move " + " ".join(f"v_{name}_{a}" if a in moves else "NULL" for a in AXES)
            if moves
            else ""
        )
        if turned is not None:
            lines.append(f"variable {name}_turn equal {_angle(wall, turned)}")
            point = " ".join(f"{v:.12g}" for v in turned.pivot)
            keyword += f" rotate v_{name}_turn {point} " + " ".join(
                str(int(k == turned.axis)) for k in range(3)
            )
        lines.append(f"region {name} {_shape(wall, turned)}{keyword}")
        how = (
            f"wall/gran/region granular {words(world, wall.material.name)} region"
            f" {name}"
        )
        lines.append(f"fix {name} touching {how}" + (" contacts" if contacts else ""))
    return lines


def _shape(wall: Wall, turned: Turned | None) -> str:
    """The region's style and numbers."""
    if isinstance(wall, Plane):
        return "plane " + " ".join(
            f"{v:.12g}" for v in (*wall.point, *unit("normal", wall.normal))
        )
    if isinstance(wall, Rectangle):
        return _block(*_level(wall, turned))
    if isinstance(wall, Cylinder):
        start = np.asarray(wall.start, float)
        along = np.asarray(wall.end, float) - np.asarray(wall.start, float)
        axis = _axis_of(along)
        if axis is None:
            raise ValueError(
                f"wall {wall.name!r}: the LAMMPS input holds cylinders along x, y or z,"
                f" not along {along}"
            )
        across = [start[k] for k in range(3) if k != axis]
        low, high = sorted((start[axis], start[axis] + along[axis]))
        numbers = " ".join(f"{v:.12g}" for v in (*across, wall.radius, low, high))
        return f"cylinder {AXES[axis]} {numbers} open 1 open 2"
    raise ValueError(
        f"wall {wall.name!r}: the LAMMPS input holds planes, rectangles and cylinders,"
        " not meshes"
    )


def _axis_of(vector: np.ndarray) -> int | None:
    """Which axis a vector lies along, None: none."""
    along = np.abs(vector) > 1e-12 * np.linalg.norm(vector)
    return int(np.argmax(along)) if along.sum() == 1 else None


def _turn_of(wall: Wall) -> Turned | None:
    """How a wall that is tilted, or that turns, comes from a level one; None:
    neither."""
    turns = [m for m in wall.moves if isinstance(m, Turn)]
    if isinstance(wall, Rectangle):
        return _turned(wall, turns)
    if not turns:
        return None
    if not isinstance(wall, Cylinder):
        raise ValueError(
            f"wall {wall.name!r}: the LAMMPS input turns rectangles and cylinders only"
        )
    along = unit("axis", np.asarray(wall.end, float) - np.asarray(wall.start, float))
    turn, off = turns[0], np.asarray(turns[0].pivot, float) - wall.start
    own = np.linalg.norm(off - (off @ along) * along) < 1e-9 * wall.radius
    axis = _axis_of(np.asarray(turn.axis, float))
    if axis is None or not own or axis != _axis_of(along) or len(turns) > 1:
        raise ValueError(
            f"wall {wall.name!r}: the LAMMPS input turns a cylinder about its own axis"
            " only, along x, y or z"
        )
    return Turned(0.0, axis, turn.pivot)


def _turned(wall: Rectangle, turns: list[Turn]) -> Turned | None:
    """How a rectangle that is tilted, or that turns, comes from a level one; None:
    neither.

    ValueError where neither edge, or not the turn, is along an axis.
    """
    edges = (np.asarray(wall.a, float), np.asarray(wall.b, float))
    along = [_axis_of(edge) for edge in edges]
    if None not in along and not turns:
        return None
    if turns:
        axis = _axis_of(np.asarray(turns[0].axis, float))
    else:
        axis = next((k for k in along if k is not None), None)
    if axis is None or axis not in along or len(turns) > 1:
        raise ValueError(
            f"wall {wall.name!r}: the LAMMPS input holds rectangles that are tilted"
            " about one edge along x, y or z"
        )
    other = edges[1 - along.index(axis)]
    one, two = (axis + 1) % 3, (axis + 2) % 3
    angle = math.atan2(other[two], other[one])
    return Turned(angle, axis, turns[0].pivot if turns else wall.corner)


def _level(
    wall: Rectangle, turned: Turned | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Corner and edges before the turn."""
    corner, a, b = (np.asarray(v, float) for v in (wall.corner, wall.a, wall.b))
    if turned is None:
        return corner, a, b
    one, two = (turned.axis + 1) % 3, (turned.axis + 2) % 3
    back = np.eye(3)
    c, s = math.cos(turned.angle), math.sin(turned.angle)
    back[one, one] = back[two, two] = c
    back[one, two], back[two, one] = s, -s
    pivot = np.asarray(turned.pivot, float)
    a, b = (
        np.where(np.abs(v) < 1e-9 * np.linalg.norm(v), 0.0, v)
        for v in (back @ a, back @ b)
    )
    return pivot + back @ (corner - pivot), a, b


def _block(corner: np.ndarray, a: np.ndarray, b: np.ndarray) -> str:
    """One face of a block, the others open: LAMMPS then knows no inside of it."""
    one, two = _axis_of(a), _axis_of(b)
    assert one is not None and two is not None
    across = 3 - one - two
    low, high = (
        corner + pick(a, 0.0) + pick(b, 0.0) for pick in (np.minimum, np.maximum)
    )
    high[across] = low[across] + 1.0
    face = 2 * across + 1
    numbers = " ".join(
        f"{v:.12g}" for pair in zip(low, high, strict=True) for v in pair
    )
    return f"block {numbers} " + " ".join(f"open {k}" for k in range(1, 7) if k != face)


def _numbers(wall: Wall, move: Slide | Turn) -> dict[str, float]:
    """Rate, start and duration of a steady motion; ValueError for another."""
    if move.law.law.name != "motion_steady":
        raise ValueError(
            f"wall {wall.name!r}: the LAMMPS input holds steady motions only, not"
            f" {move.law.law.name!r}"
        )
    return dict(
        zip((p.name for p in move.law.law.parameters), move.law.numbers, strict=True)
    )


def _slides(wall: Wall) -> dict[str, str]:
    """Axis → displacement as a formula of the time, of a wall that slides steadily; one
    whose rate is 0 stands."""
    found: dict[str, str] = {}
    for move in wall.moves:
        numbers = _numbers(wall, move)
        if isinstance(move, Turn) or numbers["rate"] == 0.0:
            continue
        for axis, share in zip(AXES, unit("direction", move.direction), strict=True):
            if share == 0.0:
                continue
            if axis in found:
                raise ValueError(
                    f"wall {wall.name!r}: the LAMMPS input holds one slide along {axis}"
                )
            found[axis] = f'"{_way(numbers, share)}"'
    return found


def _angle(wall: Wall, turned: Turned) -> str:
    """The angle as a formula of the time."""
    text = f"{turned.angle:.12g}"
    for move in wall.moves:
        if isinstance(move, Turn):
            share = float(unit("axis", move.axis)[turned.axis])
            text += f"+{_way(_numbers(wall, move), share)}"
    return f'"{text}"'


def _way(numbers: dict[str, float], share: float) -> str:
    """A steady motion's way as a formula of the time, `share` of it."""
    rate = numbers["rate"] * share
    begin = numbers["start"]
    end = numbers["start"] + numbers["duration"]
    way = f"{rate:.12g}*(time-{begin:.12g})" if begin else f"{rate:.12g}*time"
    stop = f"{rate * (end - begin):.12g}"
    return f"ternary(time<{begin:.12g},0,ternary(time>={end:.12g},{stop},{way}))"
