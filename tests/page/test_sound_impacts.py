"""What a click on the sound means for the keys, and the waveform that is drawn."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchtwin.page.sound_impacts import (
    SoundView,
    changes_of_click,
    find_with_corrections,
    waveform,
)
from benchtwin.rigs.drop.keys import Drop
from benchtwin.vision.evidence.sound import Sound
from benchtwin.vision.motion.onsets import find_onsets
from benchtwin.vision.recording import Recording

NOW = SoundView(impacts=[1.0, 1.3], added=[1.3], struck=[0.5], others=[0.502, 1.5])
ADDED, STRUCK = ("drop", "impacts_added_s"), ("drop", "impacts_struck_s")
DROP = Drop(impacts_added_s=(1.301,), impacts_struck_s=(0.5,))


@pytest.mark.parametrize(
    ("at", "added", "struck"),
    [
        (1.004, [1.301], [0.5, 1.0]),  # an impact that was found
        (1.299, None, [0.5]),  # one that was added
        (0.504, [1.301], None),  # one that was struck out comes back
        (1.493, [1.301, 1.5], [0.5]),  # the sudden sound beside the click
        (1.7, [1.301, 1.7], [0.5]),
    ],  # nothing is there
)
def test_a_click_adds_strikes_out_and_takes_back(at, added, struck):
    assert changes_of_click(at, 0.01, NOW, DROP) == {ADDED: added, STRUCK: struck}


def test_a_click_out_of_reach_of_an_impact_adds_one_beside_it():
    assert changes_of_click(1.02, 0.01, NOW, DROP)[ADDED] == [1.02, 1.301]


def test_the_waveform_is_loud_where_the_sound_is():
    samples = np.zeros(48_000, np.float32)
    samples[24_000], samples[36_000] = 0.5, -0.05  # 20 dB fainter: a third of 60 dB
    drawn = waveform(Sound(Path("s"), samples, 48_000, 2.0, False), 2.0, 3.0, 200)
    assert len(drawn) == 200
    assert {k: v for k, v in enumerate(drawn) if v} == {
        100: 1.0,
        150: pytest.approx(2 / 3, abs=1e-3),
    }


def test_impacts_can_be_added_by_clicks_where_none_were_found(tmp_path):
    """Two clicks alone, growing louder, are no bounces; set by hand they are two
    impacts."""
    rng, rate = np.random.default_rng(1), 48_000
    samples = (1e-3 * rng.standard_normal(2 * rate)).astype(np.float32)
    for at in (0.6, 1.5):
        ring = np.exp(-np.arange(600) / rate / 2e-3) * np.sin(
            2 * np.pi * 5000 * np.arange(600) / rate
        )
        samples[round(at * rate) : round(at * rate) + 600] += (0.1 * at * ring).astype(
            np.float32
        )
    sound = Sound(tmp_path / "s.wav", samples, rate, 0.0, False)
    onsets = find_onsets(sound)
    recording = Recording(
        "r",
        tmp_path,
        "drop",
        "sound",
        (tmp_path / "s.wav",),
        drop=Drop(height_mm=100.0),
    )
    nothing = find_with_corrections(sound, onsets, recording)
    assert (
        nothing.impacts == []
        and nothing.trouble
        and min(abs(t - 0.6) for t in nothing.others) < 1e-3
    )
    by_hand = find_with_corrections(
        sound,
        onsets,
        replace(recording, drop=Drop(height_mm=1100.0, impacts_added_s=(0.6, 1.5))),
    )
    assert (
        by_hand.impacts == pytest.approx([0.6, 1.5], abs=1e-3)
        and by_hand.added == by_hand.impacts
        and by_hand.quantities
    )
