"""`simulate --save vtkhdf` and `--start`: a heap out, a heap in."""

import json
import shutil

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from benchtwin.command_line import app
from benchtwin.sim.ondem.read import read_state

SLAB = [
    *("--set", "pile.box_mm=[60,20,200]", "--set", "pile.gate_mm=[20,200]"),
    *("--set", "pile.plate_mm=[150,20]", "--set", "pile.fill_height_mm=25"),
    *("--set", "pile.gate_speed_mm_s=200", "--set", "pile.slab=true"),
]


def run(*arguments):
    return CliRunner().invoke(app, ["simulate", *map(str, arguments)])


def truth(recording):
    return json.loads((recording / "simulation.json").read_text())["truth"]


@pytest.fixture(scope="module")
def heap(tmp_path_factory):
    """A small pile with its last state."""
    out = tmp_path_factory.mktemp("saved") / "mit Umlaut ä"
    done = run("pile", *SLAB, "--track", "--save", "vtkhdf", "--out", out)
    assert done.exit_code == 0, done.output
    return out / "pile-01"


def test_the_state_lies_beside_the_recording(heap):
    saved = read_state(heap / "state.vtkhdf")
    assert len(saved.shape_of) == truth(heap)["retained_seeds"] > 20
    assert np.linalg.norm(saved.velocities, axis=1).max() < 0.01  # at rest, m/s
    again = CliRunner().invoke(app, ["measure", str(heap), "--out", str(heap / "m")])
    assert again.exit_code == 0 and "state.vtkhdf" not in again.output  # no evidence


def test_a_heap_that_begins_as_one_stays_or_slumps(heap, tmp_path):
    """With its own parameters it stays within half a degree, the springs' first
    moments; without friction it runs out flat."""
    start = ("--start", heap / "state.vtkhdf", "--track", "--rng", 2)
    same = run("pile", *SLAB, *start, "--out", tmp_path / "same")
    assert same.exit_code == 0, same.output
    again, before = truth(tmp_path / "same" / "pile-01"), truth(heap)
    assert again["retained_seeds"] == before["retained_seeds"]
    assert again["repose_angle_deg"] == pytest.approx(
        before["repose_angle_deg"], abs=0.5
    )
    slippery = ["--seed-static-friction", 0.02, "--static-friction", 0.02]
    slippery += ["--seed-rolling-friction", 0.0, "--rolling-friction", 0.0]
    run("pile", *SLAB, *start, *slippery, "--out", tmp_path / "flat")
    assert truth(tmp_path / "flat" / "pile-01")["crest_mm"] < 0.8 * before["crest_mm"]


def test_another_start_is_another_run(heap, tmp_path):
    other = shutil.copy(heap / "state.vtkhdf", tmp_path / "s.vtkhdf")
    again = run("pile", *SLAB, "--track", "--start", other, "--out", heap.parent)
    assert again.exit_code == 2 and "is not this run" in again.output


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["drop", "--save", "stl"], "--save stl: vtkhdf is what there is"),
        (
            ["drop", "--save", "vtkhdf", "--engine", "lammps"],
            "--save: of LAMMPS only heaps, not a drop",
        ),
        (["drop", "--start", "STATE"], "only a pile or cylinder can begin with a heap"),
        (["pile", "--start", "nowhere.vtkhdf"], "nowhere.vtkhdf: no such file"),
        (
            ["pile", *SLAB, "--set", "pile.plate_mm=[61,20]", "--start", "RAISED"],
            "does not stand on the rig; moved by (0.0, 0.0, -5000.0) mm it may",
        ),
    ],
)
def test_misuse_is_a_sentence_and_leaves_nothing(heap, tmp_path, arguments, said):
    raised = tmp_path / "raised.vtkhdf"
    shutil.copy(heap / "state.vtkhdf", raised)
    with h5py.File(raised, "a") as held:
        for place in ("VTKHDF/Points", "ONDEM/Bodies/Clumps/position"):
            held[place][:] += [0.0, 0.0, 5.0]
    files = {"STATE": heap / "state.vtkhdf", "RAISED": raised}
    typed = [files.get(a, a) for a in arguments]
    result = run(*typed, "--track", "--out", tmp_path / "x")
    assert result.exit_code in (1, 2) and said in result.output
    assert "Traceback" not in result.output
    assert not (tmp_path / "x").exists() or not list((tmp_path / "x").iterdir())


def test_a_run_without_its_state_is_not_taken_for_one_with_it(tmp_path):
    assert run("drop", "--track", "--out", tmp_path / "x").exit_code == 0
    again = run("drop", "--track", "--save", "vtkhdf", "--out", tmp_path / "x")
    assert again.exit_code == 2 and "without state.vtkhdf" in again.output
