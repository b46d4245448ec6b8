"""The procedure on the soybean paper's own tables: what it printed comes out, what does
not follow is named."""

import json
import shutil
from pathlib import Path

import pandas as pd
import pytest
from stand_in import calibrate_command

from benchtwin.bench.exits import DONE, FAILED, MISUSED
from benchtwin.calibrate.export import read_result
from benchtwin.calibrate.procedure import calibrate_tables, parameters
from benchtwin.calibrate.procedure.calibration import BOUNDED, CALIBRATED, UNRESOLVED

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
    return calibrate_command(bench, tmp_path / "out", **{"tables": True} | options)


def test_the_papers_parameters_come_out_within_intervals(paper):
    t = parameters(paper).set_index("parameter")
    assert (
        (t["low"] <= t["value"]) & (t["value"] <= t["high"]) & (t["low"] < t["high"])
    ).all()
    printed = pd.Series(PRINTED)
    assert ((t["low"] <= printed) & (printed <= t["high"])).all()
    on_steel = ["restitution", "static_friction", "rolling_friction"]
    assert t.loc[on_steel, "value"].round(2).to_dict() == {
        n: PRINTED[n] for n in on_steel
    }
    shares = t.loc[on_steel, "budget"].map(lambda b: sum(b.values()))
    assert shares.tolist() == pytest.approx([1.0] * 3)


def test_the_papers_own_answers_are_those_of_its_steps(paper):
    """Its curves inverted, and its optimum; the posterior's medians stand elsewhere."""
    again = paper.checks.set_index("item")["recomputed"]
    assert again["drop: parameter"] == pytest.approx(0.5398, abs=1e-4)
    assert again["slide: parameter"] == pytest.approx(0.34, abs=1e-4)
    point = {n: round(v, 2) for n, v in paper.surface.optimum.point.items()}
    assert point == {n: v for n, v in PRINTED.items() if n.startswith("seed_")}


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


def test_a_curve_that_does_not_reach_the_bench_is_followed_beyond_and_flagged(paper):
    (flag,) = [f for f in paper.flags if "followed beyond" in f]
    assert "it answers 0.0095" in flag and "no answer within its own rows" in flag
    roll = paper.steel["roll"]
    assert roll.reached and roll.equation.at(roll.bench.value) < roll.equation.low


def test_one_angle_does_not_resolve_three_parameters(paper):
    assert paper.joint.posterior.converged
    assert paper.surface.optimum.boundary == {"seed_restitution": "high"}
    t = parameters(paper).set_index("parameter")
    seed = [name for name in PRINTED if name.startswith("seed_")]
    assert (t.loc[seed, "status"] == UNRESOLVED).all()
    left = paper.joint.next_tests.set_index("test")["variance_left"]
    assert left.index.tolist() == ["4 more heaps"] and left.iloc[0] < 1


def test_an_interval_that_ends_where_the_simulations_do_bounds_one_side_only(paper):
    """Roll's rows begin at 0.01, within the error of the answer; drop and slide are the
    controls."""
    t = parameters(paper).set_index("parameter")
    roll = t.loc["rolling_friction"]
    assert roll["status"] == BOUNDED and roll["low"] == 0.01
    assert roll["remark"] == f"at most {roll['high']:g}; nothing is known below 0.01"
    assert t.loc[["restitution", "static_friction"], "status"].eq(CALIBRATED).all()


def test_parameters_that_share_no_recording_are_fitted_jointly_as_one_by_one(paper):
    draws = paper.joint.posterior.draws
    for name, fit in paper.steel.items():
        together = draws[fit.rig.parameter].median()
        assert together == pytest.approx(fit.value, abs=0.1 * fit.sd), name


def test_the_command_leaves_a_result_that_export_reads(tmp_path, capsys, few_draws):
    assert run(PAPER, tmp_path) == DONE
    said = capsys.readouterr().out
    assert (
        "restitution, seed–steel" in said and "Residual df = 1 does not follow" in said
    )
    out = tmp_path / "out"
    card = read_result(out)
    assert (
        abs(card.on_wall.restitution.value - 0.54) < 0.01
        and card.rolling == "edem"
        and len(card.shape.balls_m) == 5
    )
    told = json.loads((out / "result.json").read_text())
    assert (
        told["schema"] == 1 and told["random_seed"] == 1 and "numpy" in told["versions"]
    )
    rolling = told["parameters"]["rolling_friction"]
    bounded = f"{rolling['status']}: {rolling['remark']}"
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
    assert calibrate_command(tmp_path / "no", tmp_path / "x", tables=True) == MISUSED
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
        "nothing that was simulated gives the bench's pile: angle of repose 39"
        in " ".join(capsys.readouterr().out.split())
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
