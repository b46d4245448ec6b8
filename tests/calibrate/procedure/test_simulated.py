"""The procedure with simulations, on a stand-in whose true parameters are known: what
comes back, in what order, at what cost."""

import json
import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from stand_in import NEAR, TRUE, StandIn, angle, calibrate_command, write_bench

from benchtwin import calibrating
from benchtwin.bench.exits import DONE, FAILED, MISUSED
from benchtwin.bench.numbers import with_interval
from benchtwin.calibrate.procedure import joint, parameters
from benchtwin.calibrate.procedure.calibration import DOUBTFUL, UNRESOLVED
from benchtwin.calibrate.procedure.effort import FULL, QUICK
from benchtwin.calibrate.procedure.rigs import PILE, SEED_FACTORS
from benchtwin.calibrate.procedure.simulated import Prescribed, calibrate_simulated
from benchtwin.calibrate.procedure.simulator import Run, _begun, seed_numbers

EASY = replace(QUICK, draws=200)  # of the posterior: enough for what is asked here
PAPER = Path(__file__).parents[3] / "samples" / "soybean-paper"


def calibrated(bench, simulator, steps=500, **more):
    """With a posterior of at most 500 steps: not converged, but its sds are good to a
    tenth."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(joint, "sample", partial(joint.sample, max_steps=steps))
        return calibrate_simulated(bench, simulator, effort=EASY, seed=7, **more)


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    return write_bench(tmp_path_factory.mktemp("bench") / "b", np.random.default_rng(7))


@pytest.fixture(scope="module")
def simulator():
    return StandIn()


@pytest.fixture(scope="module")
def found(bench, simulator):
    return calibrated(bench, simulator)


@pytest.fixture
def spoilt(bench, tmp_path, few_draws):
    """A copy to spoil; of its posterior nothing is asked."""
    return shutil.copytree(bench, tmp_path / "b")


def readings(folder, rig, column, values):
    (folder / rig / "readings.csv").write_text(
        column + "\n" + "\n".join(map(str, values)) + "\n"
    )


def test_the_true_parameters_lie_within_the_intervals(found):
    t = parameters(found).set_index("parameter")
    truth = pd.Series(TRUE)
    assert ((t["low"] <= truth) & (truth <= t["high"])).all(), t
    assert abs(t["value"] - truth)[["restitution", "static_friction"]].max() < 0.02
    assert abs(t.loc["rolling_friction", "value"] - TRUE["rolling_friction"]) < 0.0005


def test_printed_values_lie_in_their_intervals_and_carry_no_digits_beyond(found):
    t = parameters(found)
    assert ((t["low"] <= t["value"]) & (t["value"] <= t["high"])).all()
    for r in t.itertuples():
        places = len(with_interval(r.value, r.low, r.high).split(" ")[0].split(".")[1])
        numbers = (r.value, r.low, r.high, r.most_probable_set)
        assert all(round(v, places) == v for v in numbers), r


def test_the_set_that_is_exported_gives_what_the_bench_shows(found):
    """Within the scatter of the bench's mean, by the closed forms themselves; medians
    need not."""
    at, seen = found.most_probable, found.joint.posterior.tension
    assert set(at) == set(TRUE)
    pile = found.seeds["pile"].bench
    assert angle(at) == pytest.approx(pile.value, abs=2 * np.hypot(pile.sd, 0.2))
    assert (abs(seen["z"]) < 0.5).all() and set(found.verified) == set(
        seen["observable"]
    )
    assert all(check.agrees for check in found.verified.values())


def test_each_rig_is_simulated_with_what_the_earlier_ones_found(found, simulator):
    order = list(dict.fromkeys(r.rig for r in simulator.runs))
    assert order == ["drop", "slide", "roll", "pile"]
    by = {rig: next(r for r in simulator.runs if r.rig == rig).values for rig in order}
    e, mu = (found.steel[r].value for r in ("drop", "slide"))
    assert set(by["drop"]) == {"restitution"} and by["slide"]["restitution"] == e
    assert by["roll"]["static_friction"] == mu and set(by["pile"]) == set(TRUE)


def test_quick_asks_for_little(simulator, found):
    assert (
        simulator.rigs["pile"] <= QUICK.design + QUICK.more + QUICK.check
        and sum(simulator.rigs.values()) < 200
    )
    assert any("quick" in line for line in found.options["said"])


def test_no_two_runs_of_a_rig_share_a_generator(simulator):
    numbers = [(r.rig, r.rng) for r in simulator.runs]
    assert len(set(numbers)) == len(numbers)


def test_the_same_seed_gives_the_same_result(bench, few_draws):
    once, again = (
        calibrate_simulated(bench, StandIn(), effort=EASY, seed=7) for _ in range(2)
    )
    pd.testing.assert_frame_equal(parameters(again), parameters(once))
    pd.testing.assert_frame_equal(
        again.joint.posterior.draws, once.joint.posterior.draws
    )


def test_the_range_is_extended_until_the_bench_lies_inside(spoilt):
    (spoilt / "bench.toml").write_text(
        (spoilt / "bench.toml")
        .read_text()
        .replace("height_mm = 310", "height_mm = 900")
    )
    fit = calibrate_simulated(spoilt, StandIn(), effort=EASY, seed=1).steel["drop"]
    assert any("range extended" in n for n in fit.notes)
    assert fit.value == pytest.approx(TRUE["restitution"], abs=0.03)


def test_a_height_that_no_restitution_gives_is_a_finding(spoilt):
    readings(spoilt, "drop", "rebound_height_mm", [326, 327, 328, 325])
    found = calibrate_simulated(spoilt, StandIn(), effort=EASY, seed=1)
    assert "drop" not in found.steel and any(
        "finding for diagnosis: no restitution" in f for f in found.findings
    )
    assert (
        any("restitution = 0.54 was assumed" in s for s in found.options["said"])
        and "slide" in found.steel
    )


def test_ranges_are_widened_until_they_hold_the_benchs_angle(spoilt):
    readings(spoilt, "pile", "repose_angle_deg", [39, 39.5, 38.6])
    found = calibrate_simulated(
        spoilt, StandIn(), effort=EASY, seed=1, prescribed=Prescribed(ranges=NEAR)
    )
    seen = found.seeds["pile"]
    assert seen.box.range("seed_static_friction")[1] > NEAR["seed_static_friction"][1]
    assert angle(found.most_probable) == pytest.approx(39, abs=1.5)


def test_an_angle_that_no_parameters_give_is_said(spoilt):
    readings(spoilt, "pile", "repose_angle_deg", [85, 86])
    found = calibrate_simulated(spoilt, StandIn(), effort=EASY, seed=1)
    (finding,) = found.findings
    assert "finding for diagnosis: nothing that was simulated gives" in finding
    status = parameters(found).set_index("parameter")["status"]
    assert status["seed_static_friction"] == DOUBTFUL


def test_one_reading_takes_the_scatter_of_simulated_runs(spoilt):
    readings(spoilt, "drop", "rebound_height_mm", [88.0])
    readings(spoilt, "pile", "repose_angle_deg", [30.0])
    found = calibrate_simulated(spoilt, StandIn(), effort=EASY, seed=1)
    assert found.steel["drop"].bench.scatter_sd == pytest.approx(0.05 * 88, rel=0.5)
    pile = found.seeds["pile"]
    noise = pile.observables[0].surrogate.noise_sd
    assert pile.bench.scatter_sd == pytest.approx(noise) and pile.bench.n == 1


def test_runs_that_fail_are_named_with_how_to_run_one_alone(
    bench, tmp_path, capsys, few_draws
):
    asked = dict(bench=bench, out=tmp_path / "out", quick=True)
    assert calibrate_command(simulator=StandIn(fails=("pile",)), **asked) == DONE
    said = capsys.readouterr().out
    assert (
        f"not calibrated: pile: pile: 0 of {QUICK.design} simulated runs could be"
        " measured (ValueError: it blew up; run it alone: python -m" in said
    )
    assert (
        calibrate_command(
            bench,
            tmp_path / "b",
            quick=True,
            simulator=StandIn(fails=("drop", "slide", "roll", "pile")),
        )
        == FAILED
    )
    assert (
        "nothing could be calibrated" in capsys.readouterr().err
        and not (tmp_path / "b" / "result.json").exists()
    )


def test_piles_that_show_nothing_are_not_taken_for_a_calibration(bench, few_draws):
    found = calibrate_simulated(
        bench, StandIn(packing_sd=0.0, own_sd=6.0), effort=EASY, seed=3
    )
    status = parameters(found).set_index("parameter")["status"]
    assert (status[list(SEED_FACTORS)] == UNRESOLVED).all()


def test_piles_that_scatter_beyond_all_packings_are_a_finding(spoilt):
    readings(spoilt, "pile", "repose_angle_deg", [22.0, 30.0, 38.0])
    found = calibrate_simulated(
        spoilt, StandIn(packing_sd=0.1, own_sd=0.1), effort=EASY, seed=1
    )
    assert any("the bench's heaps scatter by 8°" in f for f in found.findings)


@pytest.mark.slow
def test_a_prior_narrows_what_the_pile_leaves_open(bench, found):
    known_before = Prescribed(priors={"seed_restitution": (0.6, 0.01)})
    known = calibrated(bench, StandIn(), prescribed=known_before).joint.table.set_index(
        "factor"
    )
    assert (
        known.loc["seed_restitution", "sd"]
        < 0.5 * found.joint.table.set_index("factor").loc["seed_restitution", "sd"]
    )


def test_only_what_a_bench_can_state_is_recommended(found):
    """More heaps; and no crest, which the simulation knows and no key takes."""
    told = found.joint.next_tests["test"].tolist()
    assert told == ["4 more heaps"]


def test_the_command_writes_a_report_after_every_rig_and_a_result_at_the_end(
    bench, tmp_path, capsys, few_draws
):
    out, states = tmp_path / "out", []

    class Watching(StandIn):
        def __call__(self, runs):
            report = out / "report.html"
            states.append(
                (
                    report.exists() and "still running" in report.read_text(),
                    (out / "result.json").exists(),
                )
            )
            return super().__call__(runs)

    assert calibrate_command(bench, out, quick=True, simulator=Watching()) == DONE
    assert states[0] == (False, False) and states[-1] == (True, False)
    assert "still running" not in (out / "report.html").read_text()
    told = json.loads((out / "result.json").read_text())
    assert (
        told["mode"] == "simulated"
        and told["options"]["effort"]["name"] == "quick"
        and len(told["parameters"]) == 6
    )
    assert "quick calibration" in capsys.readouterr().out


def test_a_fault_in_drawing_the_report_costs_neither_results_nor_a_traceback(
    bench, tmp_path, capsys, monkeypatch, few_draws
):
    def broken(out, page):
        raise ZeroDivisionError("no width")

    monkeypatch.setattr(calibrating, "write_page", broken)
    out = tmp_path / "out"
    assert (
        calibrate_command(bench, out, quick=True, quiet=True, simulator=StandIn())
        == FAILED
    )
    said = capsys.readouterr().err
    assert (
        "could not be drawn, a fault of benchtwin" in said
        and "no width" in said
        and "result.json" in said
    )
    assert (
        "Traceback" not in said
        and len(json.loads((out / "result.json").read_text())["parameters"]) == 6
    )


@pytest.mark.slow
def test_what_else_the_bench_says_of_its_piles_narrows_the_posterior(bench, found):
    class Weighing(StandIn):
        """Piles fill in less the more they rub: seen without the angle's noise."""

        def __call__(self, runs):
            weigh = [
                140
                - 30 * r.values.get("seed_static_friction", 0)
                + np.random.default_rng(r.rng).normal()
                for r in runs
            ]
            return super().__call__(runs).assign(true_filled_mass_g=weigh)

    def weighed(name: str, shape: str, steps: int = 500):
        """Calibrated on a bench whose pile, of that shape, was weighed."""
        shutil.copytree(bench, bench.parent / name)
        with (bench.parent / name / "pile" / "recording.toml").open("a") as file:
            file.write(
                f"[pile]\n{shape}\nfilled_mass_g ="
                f" {140 - 30 * TRUE['seed_static_friction']}\n"
            )
        return calibrated(bench.parent / name, Weighing(), steps)

    both = weighed(
        "slice",
        "slab = true\nbox_mm = [105, 30, 200]\ngate_mm = [30, 200]\nplate_mm = [200,"
        " 30]\nfill_height_mm = 60",
    )
    # the control: its slice weighs something else
    box = weighed("box", "box_mm = [105, 105, 200]", steps=60)
    assert (
        "pile: filled_mass_g" not in box.joint.posterior.tension["observable"].tolist()
    )
    assert any(
        "filled_mass_g, weighed of the pile as described" in note
        for note in box.seeds["pile"].notes
    )
    sd, before = (
        c.joint.table.set_index("factor").loc["seed_static_friction", "sd"]
        for c in (both, found)
    )
    assert (
        "pile: filled_mass_g" in both.joint.posterior.tension["observable"].tolist()
        and sd < 0.7 * before
    )
    assert {"restitution", "static_friction"} <= set(both.joint.posterior.draws)


