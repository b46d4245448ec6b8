"""The sample script that drops 500 soybeans."""

import runpy
from pathlib import Path

SCRIPT = Path(__file__).parents[2] / "samples" / "drop_500_soybeans.py"


def test_500_soybeans_come_to_rest_in_the_box():
    state, height, density, push = runpy.run_path(str(SCRIPT))["drop"]()
    assert state.count == 500 and 0.2 < state.time_s < 2.0
    assert 0.025 < height < 0.045
    assert 0.5 < density < 0.75
    share_on_floor = push / (9.81 * state.masses.sum())
    assert (
        0.6 < share_on_floor < 1.02
    )  # the sides carry some; seeds that barely move still make the push swing by 1 %


def test_it_fits_on_a_page():
    assert len(SCRIPT.read_text(encoding="utf8").splitlines()) <= 32
