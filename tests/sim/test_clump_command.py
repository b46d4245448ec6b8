"""`benchtwin clump`: its files against the shape, LAMMPS' own reading of one of them,
and what it refuses."""

import csv
import subprocess

import numpy as np
import pytest
import seed_forms
import trimesh
from lammps_here import installed

from benchtwin.sim.lammps.program import program
from benchtwin.sim.seed.clump_command import DONE, MISUSED, clump_command

SHAPE = seed_forms.superquadric(11e-3, 7.5e-3, 5e-3, across=0.85, along=0.85, taper=0.3)
HOW = {
    "spheres": 6,
    "tolerance": None,
    "unit": "mm",
    "voxel_mm": None,
    "density_kg_m3": 1200.0,
    "overwrite": False,
    "quiet": False,
}


@pytest.fixture
def mesh(tmp_path):
    file = tmp_path / "maize.stl"
    trimesh.Trimesh(1e3 * SHAPE.vertices_m, SHAPE.faces).export(file)
    return file


def test_table_and_files_hold_the_same_balls_and_the_shapes_own_mass(
    mesh, tmp_path, capsys
):
    out = tmp_path / "clump"
    assert clump_command(mesh, out, **HOW) == DONE
    assert "6 balls" in capsys.readouterr().out
    table = np.array(
        [
            [float(v) for v in row.values()]
            for row in csv.DictReader((out / "clump.csv").open())
        ]
    )
    assert table.shape == (6, 4)
    assert np.loadtxt(out / "liggghts.multisphere") == pytest.approx(
        1e-3 * table, rel=1e-6, abs=1e-12
    )
    assert np.loadtxt(out / "edem.spheres.tsv", skiprows=1)[
        :, [1, 2, 3, 0]
    ] == pytest.approx(1e-3 * table, rel=1e-6, abs=1e-12)
    molecule = (out / "lammps.molecule").read_text().splitlines()
    # STL keeps seven digits of every corner
    assert float(
        next(line for line in molecule if line.endswith(" mass")).split()[0]
    ) == pytest.approx(1200 * SHAPE.volume_m3, rel=1e-4)
    moments = [
        float(v)
        for v in next(line for line in molecule if line.endswith(" inertia")).split()[
            :3
        ]
    ]
    assert moments == pytest.approx(
        np.diag(SHAPE.principal()[0].solid.inertia(1200.0)), rel=1e-4
    )
    assert (out / "clump.png").stat().st_size > 2000


@pytest.mark.skipif(not installed(), reason="needs lammps and mpich")
def test_lammps_reads_the_molecule_and_takes_its_mass(mesh, tmp_path):
    out = tmp_path / "clump"
    clump_command(mesh, out, **HOW)
    script = [
        "units si",
        "atom_style hybrid sphere molecular",
        "boundary f f f",
        "newton off",
        "comm_modify vel yes",
        "region box block -0.1 0.1 -0.1 0.1 -0.1 0.1",
        "create_box 1 box",
        "molecule seed lammps.molecule",
        "create_atoms 0 single 0 0 0 mol seed 4928 rotate 0 0 0 1",
        "variable m equal mass(all)",
        "variable n equal atoms",
        'print "found ${n} ${m}" file found.txt',
    ]
    (out / "in.test").write_text("\n".join(script) + "\n")
    lammps = program()
    done = subprocess.run(
        [lammps.executable, "-in", "in.test"],
        cwd=out,
        env=lammps.environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout[-500:]
    _, atoms, mass = (out / "found.txt").read_text().split()
    assert int(atoms) == 6
    assert float(mass) == pytest.approx(1200 * SHAPE.volume_m3, rel=1e-4)


def test_the_fewest_balls_within_the_tolerance(mesh, tmp_path, capsys):
    assert (
        clump_command(
            mesh, tmp_path / "out", **{**HOW, "spheres": None, "tolerance": 0.05}
        )
        == DONE
    )
    said = capsys.readouterr().out
    balls = int(said.split()[0])
    assert float(said.split("surface ")[1].split()[0]) <= 5.0
    assert f"{balls - 1}: " in said  # one fewer was tried, and is not enough
    assert float(said.split(f"{balls - 1}: ")[1].split()[0]) > 5.0


def test_voxels(tmp_path):
    """A ball of voxels: one ball of its radius, within a tenth of a voxel's side."""
    at = np.stack(np.meshgrid(*[np.arange(40) - 19.5] * 3, indexing="ij"))
    np.save(tmp_path / "scan.npy", (at**2).sum(axis=0) < 15**2)
    how = {**HOW, "spheres": 1, "unit": None, "voxel_mm": 0.1}
    assert clump_command(tmp_path / "scan.npy", tmp_path / "out", **how) == DONE
    x, y, z, radius = np.loadtxt(
        tmp_path / "out" / "clump.csv", delimiter=",", skiprows=1
    )
    assert (x, y, z, radius) == pytest.approx((0, 0, 0, 1.5), abs=0.01)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"unit": None}, "in no unit"),
        ({"tolerance": 0.02}, "give one of them"),
        ({"spheres": 21}, "spheres = 21"),
        ({"voxel_mm": 0.1}, "takes --unit"),
        ({"spheres": None, "tolerance": 2.0}, "below 1"),
        ({"density_kg_m3": -1.0}, "density_kg_m3"),
    ],
)
def test_misuse_is_one_sentence_and_writes_nothing(
    mesh, tmp_path, capsys, change, said
):
    assert clump_command(mesh, tmp_path / "out", **{**HOW, **change}) == MISUSED
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_what_is_there_is_kept(mesh, tmp_path, capsys):
    assert clump_command(mesh, tmp_path / "out", **HOW) == DONE
    assert clump_command(mesh, tmp_path / "out", **HOW) == MISUSED
    assert "--overwrite" in capsys.readouterr().err
