"""What was named is put into the twin: laws in their own numbers, flights that agree
with closed forms, a fit that improves."""

import json
from dataclasses import replace
from pathlib import Path

import falling
import numpy as np
import pytest

import benchtwin.rigs.drop.effects as drop
import benchtwin.rigs.pile.effects as pile
import benchtwin.rigs.roll.effects as roll
import benchtwin.rigs.slide.effects as slide
from benchtwin.bench.air import air_of
from benchtwin.diagnose.rerun import (
    Comparison,
    Resimulation,
    condition_shifts,
    reason_not_simulated,
    simulation_settings,
)
from benchtwin.infer.finding import Finding
from benchtwin.infer.follow import Follow
from benchtwin.infer.verdict import Interval
from benchtwin.rigs.drop.flown import fly, strike
from benchtwin.rigs.drop.impact_resimulation import NUMBERS_OF_FALL
from benchtwin.rigs.drop.resimulation import laws_of, session_flights
from benchtwin.rigs.roll.resimulation import laws_of as rolling_laws
from benchtwin.sim.laws import LAWS
from benchtwin.twin.lone_seed import drag_factor
from benchtwin.twin.parameters import Parameters

OF_RIG = {
    "drop": drop.EFFECTS,
    "slide": slide.EFFECTS,
    "roll": roll.EFFECTS,
    "pile": pile.EFFECTS,
}
TOLD = {"seed": falling.STATED, "air": {"density_kg_m3": 0.0}}
DRAG = LAWS["drag"].function


@pytest.mark.parametrize("rig", OF_RIG)
def test_every_effect_has_a_counterpart_or_a_reason_why_none(rig):
    for name, effect in OF_RIG[rig].items():
        if effect.group or "." in name:
            continue
        assert bool(effect.counterpart) != bool(effect.not_simulated), name
        assert reason_not_simulated(rig, name) == effect.not_simulated
        if effect.counterpart:
            assert effect.counterpart.what.format(value="0.1")
        if rig == "pile":
            assert bool(effect.law.twin) == bool(effect.counterpart), name
            assert effect.law.most(10.0) > 0


@pytest.mark.parametrize("rig", ["drop", "slide"])
def test_what_stands_for_an_effect_is_a_law_of_the_twin_with_its_number(rig):
    for name, effect in OF_RIG[rig].items():
        if effect.counterpart is None:
            continue
        change = simulation_settings(rig, {name: 0.05})
        by_picture = effect.picture or effect.clock  # such a law is the camera's own
        assert bool(change) != bool(by_picture), name
        for law, numbers in change.get("laws", {}).items():
            LAWS[law].use(
                **(
                    NUMBERS_OF_FALL[law](numbers["fall"], 0.5, 1.0)
                    if "fall" in numbers
                    else numbers
                )
            )
        for law, numbers in laws_of(
            TOLD, air_of(TOLD), change.get("air", {}), 2.0
        ).items():
            LAWS[law].use(**numbers)


def test_the_twin_gets_reported_values_and_several_effects_at_once():
    assert simulation_settings("drop", {"film-adhesion": 0.01})["laws"][
        "restitution_film"
    ]["film_speed"] == pytest.approx(0.1)
    both = simulation_settings(
        "drop",
        {"drag": 0.02, "draught": 0.3, "plate-tilt": 1.0, "perspective.ruler": 0.1},
    )
    assert both == {
        "air": {"share": 0.02, "at_m_s": 2.0, "wind_x": 0.3},
        "rig": {"tilt_deg": 1.0},
    }


