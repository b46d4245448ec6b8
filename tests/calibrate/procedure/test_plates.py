"""Plates of seeds in a calibration: what is simulated of them, how their scatter
counts, what they tell."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from stand_in import NEAR, TRUE, StandIn, write_bench

from benchtwin.bench.tells import by_surface
from benchtwin.calibrate.procedure.calibration import advice
from benchtwin.calibrate.procedure.effort import QUICK
from benchtwin.calibrate.procedure.observed import scatter_apart
from benchtwin.calibrate.procedure.rigs import PILE
from benchtwin.calibrate.procedure.simulated import Prescribed, calibrate_simulated
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.surrogate import fit_surrogate

SLIDES, DROPS = by_surface()["seed-slide"], by_surface()["seed-drop"]


class OnSeeds(StandIn):
    """The stand-in, with drops on a plate of seeds: h = 310 · 0.5 e², ten a run, and a
    little less where seeds lie denser."""

    def __call__(self, runs) -> pd.DataFrame:
        table = super().__call__(runs)
        for k, run in enumerate(runs):
            section = run.description.get("drop", {})
            if run.rig == "drop" and "plate" in section:
                rng = np.random.default_rng([*run.rng, 1])
                rise = 155 * run.values["seed_restitution"] ** 2
                rise -= 20 * (section["coverage"] - 0.78)
                rises = rise + 20 * rng.standard_normal(10)
                table.loc[k, "rebound_height_mm"] = rises.mean()
                table.loc[k, "true_sd_mm"] = rises.std(ddof=1)
        return table


def test_heaps_still_choose_the_design():
    assert next(iter(by_surface())) == PILE.name == "pile"


def test_the_scatter_of_runs_is_taken_apart():
    """Cards differ by 1.5°, slides of one card by 4°; where runs do not show it, all is
    of single ones."""
    rng, n = np.random.default_rng(1), 2000
    slides = 40 + rng.normal(0, 1.5, (n, 1)) + rng.normal(0, 4.0, (n, 2))
    runs = pd.DataFrame(
        {
            "seed_static_friction": rng.uniform(0.2, 0.7, n),
            "slide_angle_deg": slides.mean(axis=1),
            "true_sd_deg": slides.std(axis=1, ddof=1),
        }
    )
    box = Box.of({"seed_static_friction": (0.2, 0.7)})
    surface = fit_surrogate(runs, "slide_angle_deg", box)
    between, within = scatter_apart(surface, runs, SLIDES)
    assert within == pytest.approx(4.0, rel=0.05)
    assert between == pytest.approx(1.5, rel=0.15)
    alone = scatter_apart(surface, runs.drop(columns="true_sd_deg"), SLIDES)
    assert alone == pytest.approx((0.0, surface.noise_sd * np.sqrt(2)))


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Forty drops on a plate, nothing else of seed on seed."""
    bench = tmp_path_factory.mktemp("plates") / "b"
    write_bench(bench, np.random.default_rng(3))
    for rig in ("pile", "roll", "slide"):
        for file in (bench / rig).iterdir():
            file.unlink()
        (bench / rig).rmdir()
    (bench / "plate").mkdir()
    toml = 'rig = "drop"\n[drop]\nplate = "seeds"\nheight_mm = 310\ncoverage = 0.78\n'
    (bench / "plate" / "recording.toml").write_text(toml)
    rise = 155 * TRUE["seed_restitution"] ** 2
    rises = rise + 20 * np.random.default_rng(4).standard_normal(40)
    table = pd.DataFrame({"rebound_height_mm": rises})
    table.to_csv(bench / "plate" / "readings.csv", index=False)
    simulator = OnSeeds()
    effort = replace(QUICK, draws=200, more=0, unrecorded=False)
    near = Prescribed(ranges=NEAR)
    found = calibrate_simulated(
        bench, simulator, effort=effort, seed=5, prescribed=near
    )
    return found, simulator


def test_drops_on_seeds_tell_restitution_of_seed_on_seed(found):
    """By δe = δh / (310 e): 20 mm / √40 are 0.017."""
    c, _ = found
    e = c.joint.posterior.draws["seed_restitution"]
    assert abs(e.mean() - TRUE["seed_restitution"]) < 3 * e.std()
    assert 0.012 < e.std() < 0.03
    of_steel = c.joint.posterior.draws["restitution"]
    assert of_steel.mean() == pytest.approx(TRUE["restitution"], abs=0.03)


def test_what_glue_may_take_is_in_the_sd_of_the_rise(found):
    """2 % of about 56 mm, beside 20 mm/√40; none where it is stated."""
    c, _ = found
    (rise,) = c.seeds["seed-drop"].observables
    assert rise.bench.shared_sd == pytest.approx(0.02 * rise.bench.value, rel=0.2)
    assert DROPS.left_out({"glue_loss": 0.1}) == 0.0


def test_they_are_simulated_as_stated_and_coverage_varies_along(found):
    c, simulator = found
    sections = [r.description["drop"] for r in simulator.runs if r.rig == "drop"]
    on_seeds = [s for s in sections if "plate" in s]
    assert {s["drops"] for s in on_seeds} == {DROPS.per_run}
    assert {s["height_mm"] for s in on_seeds} == {310.0}
    assert {0.75, 0.81} <= {round(s["coverage"], 6) for s in on_seeds}
    assert all("coverage" not in s for s in sections if "plate" not in s)
    assert "seed–seed" not in " ".join(c.refused)
    assert not any("coverage is not stated" in n for n in c.seeds["seed-drop"].notes)


def test_single_readings_that_scatter_more_than_means_contradict_nothing(found):
    c, _ = found
    assert c.seeds["seed-drop"].findings == ()


def test_what_is_left_open_names_the_test_that_tells_it(found):
    """Friction and rolling friction are left open by drops: a card on a plate of seeds
    tells the one, nothing by itself the other."""
    c, _ = found
    slides, general, *_ = advice(c)
    assert slides.startswith("seed_static_friction: slides on a plate of seeds tell it")
    assert "docs/seed-plate.md" in slides and SLIDES.sample in slides
    assert "drops on a plate" not in slides
    assert general.startswith("seed_static_friction and seed_rolling_friction:")
    assert "--next-test" in general


def test_the_samples_that_show_a_test_are_there():
    root = Path(__file__).parents[3]
    for rig in (DROPS, SLIDES):
        assert (root / rig.sample / "readings.csv").is_file()
        assert (root / "docs" / rig.page).is_file()
