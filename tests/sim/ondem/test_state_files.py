"""A state written in the ON-DEM network's format: laid out as its schema and VTK's say,
read back as it was; what is not such a file is refused in a sentence."""

import h5py
import numpy as np
import pytest
from scenes import NO_AIR

from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.engine.lists import relist
from benchtwin.sim.engine.observe import Settled
from benchtwin.sim.engine.step import init, run, tables_of
from benchtwin.sim.engine.walls import Cylinder, Slide, box
from benchtwin.sim.engine.world import Scattered, World
from benchtwin.sim.laws import LAWS
from benchtwin.sim.material import Q235, SOYBEAN, SOYBEAN_Q235, SOYBEAN_SOYBEAN
from benchtwin.sim.ondem import UNITS
from benchtwin.sim.ondem.interactions import interactions
from benchtwin.sim.ondem.read import NONE_READ, read_state
from benchtwin.sim.ondem.write import write_state
from benchtwin.sim.rotation import turned
from benchtwin.sim.seed import Seed

SOFT = SOYBEAN.softened(1e7)
CONTACTS = (SOYBEAN_Q235, SOYBEAN_SOYBEAN)
BEAN = Seed.from_dimensions(8.72e-3, 6.84e-3, 5.98e-3)
OTHER = Seed.from_dimensions(7.5e-3, 6.5e-3, 6.0e-3)
BALL = Seed.from_spheres([[0, 0, 0]], [3e-3])
STANDS = (Slide(LAWS["motion_steady"].use(rate=0.0), (0, 0, 1)),)
POST = Cylinder("post", Q235, (0.06, 0, 0), (0.06, 0, 0.02), 3e-3, STANDS)
WALLS = (POST, *box("box", Q235, (0, 0, 0), (0.04, 0.04, 0.15)))


def world_of(*groups) -> World:
    return World(groups, WALLS, CONTACTS, NO_AIR)


@pytest.fixture(scope="module")
def heap():
    """60 seeds of two shapes and 20 balls that have come to rest in a box."""
    beans = Scattered((BEAN, OTHER), SOFT, 60, (0, 0, 0), (0.04, 0.04, 0.1))
    balls = Scattered((BALL,), SOFT, 20, (0, 0, 0.1), (0.04, 0.04, 0.15))
    world = world_of(beans, balls)
    state = run(world, init(world, np.random.default_rng(4)), Settled(0.02, 1e-2, 1e-6))
    return world, state


@pytest.fixture(scope="module")
def file(heap, tmp_path_factory):
    out = tmp_path_factory.mktemp("ondem") / "heap.vtkhdf"
    write_state(out, *heap)
    return out


def test_contacts_carry_the_heap(heap):
    """Springs and weight balance for every seed: at rest to a hundredth of the weight,
    as the seeds' last motion leaves it."""
    world, state = heap
    found = interactions(world, state)
    force = found.pressing_n[:, None] * found.normals + found.shear_n
    total = np.zeros((state.count, 3))
    np.add.at(total, state.owner[found.first], force)
    between = ~found.on_wall
    np.add.at(total, state.owner[found.second[between]], -force[between])
    weight = state.motion[:, 9] * G_M_S2
    total[:, 2] -= weight
    assert np.linalg.norm(total, axis=1).max() < 0.05 * weight.max()
    floor = found.on_wall & (found.normals[:, 2] > 0.99)
    carried = force[found.on_wall, 2].sum()
    assert carried == pytest.approx(weight.sum(), rel=0.01) and floor.sum() > 10


def test_what_is_read_is_what_was_written(heap, file):
    """To rounding: 1e-12 of lengths and speeds, relative."""
    _, state = heap
    saved = read_state(file)
    assert len(saved.shapes) == 3 and saved.time_s == state.time_s
    for read, own in (
        (saved.positions, state.positions),
        (saved.orientations, state.orientations),
        (saved.velocities, state.velocities),
        (saved.spins, state.spins),
    ):
        assert np.array_equal(read, own)
    shapes = [saved.shapes[k] for k in saved.shape_of]
    owns = [(BEAN, OTHER, BALL)[k] for k in state.shapes]
    for read, own in zip(shapes, owns, strict=True):
        assert np.allclose(read.centres_m, own.centres_m, rtol=0, atol=1e-12 * 9e-3)
        assert np.array_equal(read.radii_m, own.radii_m)
        assert np.array_equal(read.inertia_kg_m2, own.inertia_kg_m2)
        assert read.mass_kg == own.mass_kg
        assert read.density_kg_m3 == pytest.approx(own.density_kg_m3, rel=1e-12)