def test_a_parameter_that_follows_conditions_is_each_recordings_own():
    names = tuple(f"drop-{k}" for k in range(4))
    nil = Interval(0.0, 0.0, 0.0)
    follows = tuple(
        Follow("restitution", c, "line", 0.0, 1.0, nil, (), (), {}, {}, {}, {})
        for c in ("moisture_pct", "plate")
    )
    left_out = {
        follows[0].name: (0.03, 0.01, -0.01, -0.03),
        follows[1].name: (0.02, -0.02, -0.02, 0.02),
    }
    found = Finding(
        "drop",
        names,
        True,
        0.0,
        (),
        None,
        "",
        "name",
        tuple(left_out),
        9.0,
        9.0,
        {},
        None,
        None,
        None,
        follows=follows,
        left_out=left_out,
    )
    more = condition_shifts(found)
    assert list(more.values()) == pytest.approx([0.05, -0.01, -0.03, -0.01])
    assert reason_not_simulated("drop", "restitution-follows-plate") == ""
    assert "one rolling friction" in reason_not_simulated(
        "roll", "rolling_friction-follows-x"
    )


def test_drag_in_the_units_of_the_diagnosis():
    """A flight that begins at 2 m/s downwards is slowed by `share` of its weight."""
    laws = {"drag": drag_factor(TOLD, 0.05)}
    flown = fly(TOLD, laws, np.array([[0.0, 0.0, 0.0, -2.0, 0.0]]), np.zeros(1), 0.01)
    fall = (flown.speeds[3, 0, 1] - flown.speeds[1, 0, 1]) / (
        flown.t_s[3] - flown.t_s[1]
    )
    assert fall == pytest.approx(-9.80665 * (1 - 0.05), rel=2e-3)


def test_drag_of_a_roll_counts_at_half_a_metre_a_second():
    """TOLD states no air, so all of it is what is missing: 0.01 of the weight at 0.5
    m/s."""
    flown = fly(
        TOLD,
        rolling_laws(TOLD, {"drag": 0.01}),
        np.array([[0.0, 0.0, 0.5, 0.0, 0.0]]),
        np.zeros(1),
        0.01,
    )
    slowed = (flown.speeds[3, 0, 0] - flown.speeds[1, 0, 0]) / (
        flown.t_s[3] - flown.t_s[1]
    )
    assert slowed == pytest.approx(-9.80665 * 0.01, rel=0.01)


def test_a_twin_without_air_flies_a_parabola():
    flown = fly(
        TOLD,
        {"drag": drag_factor(TOLD, 0.0)},
        np.array([[0.1, 0.3, 0.2, 1.0, 0.0]]),
        np.zeros(1),
        0.2,
    )
    time = np.linspace(0, 0.2, 77)
    exact = np.column_stack([0.1 + 0.2 * time, 0.3 + time - 9.80665 * time**2 / 2])
    assert (
        np.abs(flown.at(0, time) - exact).max() < 2e-6
    )  # half a step of 1e-5 s at 1 m/s


def test_a_twins_bounce_has_its_restitution_and_its_plates_tilt():
    before = np.array([[0.0, -1.0, 0.0], [0.0, -2.0, 0.0]])
    ball = {"seed": {"length_mm": 7.0, "mass_g": 0.2}, "air": {"density_kg_m3": 0.0}}
    smooth = Parameters(restitution=0.6, static_friction=0.0, rolling_friction=0.0)
    level, tilted = (
        strike(
            ball,
            {"drag": drag_factor(ball, 0.0)},
            smooth,
            before,
            np.ones(2, bool),
            np.random.default_rng(1),
            tilt_deg=a,
            copies=2,
        )
        for a in (0.0, 1.0)
    )
    assert -level.after[:, :, 1] / before[:, 1:2] == pytest.approx(
        np.full((2, 2), 0.6), abs=0.005
    )
    assert level.after[:, :, 0] == pytest.approx(0.0, abs=1e-6)
    kick = (
        1.6 * np.array([1.0, 2.0]) * np.sin(np.radians(1.0)) * np.cos(np.radians(1.0))
    )
    assert tilted.after[:, 0, 0] == pytest.approx(kick, rel=0.02)


