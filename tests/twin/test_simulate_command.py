"""`benchtwin simulate` as typed: exit codes, words, resuming, interruption."""

import json

import pandas as pd
import pytest
from typer.testing import CliRunner

from benchtwin.command_line import app


def run(*arguments):
    return CliRunner().invoke(app, ["simulate", *map(str, arguments)])


def test_simulate_and_measure_agree(tmp_path):
    out = tmp_path / "with space é"
    assert (
        run(
            "drop", "--out", out, "--track", "--repeats", 2, "--restitution", 0.6
        ).exit_code
        == 0
    )
    inside = pd.read_csv(out / "measured" / "measurements.csv")
    again = CliRunner().invoke(app, ["measure", str(out), "--out", str(tmp_path / "m")])
    assert again.exit_code == 0
    outside = pd.read_csv(tmp_path / "m" / "measurements.csv")
    pd.testing.assert_frame_equal(inside, outside)
    for n in (1, 2):
        truth = json.loads((out / f"drop-0{n}" / "simulation.json").read_text())[
            "truth"
        ]
        found = inside.query(
            f"recording == 'drop-0{n}' and quantity == 'rebound_height'"
        ).value.item()
        assert found == pytest.approx(truth["rebound_height_mm"], abs=0.3)


def test_the_same_command_goes_on_where_it_was_stopped(tmp_path, monkeypatch):
    from benchtwin.twin.job import Job

    real, calls = Job.run, []

    def stop_at_the_second(self, out, **more):
        calls.append(out.name)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return real(self, out, **more)

    monkeypatch.setattr(Job, "run", stop_at_the_second)
    stopped = run("roll", "--out", tmp_path / "r", "--track", "--repeats", 3)
    assert stopped.exit_code == 1
    assert [p.name for p in sorted((tmp_path / "r").iterdir())] == ["roll-01"]
    monkeypatch.setattr(Job, "run", real)
    before = (tmp_path / "r" / "roll-01" / "simulation.json").stat().st_mtime_ns
    assert (
        run("roll", "--out", tmp_path / "r", "--track", "--repeats", 3).exit_code == 0
    )
    assert (tmp_path / "r" / "roll-01" / "simulation.json").stat().st_mtime_ns == before
    assert {p.name for p in (tmp_path / "r").iterdir()} == {
        "roll-01",
        "roll-02",
        "roll-03",
        "measured",
    }


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["bounce"], "no such rig"),
        (["drop", "--repeats", "0"], "--repeats 0"),
        (["drop", "--restitution", "1.4"], "restitution = 1.4"),
        (["drop", "--static-friction", "-1"], "static_friction = -1"),
        (["pile", "--set", "pile.fill_height_mm=300"], "the box is only 0.2 m high"),
        (
            ["pile", "--set", "pile.gate_mm=[5,200]", "--track"],
            "jam in an opening of 5 mm",
        ),
        (
            ["drop", "--set", "camera.target_mm=[0,0,900]"],
            "the camera does not see the seed at the start",
        ),
        (["drop", "--set", "drop.height=3"], "did you mean height_mm"),
        (["drop", "--set", "camera.readout_s=0.01"], "reads all rows at once"),
        (["roll", "--set", "drop.height_mm=30"], "is of a drop, not of a roll"),
        (
            ["cylinder", "--set", "pile.box_mm=[105,30,200]"],
            "[pile] box_mm = (105.0, 30.0, 200.0): the simulation of this pile has no",
        ),
        (["drop", "--from", "nowhere.toml"], "nowhere.toml: no such file"),
        (["drop", "--set", "shear_modulus_pa=1e4", "--track"], "reduce dt or stiffen"),
        (["slide", "--set", "slide.start_deg=40", "--track"], "slides from the start"),
    ],
)
def test_misuse_is_named_and_leaves_nothing(tmp_path, arguments, said):
    result = run(*arguments, "--out", tmp_path / "x")
    assert result.exit_code in (1, 2)
    assert said in result.output
    assert "Traceback" not in result.output
    left = list((tmp_path / "x").iterdir()) if (tmp_path / "x").exists() else []
    assert left == []


def test_a_recording_of_another_rig_and_a_folder_of_another_run_are_refused(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "recording.toml").write_text('rig = "roll"\n')
    assert (
        "describes a roll, not a drop"
        in run("drop", "--from", tmp_path / "a", "--out", tmp_path / "x").output
    )
    assert run("drop", "--track", "--out", tmp_path / "x").exit_code == 0
    other = run("drop", "--track", "--restitution", 0.7, "--out", tmp_path / "x")
    assert (other.exit_code, "is not this run" in other.output) == (2, True)


def test_a_full_disk_is_said_so(tmp_path, monkeypatch):
    def full(*args):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("benchtwin.twin.write.numbers", full)
    result = run("drop", "--track", "--out", tmp_path / "x")
    assert result.exit_code == 2
    assert "No space left on device" in result.output
    assert list((tmp_path / "x").iterdir()) == []
