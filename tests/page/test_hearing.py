"""What a click on the sound means for the keys, and the waveform that is drawn."""

from pathlib import Path

import numpy as np
import pytest

from page.hearing import Hearing, clicked, waveform
from vision.evidence.keys import Drop
from vision.evidence.sound import Sound

NOW = Hearing(impacts=[1.0, 1.3], added=[1.3], struck=[0.5], others=[0.502, 1.5])
ADDED, STRUCK = ("drop", "impacts_added_s"), ("drop", "impacts_struck_s")
DROP = Drop(impacts_added_s=(1.301,), impacts_struck_s=(0.5,))


@pytest.mark.parametrize(
    ("at", "added", "struck"),
    [(1.004, [1.301], [0.5, 1.0]),  # an impact that was found
     (1.299, None, [0.5]),  # one that was added
     (0.504, [1.301], None),  # one that was struck out comes back
     (1.493, [1.301, 1.5], [0.5]),  # the sudden sound beside the click
     (1.7, [1.301, 1.7], [0.5])],  # nothing is there
)  # fmt: skip
def test_a_click_adds_strikes_out_and_takes_back(at, added, struck):
    assert clicked(at, 0.01, NOW, DROP) == {ADDED: added, STRUCK: struck}


def test_a_click_out_of_reach_of_an_impact_adds_one_beside_it():
    assert clicked(1.02, 0.01, NOW, DROP)[ADDED] == [1.02, 1.301]


def test_the_waveform_is_loud_where_the_sound_is():
    samples = np.zeros(48_000, np.float32)
    samples[24_000], samples[36_000] = 0.5, -0.05  # 20 dB fainter: a third of 60 dB
    drawn = waveform(Sound(Path("s"), samples, 48_000, 2.0, False), 2.0, 3.0, 200)
    assert len(drawn) == 200
    assert {k: v for k, v in enumerate(drawn) if v} == {100: 1.0, 150: pytest.approx(2 / 3, abs=1e-3)}
