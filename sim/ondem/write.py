"""Writes a state as an ON-DEM file."""

from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from benchtwin.bench.whole_file import whole
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.walls import Balls, Cylinder, Mesh, Plane, Rectangle, Wall
from benchtwin.sim.engine.world import World
from benchtwin.sim.ondem import FORMAT, UNITS, VERSION
from benchtwin.sim.ondem.interactions import Interactions, interactions
from benchtwin.sim.seed import Seed
from benchtwin.sim.seed.surface import crosses, union_mesh

if TYPE_CHECKING:
    from h5py import Group

AROUND = 48  # flat pieces that a cylinder is written as
SECTIONS = ("Vertices", "Lines", "Polygons", "Strips")


def write_state(file: Path, world: World, state: State) -> None:
    """The state of a world as `file`, which appears whole or not at all. OSError where
    it cannot be written."""
    import h5py

    with whole(file) as part, h5py.File(part, "w", locking=False) as out:
        out.attrs["file_format"] = FORMAT
        out.attrs["file_format_version"] = VERSION
        out.attrs["source_code"] = f"benchtwin {version('benchtwin')}"
        _write(out, world, state)


def _write(out: "Group", world: World, state: State) -> None:
    balls, found = np.argsort(state.ball_id), interactions(world, state)
    row = np.argsort(balls)  # of each ball, in the file
    seeds = np.argsort(state.ids)
    shapes = tuple(shape for group in world.seeds for shape in group.shapes)
    _scene(out.create_group("ONDEM/Scene"), world, state)
    _materials(out["ONDEM"], world)
    _balls(out.create_group("VTKHDF"), state, balls, seeds)
    _clumps(out.create_group("ONDEM/Bodies/Clumps"), state, shapes, seeds)
    _walls(out["ONDEM/Bodies"], world, state)
    _lines(out["VTKHDF"], found, row)
    first_wall = len(balls) + len(seeds)
    _interactions(out.create_group("ONDEM/Interactions"), found, row, first_wall)


def _put(group: "Group", **columns: ArrayLike) -> None:
    for name, values in columns.items():
        group.create_dataset(name, data=values)


def _words(group: "Group", name: str, texts: list[str]) -> None:
    import h5py

    group.create_dataset(name, data=texts, dtype=h5py.string_dtype())


def _scene(group: "Group", world: World, state: State) -> None:
    group.attrs["time"], group.attrs["timestep"] = state.time_s, state.dt
    _put(group, gravity=np.asarray(world.gravity, float))
    _words(group, "units", list(UNITS))


def _materials(group: "Group", world: World) -> None:
    names = list(world.materials)
    for k, material in enumerate(world.materials.values()):
        one = group.create_group(f"Materials/{k}")
        _put(
            one,
            id=k,
            density=material.density_kg_m3,
            young_modulus=material.young_modulus_pa,
            poisson_ratio=material.poisson_ratio,
        )
        one.create_dataset("label", data=material.name)
    pairs = [c for c in world.contacts if set(c.between) <= set(names)]
    _put(
        group.create_group("Contacts"),
        material_id1=[names.index(c.between[0]) for c in pairs],
        material_id2=[names.index(c.between[1]) for c in pairs],
        restitution=[c.restitution for c in pairs],
        shear_friction=[c.static_friction for c in pairs],
        rolling_friction=[c.rolling_friction for c in pairs],
    )
    _words(
        group["Contacts"], "rolling_convention", [c.rolling_convention for c in pairs]
    )


