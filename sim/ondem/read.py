"""Reads the heap of a file: an ON-DEM file, ours or another tool's of spheres and
clumps, or one that `foreign` reads."""

import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from benchtwin.sim.engine.world import Placed
from benchtwin.sim.material import Material
from benchtwin.sim.ondem import FORMAT, UNITS, VERSION, Unfit
from benchtwin.sim.ondem.foreign import read_foreign, seed_of
from benchtwin.sim.rotation import turned
from benchtwin.sim.seed import Seed

if TYPE_CHECKING:
    from h5py import File, Group

# what a ball needs: without it there is no start
NEEDED = ("radius", "body_id", "clump_id", "mass", "inertia", "orientation")
ROUNDING = 1e-12  # of a radius: closer to an axis, a ball is on it
NONE_READ = "no HDF5 file, LAMMPS dump or VTK file, or a damaged one"
MOVING = ("velocity", "angular_velocity")


@dataclass(frozen=True, eq=False)
class Saved:
    """What a file holds. shapes, shape_of (n,): of each seed; positions (n, 3) [m] of
    centres of mass; orientations (n, 4) unit quaternions (w, x, y, z); velocities,
    spins (n, 3) [m/s, rad/s]; time_s."""

    shapes: tuple[Seed, ...]
    shape_of: np.ndarray
    positions: np.ndarray
    orientations: np.ndarray
    velocities: np.ndarray
    spins: np.ndarray
    time_s: float

    def placed(self, material: Material) -> Placed:
        """The seeds as a group of a world."""
        return Placed(
            self.shapes,
            material,
            self.positions,
            self.orientations,
            self.velocities,
            self.spins,
            self.shape_of,
        )


def read_state(file: Path) -> Saved:
    """What a file holds; ValueError, in a sentence that names the file, for one that is
    damaged, newer, or lacks what a start needs."""
    import h5py

    try:
        if (told := read_foreign(file)) is not None:
            return Saved(**told)
        with h5py.File(file) as held:
            _check_own(held)
            _check(held)
            return _read(held)
    except FileNotFoundError:
        raise ValueError(f"{file}: no such file") from None
    except IsADirectoryError:
        raise ValueError(f"{file}: is a folder, not a file") from None
    except OSError:
        raise ValueError(
            f"{file}: no HDF5 file, LAMMPS dump or VTK file, or a damaged one"
        ) from None
    except (ValueError, KeyError) as error:
        raise ValueError(f"{file}: {error.args[0]}") from None


def _check_own(held: "File") -> None:
    """Unfit for a file that points at another, whose bytes would be read in its
    place."""
    import h5py

    def look(name: str, what: "h5py.Group | h5py.Dataset") -> None:
        if isinstance(what, h5py.Dataset):
            if what.external or what.is_virtual:
                raise Unfit(
                    f"{name}: its numbers lie in another file; none is followed"
                )
            return
        for link in what:
            if isinstance(what.get(link, getlink=True), h5py.ExternalLink):
                where = f"{name}/{link}".lstrip("/")
                raise Unfit(f"{where}: is a link into another file; none is followed")

    look("", held)
    held.visititems(look)


def _check(held: "File") -> None:
    """Unfit for a file of another format, a newer version, or without units."""
    told = held.attrs.get("file_format")
    if _text(told) != FORMAT:
        what = (
            f"of format {_text(told)!r}" if told is not None else "of no stated format"
        )
        raise Unfit(f"an HDF5 file {what}, not {FORMAT!r}")
    written = _text(held.attrs.get("file_format_version", ""))
    if _number(written) > _number(VERSION):
        raise Unfit(
            f"of version {written} of the ON-DEM format; this benchtwin reads up to"
            f" {VERSION}"
        )
    if "ONDEM/Scene/units" not in held:
        raise Unfit("ONDEM/Scene/units is not there: in which units its numbers are")
    units = tuple(_text(u) for u in held["ONDEM/Scene/units"][()])
    if units != UNITS:
        raise Unfit(f"units {', '.join(units)}; only {', '.join(UNITS)} are read")


def _text(value: object) -> str:
    return value.decode("utf8", "replace") if isinstance(value, bytes) else str(value)


def _number(text: str) -> tuple[int, ...]:
    """ "0.1-draft" as (0, 1)."""
    found = re.match(r"\d+(\.\d+)*", text)
    return tuple(int(part) for part in found[0].split(".")) if found else (0,)