def test_an_interrupted_calibration_can_go_on(bench, tmp_path, capsys, few_draws):
    class Interrupted(StandIn):
        def __call__(self, runs):
            if runs[0].rig == "roll":
                raise KeyboardInterrupt
            return super().__call__(runs)

    asked = dict(bench=bench, out=tmp_path / "out", quick=True, quiet=True)
    assert calibrate_command(simulator=Interrupted(), **asked) == FAILED
    assert "goes on where it stopped" in capsys.readouterr().err
    assert "still running" in (tmp_path / "out" / "report.html").read_text()
    assert calibrate_command(simulator=StandIn(), **asked) == DONE


@pytest.mark.parametrize(
    ("more", "reason"),
    [
        (
            {"ranges": {"seed_restitution": (0.7, 0.5)}},
            "seed_restitution: low must be below high; here are 0.7 and 0.5",
        ),
        ({"ranges": {"bounce": (0.5, 0.6)}}, "range of bounce: no such factor"),
        ({"priors": {"seed_restitution": (0.5, -1.0)}}, "sd above 0"),
        ({"priors": {"bounce": (0.5, 0.1)}}, "prior for bounce"),
    ],
)
def test_misuse_is_told_before_anything_is_simulated(
    bench, tmp_path, capsys, more, reason
):
    simulator = StandIn()
    assert (
        calibrate_command(bench, tmp_path / "out", **more, simulator=simulator)
        == MISUSED
    )
    assert (
        reason in capsys.readouterr().err
        and not simulator.runs
        and not (tmp_path / "out").exists()
    )


