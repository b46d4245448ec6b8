"""Records of effects are checked when a folder of them is read, as laws and rigs
are."""

import sys
from dataclasses import replace

import pytest

from benchtwin.infer.effect import Effect, discovered
from benchtwin.rigs.pile.effects.shapes import HeapEffect

WIND = Effect("wind", "flight", "m/s", "speed of the wind", 0.3, -3.0, 3.0, "none")


def folder_of(tmp_path, monkeypatch, *files: list[Effect]):
    """A package with a module of EFFECTS for each of `files`."""
    (tmp_path / "own_effects").mkdir()
    (tmp_path / "own_effects" / "__init__.py").touch()
    for k in range(len(files)):
        text = f"import test_effect_records as t\nEFFECTS = t.GIVEN[{k}]\n"
        (tmp_path / "own_effects" / f"m{k}.py").write_text(text)
    monkeypatch.setitem(sys.modules, "test_effect_records", sys.modules[__name__])
    monkeypatch.setattr(sys.modules[__name__], "GIVEN", files, raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    for name in [n for n in sys.modules if n.partition(".")[0] == "own_effects"]:
        monkeypatch.delitem(sys.modules, name)
    return "own_effects", [str(tmp_path / "own_effects")]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"low": 1.0, "high": 0.0}, "low = 1.0, high = 0.0: low must be below high"),
        ({"low": 0.1}, "0, no effect, between"),
        ({"prior_sd": -1.0}, "prior_sd = -1.0: must be above 0"),
        ({"prior_sd": float("nan")}, "prior_sd = nan"),
        ({"sector": "sky"}, "sector = 'sky': must be one of flight"),
        ({"group": "storm"}, "there is no effect 'storm', a group's name"),
    ],
)
def test_a_record_that_cannot_be_weighed_is_refused(
    tmp_path, monkeypatch, change, words
):
    package = folder_of(tmp_path, monkeypatch, [replace(WIND, **change)])
    with pytest.raises(ValueError, match=words) as told:
        discovered(*package)
    assert str(told.value).startswith("own_effects")


def test_two_of_one_name_are_refused(tmp_path, monkeypatch):
    package = folder_of(tmp_path, monkeypatch, [WIND], [replace(WIND, unit="mm/s")])
    with pytest.raises(ValueError, match=r"own_effects\.m1: there is another .*'wind'"):
        discovered(*package)


def test_what_is_no_record_is_refused(tmp_path, monkeypatch):
    """Nor is one of another rig's kind left out without a word."""
    package = folder_of(tmp_path, monkeypatch, [WIND])
    with pytest.raises(ValueError, match=r"m0: Effect\(.* is no HeapEffect"):
        discovered(*package, HeapEffect)


def test_records_that_can_are_found(tmp_path, monkeypatch):
    gusts = replace(WIND, name="wind.gusts", group="wind")
    package = folder_of(tmp_path, monkeypatch, [WIND], [gusts])
    assert list(discovered(*package)) == ["wind", "wind.gusts"]
