"""Heaps run again in the DEM: its settings, what a heap at a strength would be, and a
hidden cohesion from photos to the twin."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from heaping import Heap, repeats

from benchtwin.rigs.pile.diagnose import diagnose_pile
from benchtwin.rigs.pile.effects import EFFECTS
from benchtwin.rigs.pile.read import read_piles
from benchtwin.rigs.pile.resimulation import (
    FRICTIONS,
    Kind,
    _compared,
    _fitted,
    resimulate,
)
from benchtwin.rigs.pile.simulated_heaps import (
    AT,
    HeapSettings,
    Shape,
    shape_of,
    simulation_inputs,
)
from benchtwin.twin.parameters import Parameters, bench
from benchtwin.twin.run import simulate

TOLD = {
    "seed": {
        "length_mm": 8.7,
        "width_mm": 6.8,
        "thickness_mm": 6.0,
        "density_kg_m3": 1250.0,
    },
    "pile": {
        "box_mm": [60.0, 60.0, 120.0],
        "plate_mm": [140.0, 120.0],
        "fill_height_mm": 60.0,
        "gate_speed_mm_s": 100.0,
    },
}


def test_cohesion_of_strength_one_pulls_with_a_seeds_weight_and_grows_as_its_size():
    own = simulation_inputs(TOLD, HeapSettings(0.5, "cohesion", 1.0), 8.7)
    weight = 9.80665 * 1250 * np.pi / 6 * 8.7e-3 * 6.8e-3 * 6.0e-3
    assert own[1].laws["film_adhesion"]["pull"] == pytest.approx(weight, rel=1e-5)
    larger = {n: dict(v) for n, v in TOLD.items()}
    larger["seed"] |= {"length_mm": 17.4, "width_mm": 13.6, "thickness_mm": 12.0}
    twice = simulation_inputs(larger, HeapSettings(0.5, "cohesion", 1.0), 8.7)
    assert twice[1].laws["film_adhesion"]["pull"] == pytest.approx(2 * weight, rel=1e-5)
    assert (
        simulation_inputs(TOLD, HeapSettings(0.5, "cohesion", 0.0), 8.7)[1].laws[
            "film_adhesion"
        ]["pull"]
        == 0.0
    )


def test_what_is_named_is_changed_and_nothing_else():
    usual, _ = simulation_inputs(TOLD, HeapSettings(0.5, "gate-speed", 0.0), 8.7)
    faster, _ = simulation_inputs(TOLD, HeapSettings(0.5, "gate-speed", 1.0), 8.7)
    assert (usual.pile.gate_speed_mm_s, faster.pile.gate_speed_mm_s) == (100.0, 200.0)
    assert usual.pile.slab and usual.pile.box_mm[1] == pytest.approx(3.5 * 8.7)
    longer, _ = simulation_inputs(TOLD, HeapSettings(0.5, "particle-shape", 0.2), 8.7)
    volume = [
        s.seed.length_mm * s.seed.width_mm * s.seed.thickness_mm
        for s in (usual, longer)
    ]
    assert longer.seed.length_mm == pytest.approx(1.2 * 8.7) and volume[
        1
    ] == pytest.approx(volume[0])
    walled, parameters = simulation_inputs(
        TOLD, HeapSettings(0.5, "wall-friction", 1.0), 8.7
    )
    assert not walled.pile.slab and walled.pile.box_mm[1] == 60.0
    assert (
        bench(parameters, "pile", walled.seed, walled.air).seed_wall.static_friction
        == Parameters().static_friction
    )


@pytest.mark.parametrize(
    ("pile", "says"),
    [
        ({}, "neither"),
        ({"box_mm": [105, 105, 200], "fill_height_mm": 100}, None),
        ({"cylinder_mm": [200, 300]}, "seeds takes"),
    ],
)
def test_rigs_that_cannot_be_run_are_refused_before_anything_runs(pile, says):
    if says is None:
        simulation_inputs(
            TOLD | {"pile": pile}, HeapSettings(0.5, "cohesion", 1.0), 8.7
        )  # a slice of it can
        return
    with pytest.raises(ValueError, match=says):
        simulation_inputs(
            TOLD | {"pile": pile}, HeapSettings(0.5, "cohesion", 1.0), 8.7
        )


def test_friction_and_strength_are_found_on_the_other_half_of_the_recordings():
    """Shapes that are linear in both are fitted back; without the effect friction alone
    does what it can."""
    heaps = repeats(Heap(), np.random.default_rng(1), 4)
    target = shape_of(heaps[1::2])
    crest = np.exp(-0.5 * (AT / 0.2) ** 2)

    def shape(friction: float, strength: float) -> Shape:
        return Shape(
            target.surface + (strength - 0.25) * 0.4 * crest,
            target.angle_deg + 20 * (friction - 0.4),
        )

    strengths = tuple(
        shape(FRICTIONS[0], s) for s in (0.0, *EFFECTS["cohesion"].law.strengths)
    )
    kind = Kind(tuple(heaps), tuple(shape(f, 0.0) for f in FRICTIONS), strengths)
    new = _fitted([kind], 0, "cohesion", True)
    assert new.strength == pytest.approx(
        0.25, abs=0.03
    ) and new.friction == pytest.approx(0.4, abs=0.03)
    assert _fitted([kind], 0, "cohesion", False).strength == 0.0


def test_a_simulated_heap_that_is_less_steep_has_an_error():
    heaps = repeats(Heap(), np.random.default_rng(1), 2)
    own = shape_of(heaps[:1])
    flat, steep = replace(own, angle_deg=own.angle_deg - 6), own
    surface, angle = _compared(heaps[:1], flat, steep, "outline")
    assert surface.before > 0.03 and surface.after == 0
    assert (angle.before, angle.after) == (pytest.approx(6.0), 0.0)


@pytest.mark.slow
def test_cohesion_in_the_dem_is_found_from_photos_and_improves_the_simulation(tmp_path):
    """DEM with a film's pull → photos → measured → diagnosed → the DEM again.

    Heaps of one kind cannot say for certain what makes them steep, and are few seeds
    high: the right answer is that cohesion is possible, at most. The twin with it,
    given the other half's numbers, is nearer to them."""
    hidden = simulation_inputs(TOLD, HeapSettings(0.5, "cohesion", 0.4), 8.7)
    for k in range(4):
        out = tmp_path / "bench" / f"pile-{k + 1}"
        out.parent.mkdir(exist_ok=True)
        simulate(
            "pile",
            hidden[1],
            rng=np.random.default_rng([77, k]),
            out=out,
            like=hidden[0],
            threads=1,
        )
        (out / "simulation.json").unlink()
    seen = read_piles(tmp_path / "bench")
    assert not [s.trouble for s in seen if s.trouble]
    found = diagnose_pile(seen, np.random.default_rng(1))
    assert found.verdict != "name" and (
        found.verdict != "class" or "cohesion" in found.names
    )
    stand_in = SimpleNamespace(
        modelled=("cohesion",), recordings=tuple(s.recording for s in seen)
    )
    again = resimulate(stand_in, seen, tmp_path / "twin", True, lambda text: None)
    before, after, unit, _ = again.total()
    assert after < 0.9 * before and unit == "1"
    assert (
        again.held_out
        and again.picture
        and {c.by for c in again.compared} == {"pictures"}
    )