def test_a_publications_steps_are_simulated_where_they_are_asked_for(
    bench, tmp_path, capsys, few_draws
):
    simulator, out = StandIn(), tmp_path / "out"
    asked = dict(bench=bench, out=out, quick=True, quiet=True, method="surface")
    assert calibrate_command(
        simulator=simulator, **asked
    ) == DONE and capsys.readouterr() == (
        "",
        "",
    )
    told = json.loads((out / "result.json").read_text())
    assert told["options"]["effort"]["surface"] and len(told["parameters"]) == 6
    path = pd.read_csv(out / "tables" / "pile_path.csv")
    design = pd.read_csv(out / "tables" / "pile_design.csv")
    assert len(path) == 6 and len(design) == 12 + QUICK.centre
    # one box: of the path's groups beside the nearest
    at = path.loc[path["relative_error"].idxmin(), "group"]
    ends = path.set_index("group").loc[[at - 1, at + 1], list(SEED_FACTORS)]
    assert design[list(SEED_FACTORS)].min().to_numpy() == pytest.approx(ends.iloc[0])
    assert design[list(SEED_FACTORS)].max().to_numpy() == pytest.approx(ends.iloc[1])
    assert simulator.rigs["pile"] == 6 + 12 + QUICK.centre + QUICK.check
    text = (out / "report.html").read_text()
    assert (
        "Analysis of variance" in text and "the answer is the table at the top" in text
    )