def _balls(group: "Group", state: State, balls: np.ndarray, seeds: np.ndarray) -> None:
    """Points and what each carries. A seed's balls share its mass by volume."""
    count, owner = len(balls), state.owner[balls].astype(int)
    centres, radii = state.ball[balls, :3], state.ball[balls, 3]
    volume = 4.0 / 3.0 * np.pi * radii**3
    total = np.bincount(owner, volume, minlength=len(seeds))[owner]
    mass = state.motion[owner, 9] * volume / total
    place = np.argsort(seeds)  # of each seed, in the file
    spin = state.motion[owner, 6:9]
    arm = centres - state.motion[owner, :3]
    group.attrs["Type"] = np.bytes_("PolyData")
    group.attrs["Version"] = np.array([2, 0], np.int64)
    _put(group, Points=centres, NumberOfPoints=np.array([count], np.int64))
    for section in SECTIONS:
        _cells(group.create_group(section), np.zeros((0, 2), np.int64))
    data = group.create_group("PointData")
    data.attrs["Scalars"] = "radius"
    _put(
        data,
        body_id=np.arange(count),
        clump_id=count + place[owner],
        material_id=state.material[owner].astype(np.int64),
        radius=radii,
        mass=mass,
        volume=volume,
        inertia=_tensors(np.repeat((0.4 * mass * radii**2)[:, None], 3, axis=1)),
        position=centres,
        velocity=state.motion[owner, 3:6] + np.cross(spin, arm),
        orientation=state.turn[owner][:, [1, 2, 3, 0]],
        angular_velocity=spin,
    )


def _tensors(moments: np.ndarray) -> np.ndarray:
    """Principal moments (n, 3) as tensors in the principal frame, row by row (n, 9)."""
    out = np.zeros((len(moments), 9))
    out[:, [0, 4, 8]] = moments
    return out


def _clumps(
    group: "Group", state: State, shapes: tuple[Seed, ...], seeds: np.ndarray
) -> None:
    """A row a seed, those of one ball too. shape_id: seeds of one are alike;
    dimensions: of the ellipsoid that it stands for, NaN where it stands for none."""
    motion, shape = state.motion[seeds], state.shape_of[seeds].astype(int)
    moments = np.array([s.inertia_kg_m2 for s in shapes], float)
    unknown = np.full(3, np.nan)
    sizes = [unknown if s.dimensions_m is None else s.dimensions_m for s in shapes]
    group.attrs["count"], group.attrs["shape_type"] = len(seeds), "clump"
    _put(
        group,
        body_id=len(state.ball) + np.arange(len(seeds)),
        material_id=state.material[seeds].astype(np.int64),
        position=motion[:, :3],
        velocity=motion[:, 3:6],
        orientation=state.turn[seeds][:, [1, 2, 3, 0]],
        angular_velocity=motion[:, 6:9],
        mass=motion[:, 9],
        inertia=_tensors(moments[shape]),
        volume=np.array([s.volume_m3 for s in shapes])[shape],
        shape_id=shape,
        dimensions=np.array(sizes, float)[shape],
    )


def _walls(group: "Group", world: World, state: State) -> None:
    """Where walls are now, as triangles; endless planes apart."""
    first = len(state.ball) + state.count
    names = list(world.materials)
    rows: list[tuple[int, np.ndarray]] = []
    planes: list[tuple[int, np.ndarray, np.ndarray]] = []
    owner = _owners(world)
    for k, wall in enumerate(world.walls):
        faces = state.prim[owner == k]
        if isinstance(wall, Plane):
            planes.append((k, faces[0, :3], faces[0, 3:6]))
        else:
            rows += [(k, t) for t in triangles(wall, faces)]
    told = {k: names.index(wall.material.name) for k, wall in enumerate(world.walls)}
    facets = group.create_group("Facets")
    vertices = np.array([t for _, t in rows]).reshape(-1, 3, 3)
    corners = np.arange(3 * len(rows)).reshape(-1, 3)
    normals = crosses(vertices.reshape(-1, 3), corners)
    facets.attrs["count"], facets.attrs["shape_type"] = len(rows), "facet"
    _put(
        facets,
        body_id=np.array([first + k for k, _ in rows], np.int64),
        material_id=np.array([told[k] for k, _ in rows], np.int64),
        vertices=vertices,
        normal=normals / np.linalg.norm(normals, axis=1)[:, None],
        position=vertices.mean(axis=1),
    )
    _words(facets, "label", [world.walls[k].name for k, _ in rows])
    endless = group.create_group("Walls")
    endless.attrs["count"], endless.attrs["shape_type"] = len(planes), "wall"
    _put(
        endless,
        body_id=np.array([first + k for k, *_ in planes], np.int64),
        material_id=np.array([told[k] for k, *_ in planes], np.int64),
        position=np.array([p for _, p, _ in planes]).reshape(-1, 3),
        normal=np.array([n for *_, n in planes]).reshape(-1, 3),
    )
    _words(endless, "label", [world.walls[k].name for k, *_ in planes])


