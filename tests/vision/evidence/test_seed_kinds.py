"""Published seeds: every number has a source and a possible value; what is taken from
them is said, and only what is absent."""

import pytest

from benchtwin.bench.seed_kinds import (
    kinds,
    known,
    published_contact_parameters,
    with_published_values,
)
from benchtwin.calibrate.procedure.rigs import RANGES
from benchtwin.vision.evidence.read_keys import validate
from benchtwin.vision.measurement import MeasurementError

POSSIBLE = {
    "length_mm": (0.2, 40),
    "width_mm": (0.2, 40),
    "thickness_mm": (0.2, 40),
    "density_kg_m3": (500, 3000),
    "restitution": (0.02, 1),
    "static_friction": (0.02, 1.5),
    "rolling_friction": (0.0, 0.5),
}


@pytest.mark.parametrize("kind", kinds())
def test_every_number_has_a_source_and_is_possible(kind):
    for entry in kinds()[kind]:
        low, high = POSSIBLE[entry.quantity]
        assert low <= entry.low <= entry.high <= high, entry
        assert len(entry.source) > 30
        assert bool(entry.on) == (
            entry.quantity in ("restitution", "static_friction", "rolling_friction")
        ), entry


@pytest.mark.parametrize("kind", kinds())
def test_length_is_the_longest_and_thickness_the_shortest(kind):
    section, _ = with_published_values({"kind": kind})
    if "length_mm" in section:
        assert section["length_mm"] >= section["width_mm"] >= section["thickness_mm"]


def test_only_what_is_absent_is_taken_and_every_value_is_said():
    section, said = with_published_values({"kind": "maize"})
    assert section["thickness_mm"] == pytest.approx(4.69)
    assert len(said) == 4 and all(
        "taken as published for maize" in line for line in said
    )
    stated = {
        "kind": "maize",
        "length_mm": 9.0,
        "width_mm": 8.0,
        "thickness_mm": 4.0,
        "mass_g": 0.2,
    }
    assert with_published_values(stated) == (stated, [])
    assert (
        "length_mm"
        not in with_published_values({"kind": "maize", "shape": "kernel.stl"})[0]
    )
    assert with_published_values({}) == ({}, [])


def test_a_kind_without_published_sizes_gives_none():
    assert with_published_values({"kind": "sunflower"}) == ({"kind": "sunflower"}, [])


def test_contacts_are_told_with_their_surface():
    assert any(
        "static_friction on stainless steel: 0.38 to 0.44" in line
        for line in published_contact_parameters("lentil")
    )
    assert not any("length" in line for line in published_contact_parameters("lentil"))


def test_an_unknown_kind_is_named_with_those_that_there_are(tmp_path):
    with pytest.raises(ValueError, match="must be one of soybean, maize"):
        known("corn")
    with pytest.raises(MeasurementError, match="soybean"):
        validate({"seed": {"kind": "corn"}}, tmp_path / "bench.toml")


def test_a_calibration_looks_where_published_seeds_are():
    """Of every kind of seeds on themselves; a range that leaves one out would be a
    prior that calls it impossible."""
    on_themselves = [
        row for rows in kinds().values() for row in rows if row.on == "itself"
    ]
    assert len({row.quantity for row in on_themselves}) == 3
    for row in on_themselves:
        low, high = RANGES[f"seed_{row.quantity}"]
        assert low < row.low and row.high < high, row