def test_a_method_that_is_not_there_is_misuse(bench, tmp_path, capsys):
    asked = dict(bench=bench, out=tmp_path / "out", method="taguchi")
    assert calibrate_command(simulator=StandIn(), **asked) == MISUSED
    assert "--method taguchi: one of posterior, surface" in capsys.readouterr().err


def test_results_are_not_written_among_the_recordings(bench, capsys):
    assert calibrate_command(bench, bench / "out", simulator=StandIn()) == MISUSED
    assert "within the bench folder" in capsys.readouterr().err


def test_a_slice_stands_for_a_wide_pile_and_a_small_pile_for_itself():
    section, said = FULL.simulated(
        PILE,
        {
            "box_mm": [105.0, 105.0, 200.0],
            "plate_mm": [200.0, 200.0],
            "gate_speed_mm_s": 30.0,
        },
    )
    assert (
        section["box_mm"] == [105.0, 30.0, 200.0]
        and section["slab"]
        and section["gate_speed_mm_s"] == 30.0
        and said
    )
    assert (
        FULL.simulated(PILE, section) == (section, ())
        and replace(QUICK, slab=None).simulated(PILE, section)[1] == ()
    )


def test_a_slide_begins_a_little_below_its_onset():
    begun = _begun(
        Run("slide", {"static_friction": 0.34}, (1,), {"seed": {"count": 4}})
    )
    assert begun == {"seed": {"count": 4}, "slide": {"start_deg": 17.0}}
    assert _begun(Run("slide", {"static_friction": 0.03}, (1,)))["slide"] == {}
    assert seed_numbers(1, "a") != seed_numbers(2, "a")


@pytest.mark.slow
def test_intervals_hold_the_truth_over_forty_folders(tmp_path):
    """95 % intervals; of 40, fewer than 34 would happen once in a thousand."""
    hits = []
    for seed in range(40):
        folder = write_bench(tmp_path / str(seed), np.random.default_rng(500 + seed))
        found = calibrate_simulated(folder, StandIn(), effort=QUICK, seed=seed)
        t, truth = parameters(found).set_index("parameter"), pd.Series(TRUE)
        hits.append((t["low"] <= truth) & (truth <= t["high"]))
    assert (pd.DataFrame(hits).sum() >= 34).all(), pd.DataFrame(hits).sum()
