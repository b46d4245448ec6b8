"""docs/diagnose.md knows every effect, with its unit and whether it has a sign."""

from pathlib import Path

import pytest

from diagnose.effects import drop, pile, roll, slide

TEXT = (Path(__file__).parents[2] / "docs" / "diagnose.md").read_text(encoding="utf8")
OF_RIG = {"drop": drop.EFFECTS, "slide": slide.EFFECTS, "roll": roll.EFFECTS, "pile": pile.EFFECTS}


@pytest.mark.parametrize("rig", OF_RIG)
def test_every_effect_has_its_row(rig):
    rows = [line for line in TEXT.splitlines() if line.startswith(f"| {rig} |")]
    for effect in OF_RIG[rig].values():
        if effect.group or effect.unlisted or "." in effect.name:
            continue
        own = next((row for row in rows if f"`{effect.name}`" in row), "")
        assert own, effect.name
        if rig == "pile" and "tilt" not in effect.name and "roll" not in effect.name:
            continue  # shapes have no one number
        if not effect.unit:
            continue
        assert f"[{effect.unit}]" in own, effect.name
        assert ("≥ 0" in own) == (effect.low >= 0), effect.name
