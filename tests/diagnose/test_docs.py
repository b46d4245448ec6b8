"""docs/diagnose.md lists every effect with its unit and sign, and no effect that is not
there."""

import re
from pathlib import Path

import pytest

import benchtwin.rigs.drop.effects as drop
import benchtwin.rigs.pile.effects as pile
import benchtwin.rigs.roll.effects as roll
import benchtwin.rigs.slide.effects as slide

TEXT = (Path(__file__).parents[2] / "docs" / "diagnose.md").read_text(encoding="utf8")
OF_RIG = {
    "drop": drop.EFFECTS,
    "slide": slide.EFFECTS,
    "roll": roll.EFFECTS,
    "pile": pile.EFFECTS,
}


@pytest.mark.parametrize("rig", OF_RIG)
def test_the_table_of_effects_is_that_of_the_code(rig):
    rows = dict(re.findall(rf"^\| {rig} \| `([\w-]+)` \| ([^|]*)", TEXT, re.MULTILINE))
    effects = {n: e for n, e in OF_RIG[rig].items() if not (e.group or e.unlisted)}
    assert set(rows) == set(effects)
    for name, effect in effects.items():
        if rig == "pile" and "tilt" not in name and "roll" not in name:
            continue  # the shape of a heap has no single number
        assert not effect.unit or f"[{effect.unit}]" in rows[name], name
        assert not effect.unit or ("≥ 0" in rows[name]) == (effect.low >= 0), name
