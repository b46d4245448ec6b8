"""Walls as LAMMPS's regions: a rectangle is a block with one face, a tube a cylinder without ends; both felt from both sides."""

import math

import numpy as np

from sim.engine.walls import Cylinder, Plane, Rectangle, Slide, Vector, Wall, unit
from sim.engine.world import World
from sim.lammps.contact import words

AXES = "xyz"
FAR_M = 100.0


def wall_lines(world: World) -> list[str]:
    """The commands that make all walls; ValueError names one that cannot be written."""
    lines = []
    for wall in world.walls:
        name = wall.name.replace(" ", "_")
        moves = _moves(wall, name)
        lines += [f"variable {name}_{axis} equal {text}" for axis, text in moves.items()]
        keyword = " move " + " ".join(f"v_{name}_{a}" if a in moves else "NULL" for a in AXES) if moves else ""
        lines.append(f"region {name} {_shape(wall)}{keyword}")
        lines.append(f"fix {name} touching wall/gran/region granular {words(world, wall.material.name)} region {name}")
    return lines


def _shape(wall: Wall) -> str:
    """The region's style and numbers."""
    if isinstance(wall, Plane):
        return "plane " + " ".join(f"{v:.12g}" for v in (*wall.point, *unit("normal", wall.normal)))
    if isinstance(wall, Rectangle):
        return _rectangle(wall)
    if isinstance(wall, Cylinder):
        start, along = np.asarray(wall.start, float), np.asarray(wall.end, float) - np.asarray(wall.start, float)
        axis = _axis_of(along)
        if axis is None:
            raise ValueError(f"wall {wall.name!r}: the LAMMPS input holds cylinders along x, y or z, not along {along}")
        across = [start[k] for k in range(3) if k != axis]
        low, high = sorted((start[axis], start[axis] + along[axis]))
        numbers = " ".join(f"{v:.12g}" for v in (*across, wall.radius, low, high))
        return f"cylinder {AXES[axis]} {numbers} open 1 open 2"
    raise ValueError(f"wall {wall.name!r}: the LAMMPS input holds planes, rectangles and cylinders, not meshes")


def _axis_of(vector: np.ndarray) -> int | None:
    """Which axis a vector lies along, None: none."""
    along = np.abs(vector) > 1e-12 * np.linalg.norm(vector)
    return int(np.argmax(along)) if along.sum() == 1 else None


def _rectangle(wall: Rectangle) -> str:
    """One face of a block, the others open: LAMMPS then knows no inside of it."""
    a, b = np.asarray(wall.a, float), np.asarray(wall.b, float)
    one, two = _axis_of(a), _axis_of(b)
    if one is None or two is None:
        raise ValueError(f"wall {wall.name!r}: the LAMMPS input holds rectangles along the axes only; of a tilted one take a Plane")
    across = 3 - one - two
    low = np.asarray(wall.corner, float) + np.minimum(a, 0.0) + np.minimum(b, 0.0)
    high = np.asarray(wall.corner, float) + np.maximum(a, 0.0) + np.maximum(b, 0.0)
    high[across] = low[across] + 1.0
    face = 2 * across + 1
    numbers = " ".join(f"{v:.12g}" for pair in zip(low, high, strict=True) for v in pair)
    return f"block {numbers} " + " ".join(f"open {k}" for k in range(1, 7) if k != face)


def _moves(wall: Wall, name: str) -> dict[str, str]:
    """Axis → displacement as a formula of the time, of a wall that slides steadily; one whose rate is 0 stands."""
    found: dict[str, str] = {}
    for move in wall.moves:
        numbers = dict(zip((p.name for p in move.law.law.parameters), move.law.numbers, strict=True))
        if not isinstance(move, Slide) or move.law.law.name != "motion_steady":
            raise ValueError(f"wall {wall.name!r}: the LAMMPS input holds steady slides only, not {move.law.law.name!r}")
        if numbers["rate"] == 0.0:
            continue
        for axis, share in zip(AXES, unit("direction", move.direction), strict=True):
            if share == 0.0:
                continue
            if axis in found:
                raise ValueError(f"wall {wall.name!r}: the LAMMPS input holds one slide along {axis}")
            rate, begin, end = numbers["rate"] * share, numbers["start"], numbers["start"] + numbers["duration"]
            way = f"{rate:.12g}*(time-{begin:.12g})" if begin else f"{rate:.12g}*time"
            stop = f"{rate * (end - begin):.12g}"
            found[axis] = f'"ternary(time<{begin:.12g},0,ternary(time>={end:.12g},{stop},{way}))"'
    return found


def _three(v: np.ndarray) -> Vector:
    return float(v[0]), float(v[1]), float(v[2])


def tilted_as_planes(walls: list[Wall]) -> list[Wall]:
    """The same walls, tilted rectangles as endless planes that look upward."""
    made: list[Wall] = []
    for wall in walls:
        if isinstance(wall, Rectangle):
            normal = unit("normal", tuple(np.cross(wall.a, wall.b)))
            if _axis_of(normal) is None:
                up = _three(normal * math.copysign(1.0, normal[2]))
                made.append(Plane(wall.name, wall.material, wall.corner, up, wall.moves))
                continue
        made.append(wall)
    return made
