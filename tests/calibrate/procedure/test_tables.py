"""The procedure on the soybean paper's own tables: what it printed comes out, what does
not follow is named."""

import json
import shutil
from pathlib import Path

import pandas as pd
import pytest

from benchtwin.calibrate.export import read_result
from benchtwin.calibrate.procedure import calibrate_tables, parameters
from benchtwin.calibrate_command import Asked, calibrate_command
from benchtwin.twin.command import DONE, FAILED, MISUSED

PAPER = Path(__file__).parents[3] / "samples" / "soybean-paper"
PRINTED = {
    "restitution": 0.54,
    "static_friction": 0.34,
    "rolling_friction": 0.01,
    "seed_restitution": 0.65,
    "seed_static_friction": 0.55,
    "seed_rolling_friction": 0.04,
}


@pytest.fixture(scope="module")
def paper():
    return calibrate_tables(PAPER)


@pytest.fixture
def bench(tmp_path, few_draws):
    """A copy of the paper's bench to spoil; of its posterior nothing is asked."""
    return shutil.copytree(PAPER, tmp_path / "bench")


def run(bench, tmp_path, **options):
    return calibrate_command(
        Asked(bench, tmp_path / "out", **{"tables": True} | options)
    )


def test_the_papers_parameters_come_out_within_intervals(paper):
    t = parameters(paper).set_index("parameter")
    assert {n: round(v, 2) for n, v in t["value"].items()} == PRINTED
    assert (
        (t["low"] <= t["value"]) & (t["value"] <= t["high"]) & (t["low"] < t["high"])
    ).all()
    assert t["budget"].map(lambda b: sum(b.values())).tolist() == pytest.approx(
        [1.0] * 6
    )


def test_just_four_printed_values_do_not_follow(paper):
    wrong = paper.checks[~paper.checks["follows"].astype(bool)].set_index("item")[
        "recomputed"
    ]
    assert wrong.round(3).to_dict() == {
        "pile: contribution of B (Eqs. 9, 10)": 2.226,
        "pile: contribution of C (Eqs. 9, 10)": 2.184,
        "pile: BC p, in the text": 0.029,
        "pile: Table 10: Residual df": 7.0,
    }
    assert len(paper.checks) == 111


def test_contradictions_are_said(paper):
    said = " | ".join(paper.flags)
    assert "209.8 mm at its end rolling_friction = 0.01" in said and "214" in said
    assert "groups 3, 4, 5 as −1, 0, +1" in said and "without the ½" in said
    assert "at the boundary of its own range: seed_restitution = 0.65" in said


def test_an_answer_that_the_polynomial_refuses_comes_from_the_curve_and_is_marked(
    paper,
):
    roll = paper.steel["roll"]
    assert roll.by == "monotone curve" and round(roll.inverse.value, 4) == 0.0102
    assert any(
        "polynomial refuses" in n and "extend rolling_friction below 0.01" in n
        for n in roll.notes
    )
    beyond = roll.answers.set_index("curve").loc["polynomial, a little beyond its rows"]
    assert (
        beyond["value"] == pytest.approx(0.0095, abs=5e-5)
        and "extend it" in beyond["note"]
    )


def test_one_angle_does_not_resolve_three_parameters(paper):
    d = paper.joint.directions
    assert d["resolved"].sum() == 1 and paper.joint.posterior.converged
    assert (
        paper.pile.optimum.boundary == {"seed_restitution": "high"}
        and not paper.pile.central.boundary
    )
    status = parameters(paper).set_index("parameter")["status"]
    seed = [name for name in PRINTED if name.startswith("seed_")]
    assert status[seed].str.startswith("not resolved: the pile narrows it by").all()
    left = paper.joint.next_tests.set_index("test")["variance_left"]
    assert len(left) == 4 and (left < 1).all() and left.idxmax() == "more heaps"


def test_an_interval_that_ends_where_the_simulations_do_bounds_one_side_only(paper):
    """Roll's rows begin at 0.01, within the error of the answer; drop and slide are the
    controls."""
    status = parameters(paper).set_index("parameter")["status"]
    assert (
        status["rolling_friction"]
        == "only bounded: at most 0.0108; nothing is known below 0.01"
    )
    assert status["restitution"] == status["static_friction"] == "calibrated"


def test_parameters_that_share_no_recording_are_fitted_jointly_as_one_by_one(paper):
    t = paper.joint.table.set_index("factor")
    for name, fit in paper.steel.items():
        assert t.loc[fit.rig.parameter, "median"] == pytest.approx(
            fit.inverse.value, abs=1.5 * fit.inverse.sd
        ), name


def test_the_command_leaves_a_result_that_export_reads(tmp_path, capsys, few_draws):
    assert run(PAPER, tmp_path) == DONE
    said = capsys.readouterr().out
    assert (
        "restitution, seed–steel" in said and "Residual df = 1 does not follow" in said
    )
    out = tmp_path / "out"
    card = read_result(out)
    assert (
        round(card.on_wall.restitution.value, 2) == 0.54
        and card.rolling == "edem"
        and len(card.shape.balls_m) == 5
    )
    told = json.loads((out / "result.json").read_text())
    assert (
        told["schema"] == 1 and told["random_seed"] == 1 and "numpy" in told["versions"]
    )
    bounded = told["parameters"]["rolling_friction"]["status"]
    assert bounded.startswith("only bounded: at most") and bounded in said
    assert bounded in (out / "report.html").read_text(encoding="utf8")
    assert len(told["bench"]["sha256"]["drop/readings.csv"]) == 64
    assert len(pd.read_csv(out / "tables" / "pile_anova.csv")) == 14
    assert run(PAPER, tmp_path) == MISUSED and "--overwrite" in capsys.readouterr().err
    before = told["parameters"]
    assert (
        run(PAPER, tmp_path, overwrite=True, quiet=True) == DONE
        and capsys.readouterr().out == ""
    )
    assert json.loads((out / "result.json").read_text())["parameters"] == before


