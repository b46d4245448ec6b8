"""Heaps in other tools' files, in SI units, as if at rest: text dumps of LAMMPS and
LIGGGHTS (their last frame), and what VTK's library reads (.vtk, .vtp, .vtu), as
LIGGGHTS and YADE write."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from benchtwin.sim.ondem import Unfit
from benchtwin.sim.seed import Seed

Columns = dict[str, np.ndarray]
NEEDED = ("place", "radius", "mass")
# of a ball, by their names in a dump of LAMMPS or LIGGGHTS, and in YADE's files
COLUMNS = {
    **{name: name for name in (*NEEDED, "diameter", "mol")},
    **{"radii": "radius", "id_multisphere": "clump", "clumpId": "clump"},
}


def read_foreign(file: Path) -> dict[str, Any] | None:
    """The fields of `read.Saved`; None: a file of another kind. Balls of one molecule
    or clump are a seed, of the density that their masses and volumes give."""
    with file.open("rb") as opened:
        start = opened.read(5)
    if start == b"ITEM:":
        balls = _of_dump(file.read_text(encoding="utf8", errors="replace"))
    elif start == b"# vtk" or start[:1] == b"<":
        balls = _of_vtk(file, xml=start[:1] == b"<")
    else:
        return None
    if "diameter" in balls:
        balls["radius"] = balls["diameter"] / 2
    if "mol" in balls:  # 0: of no molecule
        balls["clump"] = np.where(balls["mol"] > 0, balls["mol"], -1)
    if missing := [name for name in NEEDED if name not in balls]:
        raise Unfit(f"{missing[0]} of its balls is not there; a start needs it")
    known = np.column_stack([balls[name] for name in NEEDED])
    if not len(known) or not np.isfinite(known).all() or not (known[:, 3:] > 0).all():
        raise Unfit("no balls are in it, or not all places, sizes and masses are good")
    return _seeds(balls)


def _of_dump(text: str) -> Columns:
    items = (item.partition("\n") for item in text.split("ITEM: ")[1:])
    parts = {head.strip(): body for head, _, body in items}  # of the last frame
    if (units := parts.get("UNITS", "si").strip()) != "si":
        raise Unfit(f"units {units}; only si are read")
    head = next((head for head in parts if head.startswith("ATOMS ")), "")
    names = head.split()[1:]
    rows = np.array(parts.get(head, "").split())
    whole = len(rows) == len(names) * int(parts.get("NUMBER OF ATOMS", -1))
    if not names or not whole or not text.endswith("\n"):
        raise Unfit("a damaged LAMMPS dump, or one that was cut off")
    told = dict(zip(names, rows.reshape(-1, len(names)).T, strict=True))
    if {*"xyz"} <= {*told}:
        told["place"] = np.column_stack([told[axis] for axis in "xyz"])
    return {COLUMNS[n]: told[n].astype(float) for n in told if n in COLUMNS}


def _of_vtk(file: Path, *, xml: bool) -> Columns:
    try:
        import vtk
        from vtk.util.numpy_support import vtk_to_numpy
    except ImportError:
        raise Unfit("a VTK file; to read it: pip install 'benchtwin[vtk]'") from None
    vtk.vtkObject.GlobalWarningDisplayOff()
    legacy = vtk.vtkGenericDataObjectReader()
    legacy.ReadAllScalarsOn()
    legacy.ReadAllFieldsOn()
    reader = vtk.vtkXMLGenericDataObjectReader() if xml else legacy
    reader.SetFileName(str(file))
    reader.Update()
    held = reader.GetOutput()
    if not isinstance(held, vtk.vtkPointSet) or not held.GetNumberOfPoints():
        raise Unfit("a VTK file without points, or a damaged one")
    data = held.GetPointData()
    names = [data.GetArrayName(k) for k in range(data.GetNumberOfArrays())]
    told = {COLUMNS[n]: vtk_to_numpy(data.GetArray(n)) for n in names if n in COLUMNS}
    told["place"] = vtk_to_numpy(held.GetPoints().GetData())
    return {name: values.astype(float) for name, values in told.items()}


def _seeds(balls: Columns) -> dict[str, Any]:
    at, radii, mass = (balls[name] for name in NEEDED)
    clump = balls.get("clump", np.full(len(at), -1.0))
    clump = np.where(clump < 0, clump.max() + 1 + np.arange(len(at)), clump)
    order = np.argsort(clump, kind="stable")
    shapes: dict[tuple, Seed] = {}
    rows = []
    for mine in np.split(order, np.flatnonzero(np.diff(clump[order])) + 1):
        if len(mine) == 1:
            key, centre, turn = (radii[mine[0]], mass[mine[0]]), at[mine[0]], np.eye(3)
            moment = np.repeat(0.4 * key[1] * key[0] ** 2, 3)
            seed = seed_of(np.zeros((1, 3)), radii[mine], key[1], moment)
        else:
            density = mass[mine].sum() / (4 / 3 * np.pi * radii[mine] ** 3).sum()
            own = Seed.from_spheres(at[mine], radii[mine], density)
            key, centre, turn = (clump[mine[0]], 0.0), own.origin_m, own.axes
            seed = replace(own, axes=np.eye(3), origin_m=np.zeros(3))
        shapes.setdefault(key, seed)
        rows.append((key, centre, turn))
    numbers = {key: k for k, key in enumerate(shapes)}
    keys, centres, turns = zip(*rows, strict=True)
    return {
        "shapes": tuple(shapes.values()),
        "shape_of": np.array([numbers[key] for key in keys]),
        "positions": np.array(centres),
        "orientations": Rotation.from_matrix(turns).as_quat()[:, [3, 0, 1, 2]],
        "velocities": np.zeros((len(rows), 3)),
        "spins": np.zeros((len(rows), 3)),
        "time_s": 0.0,
    }


def seed_of(
    centres: np.ndarray,
    radii: np.ndarray,
    mass: float,
    moments: np.ndarray,
    sizes: np.ndarray | None = None,
    volume: float = np.nan,
) -> Seed:
    """A seed of balls in its principal frame."""
    if not np.isfinite(volume):
        volume = float(4.0 / 3.0 * np.pi * (radii**3).sum())
    return Seed(
        centres, radii, mass, moments, mass / volume, sizes, np.eye(3), np.zeros(3)
    )