def _read(held: "File") -> Saved:
    if "VTKHDF/PointData" not in held:
        raise Unfit("VTKHDF/PointData is not there: it holds no bodies")
    data = held["VTKHDF/PointData"]
    if missing := [name for name in NEEDED if name not in data]:
        raise Unfit(f"VTKHDF/PointData/{missing[0]} is not there; a start needs it")
    radii = _finite(data, "radius")
    if not len(radii):
        raise Unfit("no bodies are in it")
    if not (radii > 0).all():
        raise Unfit("VTKHDF/PointData/radius: not all are above 0")
    clump = data["clump_id"][()].astype(int)
    if "ONDEM/Bodies/Clumps" in held:
        saved = _of_clumps(held, held["ONDEM/Bodies/Clumps"], radii)
    elif (clump >= 0).any():
        raise Unfit(
            "its clumps' centres, masses and inertias are not there"
            " (ONDEM/Bodies/Clumps); a start needs them"
        )
    else:
        saved = _of_balls(held, data, radii)
    time_s = float(held["ONDEM/Scene"].attrs.get("time", 0.0))
    return replace(saved, time_s=time_s)


def _finite(group: "Group", name: str, width: int = 0) -> np.ndarray:
    """A column of a group; Unfit where it is not all finite, or of another width."""
    values = np.asarray(group[name][()], float)
    if not np.isfinite(values).all() or values.shape[1:] != ((width,) if width else ()):
        raise Unfit(f"{group.name}/{name}: not all of it are finite numbers")
    return values


def _placed(group: "Group", points: np.ndarray) -> dict[str, np.ndarray]:
    """Where bodies are and how they move; what is not said of their motion is 0."""
    turn = _finite(group, "orientation", 4)[:, [3, 0, 1, 2]]
    length = np.linalg.norm(turn, axis=1)
    if not np.allclose(length, 1.0, atol=1e-6):
        raise Unfit(f"{group.name}/orientation: not all are unit quaternions")
    moving = [
        _finite(group, name, 3) if name in group else np.zeros_like(points)
        for name in MOVING
    ]
    return {
        "positions": points,
        "orientations": turn,
        "velocities": moving[0],
        "spins": moving[1],
    }


def _of_balls(held: "File", data: "Group", radii: np.ndarray) -> Saved:
    """Every ball a seed of its own."""
    masses, moments = _finite(data, "mass"), _finite(data, "inertia", 9)[:, [0, 4, 8]]
    told = np.column_stack([radii, masses, moments])
    different, of = np.unique(told, axis=0, return_inverse=True)
    shapes = tuple(
        seed_of(np.zeros((1, 3)), row[:1], row[1], row[2:]) for row in different
    )
    points = np.asarray(held["VTKHDF/Points"][()], float)
    return Saved(shapes, of.ravel(), **_placed(data, points), time_s=0.0)


def _of_clumps(held: "File", group: "Group", radii: np.ndarray) -> Saved:
    """Seeds of several balls, and of one."""
    where = _placed(group, _finite(group, "position", 3))
    owner = _owner(held, group)
    back = where["orientations"] * [1.0, -1.0, -1.0, -1.0]
    arms = np.asarray(held["VTKHDF/Points"][()], float) - where["positions"][owner]
    centres = turned(back[owner], arms)
    shape_of = group["shape_id"][()] if "shape_id" in group else np.arange(len(back))
    _, first, of = np.unique(shape_of, return_index=True, return_inverse=True)
    mass, moments = _finite(group, "mass"), _finite(group, "inertia", 9)[:, [0, 4, 8]]
    shapes = []
    for k in first:
        mine = owner == k
        if not mine.any():
            raise Unfit(f"{group.name}: clump {k} has no balls")
        sizes = group["dimensions"][k] if "dimensions" in group else np.full(3, np.nan)
        known = sizes if np.isfinite(sizes).all() else None
        volume = float(group["volume"][k]) if "volume" in group else np.nan
        local, own = centres[mine], radii[mine]
        local[abs(local) < ROUNDING * own.max()] = 0.0
        shapes.append(seed_of(local, own, mass[k], moments[k], known, volume))
    return Saved(tuple(shapes), of.ravel(), **where, time_s=0.0)


def _owner(held: "File", group: "Group") -> np.ndarray:
    """Which row of the clumps each ball belongs to."""
    clump = held["VTKHDF/PointData/clump_id"][()].astype(int)
    row = {int(b): k for k, b in enumerate(group["body_id"][()])}
    if lost := set(clump.tolist()) - set(row):
        raise Unfit(f"clump {min(lost)} is not in ONDEM/Bodies/Clumps")
    return np.array([row[int(c)] for c in clump])