def test_vtk_s_layout(file):
    """The VTKHDF specification of PolyData: offsets, connectivity and data as long as
    they have to be."""
    with h5py.File(file) as held:
        root = held["VTKHDF"]
        assert root.attrs["Type"] == b"PolyData" and list(root.attrs["Version"]) == [
            2,
            0,
        ]
        points = root["NumberOfPoints"][0]
        assert root["Points"].shape == (points, 3)
        assert all(len(column) == points for column in root["PointData"].values())
        cells = 0
        for section in ("Vertices", "Lines", "Polygons", "Strips"):
            one = root[section]
            cells += (count := one["NumberOfCells"][0])
            assert len(one["Offsets"]) == count + 1
            assert one["Offsets"][-1] == len(one["Connectivity"])
            assert one["NumberOfConnectivityIds"][0] == len(one["Connectivity"])
        assert cells > 50 and all(len(c) == cells for c in root["CellData"].values())


def test_on_dem_s_fields(heap, file):
    """Mandatory fields of its schema, and what they say: orientations that turn clumps
    into their balls, forces whose sign is the schema's."""
    _, state = heap
    with h5py.File(file) as held:
        assert [u.decode() for u in held["ONDEM/Scene/units"]] == list(UNITS)
        assert held["ONDEM/Scene"].attrs["timestep"] == state.dt
        materials = held["ONDEM/Materials"]
        assert materials["0/density"][()] == SOFT.density_kg_m3
        data, clumps = held["VTKHDF/PointData"], held["ONDEM/Bodies/Clumps"]
        first = data["clump_id"][()] == clumps["body_id"][0]
        turn = clumps["orientation"][0][[3, 0, 1, 2]]
        shape = (BEAN, OTHER, BALL)[state.shapes[0]]
        balls = clumps["position"][0] + turned(turn, shape.centres_m)
        assert np.allclose(data["position"][()][first], balls, rtol=0, atol=1e-12)
        total = np.bincount(data["clump_id"][()] - len(first), data["mass"][()])
        assert np.allclose(total, clumps["mass"], rtol=1e-12)
        found = held["ONDEM/Interactions"]
        ids = np.concatenate([data["body_id"], held["ONDEM/Bodies/Facets/body_id"]])
        assert (
            set(found["id2"][()]) <= set(ids) and (found["normal_force"][()] < 0).all()
        )
        reach = data["position"][()][found["id1"][()]] - found["contact_point"]
        outwards = -np.einsum("ij,ij->i", reach, found["normal"])
        assert (outwards > 0).all()  # from id1 to id2
        assert held["ONDEM/Bodies/Facets/vertices"].shape == (5 * 2 + 2 * 48, 3, 3)


def test_vtk_shows_it(heap, file):
    """Read by VTK's own reader, as ParaView does."""
    pytest.importorskip("vtk", reason="a peer: pip install 'benchtwin[bench]'")
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(file))
    reader.Update()
    shown = reader.GetOutput()
    radius = vtk_to_numpy(shown.GetPointData().GetArray("radius"))
    assert np.allclose(
        vtk_to_numpy(shown.GetPoints().GetData())[:, 2].min(), radius.min(), atol=2e-3
    )
    assert vtk_to_numpy(shown.GetPointData().GetArray("orientation")).shape[1] == 4
    force = vtk_to_numpy(shown.GetCellData().GetArray("normal_force"))
    world, state = heap
    found = interactions(world, state)
    assert np.allclose(force, -found.pressing_n[~found.on_wall], rtol=1e-12)


def other_tools(out, **columns):
    """Two spheres of 2 and 3 mm as another tool writes them: no clumps, no contacts."""
    told = {
        "radius": np.array([2e-3, 3e-3]),
        "body_id": np.arange(2),
        "clump_id": np.array([-1, -1]),
        "mass": np.array([1e-5, 3e-5]),
        "inertia": np.tile(np.eye(3).ravel() * 1e-11, (2, 1)),
        "orientation": np.tile([0.0, 0.0, 0.0, 1.0], (2, 1)),
        "velocity": np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]),
    } | columns
    with h5py.File(out, "w") as held:
        held.attrs["file_format"] = "ON-DEM VTKHDF"
        held.attrs["file_format_version"] = "0.1-draft"
        held["VTKHDF/Points"] = np.array([[0.02, 0.02, 2e-3], [0.03, 0.02, 3e-3]])
        for name, values in told.items():
            if values is not None:
                held[f"VTKHDF/PointData/{name}"] = values
        held["ONDEM/Scene/units"] = list(UNITS)
    return out


def test_spheres_of_another_tool_are_a_start(tmp_path):
    saved = read_state(other_tools(tmp_path / "a.vtkhdf"))
    assert [s.radii_m[0] for s in (saved.shapes[k] for k in saved.shape_of)] == [
        *(2e-3, 3e-3),
    ]
    assert saved.velocities[0, 2] == 1.0 and not saved.spins.any()
    state = init(world_of(saved.placed(SOFT)), np.random.default_rng(0))
    assert state.count == 2


