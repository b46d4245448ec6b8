"""The form shows every key of the model with unit and help, and reads what people
type."""

import asyncio
from pathlib import Path
from types import SimpleNamespace

import pytest

from benchtwin.bench.keys import Keys
from benchtwin.bench.rigs import RIGS
from benchtwin.page.folder import Refused
from benchtwin.page.form import form
from benchtwin.page.toml_file import History
from benchtwin.page.views.keys_form import KeysForm

SHARES = {"coverage_sd"}  # which have no unit


def fields(rig):
    return {
        (f.section, f.key): f
        for s in form(rig, {"seed": {"length_mm": 8.7}}, {"seed": {"mass_g": 0.2}})
        for f in s.fields
    }


@pytest.mark.parametrize("rig", RIGS)
def test_every_key_of_a_rig_has_its_words(rig):
    found = fields(rig)
    assert {key for section, key in found if section == rig} == set(
        Keys.model_fields[rig].annotation.model_fields
    )
    assert all(f.help or f.kind == "conditions" for f in found.values())
    assert all(
        f.unit
        for f in found.values()
        if f.key.endswith(("_mm", "_deg", "_s", "_g", "_px", "_sd"))
        and f.key not in SHARES
    )


def test_values_and_what_is_inherited():
    found = fields("drop")
    assert (found["seed", "length_mm"].value, found["seed", "mass_g"].inherited) == (
        8.7,
        0.2,
    )
    assert found["seed", "length_mm"].bounds == "above 0.05, up to 2000"


@pytest.mark.parametrize(
    ("key", "typed", "value"),
    [
        (("seed", "length_mm"), "8,72", 8.72),
        (("seed", "length_mm"), " 8.72 mm", 8.72),
        (("seed", "count"), "4", 4),
        (("seed", "mass_g"), "", None),
        (("pile", "box_mm"), "105, 105, 200", [105, 105, 200]),
        (("pile", "box_mm"), "105,5 105 200", [105.5, 105, 200]),
        (("", "session"), " a day ", "a day"),
    ],
)
def test_what_people_type_is_read(key, typed, value):
    assert fields("pile")[key].read(typed) == value


def test_words_in_the_place_of_a_number_are_refused():
    with pytest.raises(Refused, match="length_mm: 'long' is not a number"):
        fields("drop")["seed", "length_mm"].read("long")


@pytest.mark.parametrize("rig", ["heap", 3, ["pile"], None])
def test_whatever_a_file_says_there_is_a_form_that_takes_it_away(rig):
    content = {"rig": rig, "camera": 3, "blue": 1, "seed": {"lenght_mm": 8}}
    wrong = {(f.section, f.key): f for f in form(rig, content, {"air": 2})[0].fields}
    assert {*wrong} == {("", "camera"), ("", "blue"), ("seed", "lenght_mm")}
    assert wrong["", "camera"].read("") is None
    with pytest.raises(Refused, match="blue is not known: empty the field"):
        wrong["", "blue"].read("2")


class Shown:
    """In the place of a label."""

    def set_text(self, text: str) -> None:
        self.text = text


def a_form(file: Path) -> KeysForm:
    """A tab's form of one file, without its fields."""
    made = KeysForm.__new__(KeysForm)
    made.site, made.path, made.saved = SimpleNamespace(history=History()), file, None
    made.refused, made.inputs = set(), {}
    made.loaded = {("drop", "height_mm"): 100.0}
    made.status = Shown()
    return made


def test_what_another_tab_has_set_is_not_overwritten_until_it_is_typed_again(tmp_path):
    file, place = tmp_path / "recording.toml", ("drop", "height_mm")
    file.write_text("[drop]\nheight_mm = 100.0\n")
    one, other = a_form(file), a_form(file)
    asyncio.run(one.change(place, 200.0))
    asyncio.run(other.change(place, 300.0))
    assert "height_mm = 200.0" in file.read_text() and other.refused == {place}
    assert "changed meanwhile, elsewhere" in other.status.text
    asyncio.run(other.change(place, 301.0))
    assert "height_mm = 301.0" in file.read_text() and not other.refused