def _owners(world: World) -> np.ndarray:
    """Which wall each face belongs to."""
    counts = [len(wall.primitives()[0]) for wall in world.walls]
    return np.repeat(np.arange(len(counts)), counts)


def triangles(wall: Wall, faces: np.ndarray) -> np.ndarray:
    """A wall's surface (n, 3, 3) [m]; faces: its rows of `State.prim`."""
    point, a, b = faces[:, :3], faces[:, 3:6], faces[:, 6:9]
    if isinstance(wall, Balls):
        mesh = union_mesh(point - point.mean(axis=0), faces[:, 9], level=1)
        return (point.mean(axis=0) + mesh.vertices_m)[mesh.faces]
    if isinstance(wall, Mesh):
        return np.stack([point, point + a, point + b], axis=1)
    if isinstance(wall, Rectangle):
        corners = [point[0], point[0] + a[0], point[0] + a[0] + b[0], point[0] + b[0]]
        return np.array(corners)[[[0, 1, 2], [0, 2, 3]]]
    assert isinstance(wall, Cylinder)
    axis = a[0] / np.linalg.norm(a[0])
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    turn = 2 * np.pi * np.arange(AROUND + 1)[:, None] / AROUND
    ring = point[0] + wall.radius * (
        np.cos(turn) * across + np.sin(turn) * np.cross(axis, across)
    )
    low, high = ring, ring + a[0]
    one = np.stack([low[:-1], low[1:], high[1:]], axis=1)
    other = np.stack([low[:-1], high[1:], high[:-1]], axis=1)
    return np.concatenate([one, other])


def _cells(group: "Group", ends: np.ndarray) -> None:
    """Cells of as many points as `ends` (n, points) has columns; what is there is
    replaced."""
    for name in list(group):
        del group[name]
    count, points = ends.shape
    _put(
        group,
        NumberOfCells=np.array([count], np.int64),
        NumberOfConnectivityIds=np.array([ends.size], np.int64),
        Offsets=np.arange(count + 1, dtype=np.int64) * points,
        Connectivity=ends.ravel().astype(np.int64),
    )


def _lines(group: "Group", found: Interactions, row: np.ndarray) -> None:
    """A line a contact between seeds, with its forces."""
    of = ~found.on_wall
    _cells(
        group["Lines"], np.column_stack([row[found.first[of]], row[found.second[of]]])
    )
    _put(
        group.create_group("CellData"),
        normal_force=-found.pressing_n[of],
        shear_force=found.shear_n[of],
        overlap=found.overlaps_m[of],
    )


def _interactions(
    group: "Group", found: Interactions, row: np.ndarray, first_wall: int
) -> None:
    """All contacts."""
    second = np.where(found.on_wall, first_wall + found.second, 0)
    second[~found.on_wall] = row[found.second[~found.on_wall]]
    group.attrs["count"] = len(second)
    group.attrs["model"] = "hertz_mindlin"
    group.attrs["normal_force_sign"] = "positive in traction"
    _put(
        group,
        id1=row[found.first],
        id2=second,
        virtual=np.zeros(len(second), np.int8),
        normal=-found.normals,
        normal_force=-found.pressing_n,
        shear_force=found.shear_n,
        contact_point=found.points,
        overlap=found.overlaps_m,
    )