def test_a_folder_of_something_else_is_not_written_into(tmp_path, capsys):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.tex").write_text("")
    assert run(PAPER, tmp_path) == MISUSED and "thesis.tex" in capsys.readouterr().err
    assert (
        calibrate_command(Asked(tmp_path / "no", tmp_path / "x", tables=True))
        == MISUSED
    )
    assert "no such folder" in capsys.readouterr().err


def test_without_a_pile_the_rest_is_calibrated_and_the_pile_is_named(
    bench, tmp_path, capsys
):
    shutil.rmtree(bench / "pile")
    assert run(bench, tmp_path) == DONE
    assert "no pile recording was measured" in capsys.readouterr().out
    told = json.loads((tmp_path / "out" / "result.json").read_text())
    assert (
        set(told["parameters"])
        == {"restitution", "static_friction", "rolling_friction"}
        and "pile" in told["not_calibrated"]
    )


@pytest.mark.parametrize(
    ("readings", "reason"),
    [
        ("19.5", "1 reading has no scatter; give at least two"),
        ("19.5\n19.5\n19.5", "all 3 readings equal 19.5"),
    ],
)
def test_readings_without_scatter_cost_their_rig_only(
    bench, tmp_path, capsys, readings, reason
):
    (bench / "slide" / "readings.csv").write_text(f"slide_angle_deg\n{readings}\n")
    assert run(bench, tmp_path) == DONE
    assert (
        f"not calibrated: slide: slide: slide_angle_deg: {reason}"
        in capsys.readouterr().out
    )


def test_a_missing_unit_is_named_with_its_file(bench, tmp_path, capsys):
    (bench / "slide" / "readings.csv").write_text("slide_angle\n19\n20\n")
    assert run(bench, tmp_path) == DONE
    assert "no column of readings" in capsys.readouterr().out
    (bench / "tables" / "drop.csv").write_text(
        "restitution,rebound_height\n0.4,60\n0.5,80\n"
    )
    assert run(bench, tmp_path, overwrite=True) == DONE
    said = capsys.readouterr().out
    assert (
        "drop.csv: column rebound_height_mm is missing; expected restitution,"
        " rebound_height_mm" in said
    )


def test_other_factors_are_named(bench, tmp_path, capsys):
    file = bench / "tables" / "levels.csv"
    file.write_text(file.read_text().replace("seed_restitution", "cohesion"))
    assert run(bench, tmp_path) == DONE
    said = " ".join(capsys.readouterr().out.split())
    assert (
        "levels.csv: column seed_restitution is missing; expected coded,"
        " seed_restitution" in said
    )
    assert "found coded, cohesion" in said


def test_a_design_that_cannot_tell_its_terms_apart_is_named(bench, tmp_path, capsys):
    file = bench / "tables" / "design.csv"
    rows = pd.read_csv(file)
    rows["B"] = rows["A"]
    rows.to_csv(file, index=False)
    assert run(bench, tmp_path) == DONE
    assert (
        "design.csv: singular design: its 17 runs cannot tell B"
        in capsys.readouterr().out
    )
    rows.head(9).to_csv(file, index=False)
    assert run(bench, tmp_path, overwrite=True) == DONE
    assert "10 terms need at least 11 runs; here are 9" in capsys.readouterr().out


def test_low_not_below_high_is_named(bench, tmp_path, capsys):
    file = bench / "tables" / "levels.csv"
    file.write_text(file.read_text().replace("-1,0.55", "-1,0.75"))
    assert run(bench, tmp_path) == DONE
    assert (
        "seed_restitution: low must be below high; here are 0.75 and 0.65"
        in capsys.readouterr().out
    )


def test_an_angle_that_no_parameters_give_is_a_finding(bench, tmp_path, capsys):
    (bench / "pile" / "readings.csv").write_text("repose_angle_deg\n39\n")
    assert run(bench, tmp_path) == DONE
    assert (
        "finding for diagnosis: the bench's 39° lies outside" in capsys.readouterr().out
    )
    assert (
        "Finding for diagnosis"
        in (tmp_path / "out" / "report.html").read_text()[:30_000]
    )


def test_contradictory_recordings_are_flagged(bench, tmp_path):
    shutil.copytree(bench / "drop", bench / "drop-b")
    (bench / "drop-b" / "recording.toml").write_text('rig = "drop"\n')
    (bench / "drop-b" / "readings.csv").write_text(
        "rebound_height_mm\n150\n152\n149\n151\n"
    )
    found = calibrate_tables(bench)
    assert "drop: drop-b: 150.5 contradicts the other recordings" in " ".join(
        found.findings
    )


def test_nothing_to_calibrate_stops_with_a_reason(bench, tmp_path, capsys):
    for rig in ("drop", "slide", "roll", "pile"):
        (bench / rig / "readings.csv").unlink()
    assert run(bench, tmp_path) == FAILED
    assert "nothing could be measured" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_tables_that_are_not_there_are_asked_for(bench, tmp_path, capsys):
    shutil.rmtree(bench / "tables")
    assert (
        run(bench, tmp_path) == MISUSED
        and "--tables needs drop.csv" in capsys.readouterr().err
    )