def spoilt(change):
    """A file of another tool after `change`."""

    def make(path):
        with h5py.File(other_tools(path), "a") as held:
            change(held)

    return make


def renamed(held):
    held.attrs["file_format"] = "VTKHDF"


def newer(held):
    held.attrs["file_format_version"] = "0.2"


def without_units(held):
    del held["ONDEM/Scene/units"]


def in_millimetres(held):
    without_units(held)
    held["ONDEM/Scene/units"] = ["second", "millimeter", "kilogram"]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda p: p.write_bytes(b"x" * 99),
            "no HDF5 file, LAMMPS dump or VTK file, or a damaged one",
        ),
        (lambda p: None, "no such file"),
        (lambda p: p.mkdir(), "is a folder"),
        (spoilt(renamed), "of format 'VTKHDF', not 'ON-DEM VTKHDF'"),
        (spoilt(newer), "of version 0.2 of the ON-DEM format; this benchtwin reads up"),
        (spoilt(without_units), "ONDEM/Scene/units is not there"),
        (spoilt(in_millimetres), "units second, millimeter, kilogram; only second"),
        (lambda p: other_tools(p, radius=None), "PointData/radius is not there"),
        (lambda p: other_tools(p, clump_id=None), "PointData/clump_id is not there"),
        (
            lambda p: other_tools(p, clump_id=np.array([5, 5])),
            "its clumps' centres, masses and inertias are not there",
        ),
        (
            lambda p: other_tools(p, radius=np.array([1e-3, np.nan])),
            "radius: not all of it are finite numbers",
        ),
        (
            lambda p: other_tools(p, orientation=np.zeros((2, 4))),
            "not all are unit quaternions",
        ),
    ],
)
def test_what_is_no_start_is_refused_in_a_sentence(tmp_path, make, words):
    make(tmp_path / "a.vtkhdf")
    with pytest.raises(ValueError, match=r"a\.vtkhdf: ") as refused:
        read_state(tmp_path / "a.vtkhdf")
    assert words in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.parametrize("share", [0.01, 0.3, 0.6, 0.9, 0.999])
def test_a_file_that_was_cut_off_is_refused(file, tmp_path, share):
    raw = file.read_bytes()
    (tmp_path / "a.vtkhdf").write_bytes(raw[: int(share * len(raw))])
    with pytest.raises(ValueError, match=NONE_READ):
        read_state(tmp_path / "a.vtkhdf")


def test_a_full_disk_leaves_nothing(heap, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("benchtwin.sim.ondem.write._interactions", full)
    with pytest.raises(OSError, match="No space left"):
        write_state(tmp_path / "heap.vtkhdf", *heap)
    assert list(tmp_path.iterdir()) == []


def test_seeds_that_left_are_left_out(heap, tmp_path):
    """Ids go on without gaps where seeds have left the domain, 15 mm high here."""
    world, state = heap
    low = relist(tables_of(world), state, ((0, 0, 0), (0.04, 0.04, 0.015)))
    assert 0 < low.count < state.count and low.ids.max() >= low.count
    write_state(tmp_path / "a.vtkhdf", world, low)
    saved = read_state(tmp_path / "a.vtkhdf")
    assert np.array_equal(saved.positions, low.positions)
    own = [(BEAN, OTHER, BALL)[k].mass_kg for k in low.shapes]
    assert [saved.shapes[k].mass_kg for k in saved.shape_of] == own


@pytest.mark.parametrize("how", ["link", "storage", "virtual"])
def test_another_file_s_bytes_are_not_read(file, tmp_path, how):
    """A file from elsewhere may name any file of this machine in the place of its
    numbers."""
    out, secret = tmp_path / "a.vtkhdf", tmp_path / "secret"
    out.write_bytes(file.read_bytes())
    secret.write_bytes(bytes(8 * 80))
    with h5py.File(out, "a") as held:
        data = held["VTKHDF/PointData"]
        shape = data["radius"].shape
        del data["radius"]
        if how == "link":
            data["radius"] = h5py.ExternalLink("other.h5", "/radius")
        elif how == "storage":
            data.create_dataset("radius", shape, "f8", external=str(secret))
        else:
            layout = h5py.VirtualLayout(shape, "f8")
            layout[:] = h5py.VirtualSource("other.h5", "radius", shape)
            data.create_virtual_dataset("radius", layout)
    with pytest.raises(
        ValueError, match=r"VTKHDF/PointData/radius: .* none is followed"
    ):
        read_state(out)
