"""The sample script that drops 500 soybeans."""

import runpy
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "samples" / "drop_500_soybeans.py"


def test_500_soybeans_come_to_rest_in_the_box():
    state, height, density, push = runpy.run_path(str(SCRIPT))["drop"]()
    assert state.count == 500 and 0.2 < state.time_s < 2.0
    assert 0.025 < height < 0.045
    assert 0.5 < density < 0.75
    weight = 9.80665 * state.masses.sum()
    # seeds that barely move still make the push swing by 1 %
    assert -state.wall_load[:, 2].sum() == pytest.approx(weight, rel=0.02)
    # sides carry some; pressed by the fall, seeds spring back and hang from them: more
    assert 0.6 < push / weight < 1.1


def test_it_fits_on_a_page():
    assert len(SCRIPT.read_text(encoding="utf8").splitlines()) <= 32
