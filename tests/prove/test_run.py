"""The proof from end to end with stand-in solvers: keys fixed beforehand, resumable, a
missing diagnosis is a failure."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from benchtwin.prove.command import prove_command
from benchtwin.prove.plan import CLEAN, COMPOUND, plan
from benchtwin.prove.run import KeyMismatch, Settings, judged, prove

STAND_IN = Path(__file__).parent / "stand_in.py"
CASES, SEED = 6, 2  # drops and a slide, none in pictures: quick


def settings(out: Path, mode: str = "none", **more) -> Settings:
    return Settings(
        out,
        CASES,
        SEED,
        solver=f"{{python}} {STAND_IN} {mode} {{bench}} {{out}}",
        **more,
    )


def quiet(*_) -> None:
    pass


@pytest.fixture(scope="module")
def proof(tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("proof")
    prove(settings(out), quiet)
    return out


def test_half_of_the_plan_is_clean_and_every_rig_is_in_it():
    specs = plan(600, np.random.default_rng(1))
    assert sum(s.kind == CLEAN for s in specs) == 300
    assert {s.rig for s in specs} == {"drop", "slide", "roll", "pile"}
    drops = [s for s in specs if s.rig == "drop"]
    assert sum(s.rendered for s in drops) >= 0.2 * len(drops)
    assert all(
        len(s.effects) == 2 and min(s.wanted_snr) > 10
        for s in specs
        if s.kind == COMPOUND
    )
    assert specs == plan(600, np.random.default_rng(1))


def test_the_quick_proof_is_quick():
    assert not any(
        s.rendered or s.rig == "pile" for s in plan(CASES, np.random.default_rng(SEED))
    )


def test_folders_of_clean_and_other_cases_look_the_same(proof):
    """What the solver sees is the same kind of folder, clean or not."""
    for folder in (proof / "cases").iterdir():
        assert {p.name for p in folder.rglob("*") if p.is_file()} <= {
            "bench.toml",
            "recording.toml",
            "track.csv",
            "readings.csv",
        }
        text = " ".join(p.read_text() for p in folder.rglob("*.toml"))
        assert not any(
            word in text for word in ("effect", "clean", "snr", "drag", "error", "kind")
        )


def test_keys_are_published_as_hashes_and_written_at_the_end(proof):
    published, opened = (
        json.loads((proof / name).read_text()) for name in ("hashes.json", "keys.json")
    )
    assert set(published) == set(opened["keys"]) and len(published) == CASES
    assert set(json.loads((proof / "submitted.json").read_text())) == set(published)


def test_a_stopped_proof_goes_on_and_ends_the_same(proof, tmp_path, monkeypatch):
    from benchtwin.prove import run

    calls, true_solve = [], run.solve

    def interrupted(case, *args):
        assert (tmp_path / "hashes.json").is_file() and not (
            tmp_path / "keys.json"
        ).exists()  # no solver can read a key
        if len(calls) == 3 and not any(c == "stopped" for c in calls):
            calls.append("stopped")
            raise KeyboardInterrupt
        calls.append(case)
        return true_solve(case, *args)

    monkeypatch.setattr(run, "solve", interrupted)
    with pytest.raises(KeyboardInterrupt):
        prove(settings(tmp_path), quiet)
    assert not (tmp_path / "keys.json").exists()
    hashes = (tmp_path / "hashes.json").read_text()
    prove(settings(tmp_path), quiet)
    solved = [c for c in calls if c != "stopped"]
    assert sorted(solved) == sorted(set(solved)) and len(solved) == CASES  # each once
    assert (
        (tmp_path / "hashes.json").read_text()
        == hashes
        == (proof / "hashes.json").read_text()
    )
    assert (tmp_path / "keys.json").read_text() == (proof / "keys.json").read_text()


def test_nothing_is_solved_again_once_the_keys_are_written(proof):
    before = sorted((p, p.stat().st_mtime_ns) for p in (proof / "solutions").rglob("*"))
    assert [j.verdict for j in prove(settings(proof, "loud"), quiet)] == [
        "none"
    ] * CASES
    assert (
        sorted((p, p.stat().st_mtime_ns) for p in (proof / "solutions").rglob("*"))
        == before
    )


def test_keys_changed_afterwards_are_refused(proof, tmp_path):
    content = json.loads((proof / "keys.json").read_text())
    content["keys"]["case-0001"]["kind"] = "forged"
    (tmp_path / "keys.json").write_text(json.dumps(content))
    (tmp_path / "hashes.json").write_text((proof / "hashes.json").read_text())
    with pytest.raises(KeyMismatch, match="case-0001"):
        judged(tmp_path)


def test_another_proof_in_the_folder_is_refused(tmp_path, capsys):
    (tmp_path / "hashes.json").write_text(json.dumps({"case-0001": "0"}))
    assert prove_command(tmp_path, 1, SEED, workers=1, limit_s=10) == 1
    assert "another proof" in capsys.readouterr().err.replace("\n", " ")


def test_a_solver_that_breaks_down_is_scored_as_missing(tmp_path):
    solver = f"{sys.executable} {STAND_IN} clumsy {{bench}} {{out}}"
    assert (
        prove_command(
            tmp_path, 2, SEED, workers=1, limit_s=10, solver=solver, quiet=True
        )
        == 0
    )
    content = json.loads((tmp_path / "prove.json").read_text())
    row = next(
        r
        for r in content["scores"]
        if r["score"] == "no diagnosis" and r["rig"] == "all"
    )
    assert (row["k"], row["n"], row["met"]) == (2, 2, False)
    assert (
        "I broke down"
        in (tmp_path / "solutions" / "case-0001" / "printed.txt").read_text()
    )
    assert "have none" in (tmp_path / "report.html").read_text()
    assert len((tmp_path / "cases.csv").read_text().splitlines()) == 3


def test_an_overconfident_solver_fails_in_the_whole_proof(tmp_path):
    solver = f"{sys.executable} {STAND_IN} sure {{bench}} {{out}}"
    assert (
        prove_command(
            tmp_path, CASES, SEED, workers=1, limit_s=10, solver=solver, quiet=True
        )
        == 0
    )
    content = json.loads((tmp_path / "prove.json").read_text())
    (found,) = content["reliability"]
    assert (found["n"], found["right"], found["holds"]) == (CASES, CASES // 2, False)
    rows = {r["score"]: r for r in content["scores"] if r["rig"] == "all"}
    assert rows["log score, clean"]["value"] == pytest.approx(np.log(0.995))
    assert rows["log score, something missing"]["value"] == pytest.approx(np.log(1e-6))
    assert (
        rows["right, of verdicts said with 0.97–1"]["met"] is False
        and rows["no p_verdict"]["k"] == 0
    )
    assert "fig-reliability" in (tmp_path / "report.html").read_text()