@pytest.mark.parametrize(
    ("effect", "change"),
    [
        ("drag", {"stated_air": 0.0}),
        ("camera-roll", {"roll_deg": 1.0}),
        ("scale-error", {"scale": 0.02}),
    ],
)
def test_the_twin_that_flies_with_the_effect_agrees_to_the_noise(effect, change):
    tracks = falling.tracks(
        falling.Bench(bounces=1, noise_mm=0.03, rho=0.5, **change),
        2,
        np.random.default_rng(3),
    )
    (flights,) = session_flights(tracks, (effect,))
    rows = list(flights.compared(flights.read(without=(effect,)), flights.read()))
    assert [r.recording for r in rows] == ["drop-00", "drop-01"]
    for row in rows:
        assert (
            row.after < 0.036 < row.before
        )  # the noise is 0.03 mm, the twin's own share of it small


def test_air_of_the_diagnosis_and_of_the_dem_agree():
    """Two fits to the same measured spheres: within 3 % at a seed's speeds."""
    air = air_of(TOLD | {"air": {"density_kg_m3": 1.2}})
    assert 1 / drag_factor(TOLD, air.share)["factor"] == pytest.approx(1.0, abs=0.03)


@pytest.mark.slow
def test_the_full_chain_from_a_hidden_law_to_the_improved_simulation(tmp_path):
    """DEM with air → rendered frames → tracker → diagnosis that is told of no air → DEM
    with air again, rendered and followed."""
    from typer.testing import CliRunner

    from benchtwin.command_line import app
    from benchtwin.twin import Parameters, simulate
    from benchtwin.twin.paths import like

    bench = tmp_path / "bench"
    bench.mkdir()
    (bench / "bench.toml").write_text("[air]\ndensity_kg_m3 = 0.0\n")
    seed = {
        "length_mm": 8.4,
        "width_mm": 7.2,
        "thickness_mm": 6.8,
        "density_kg_m3": 300.0,
    }  # light: four times a soybean's drag
    for k in range(3):
        camera = {"fps": 500.0, "mm_per_px": 0.27, "mm_per_px_sd": 0.0002}
        told = {
            "seed": seed,
            "drop": {"height_mm": 310.0, "bounces": 1},
            "camera": camera,
        }
        out = bench / f"drop-{k + 1}"
        simulate(
            "drop",
            Parameters(restitution=0.5),
            rng=np.random.default_rng(k),
            out=out,
            like=like("drop", told),
        )
        toml = (out / "recording.toml").read_text()
        start = toml.index("[air]")
        end = toml.find("\n[", start + 1)
        (out / "recording.toml").write_text(
            toml[:start] + (toml[end + 1 :] if end > 0 else "")
        )
        (out / "simulation.json").unlink()
    result = CliRunner().invoke(
        app, ["diagnose", str(bench), "--out", str(tmp_path / "out")]
    )
    drop = json.loads((tmp_path / "out" / "diagnosis.json").read_text())["rigs"]["drop"]
    assert drop["verdict"] == "name" and drop["names"] == ["drag"], result.output
    true = air_of({"seed": seed, "air": {"density_kg_m3": 1.2}}).share
    assert (
        drop["parameters"]["drag"]["low95"] < 1.03 * true
        and drop["parameters"]["drag"]["high95"] > 0.97 * true
    )
    twin = drop["twin"]
    assert twin["rmse_after"] < 0.6 * twin["rmse_before"]
    (rendered,) = [r for r in twin["recordings"] if r["by"] == "pictures"]
    assert rendered["after"] < rendered["before"]
    assert (Path(tmp_path) / "out" / "twin").is_dir()


@pytest.mark.parametrize(
    ("odds", "said"),
    [
        (20.0, "; simulations make it 20 times as likely as that it is warm"),
        (0.05, "; simulations make it 20 times likelier that it is warm"),
        (3.0, "; whether it is warm instead, simulations do not tell"),
    ],
)
def test_a_twin_says_what_repeats_scatter_and_what_else_it_may_be(odds, said):
    rows = (Comparison("pile-1", "surface", "1", 0.05, 0.02, "outline"),)
    again = Resimulation("pile", ("cohesion",), "it is damp", "", rows, True)
    told = replace(again, repeats=0.015, rival=("it is warm", odds))
    assert again.in_words() + said == told.in_words().replace(
        ", and repeats are off each other's mean by 0.015", ""
    )
    assert told.to_json()["rmse_repeats"] == 0.015
