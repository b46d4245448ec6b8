"""A pile on the page: corrections are measured as the command line does, and what they
leave as it is is not sought again."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from synthetic.piles import PileScene, draw_pile

from benchtwin.page import measuring
from benchtwin.vision.pile.repose import PileOptions, measure_repose
from benchtwin.vision.recording import read_recording


def test_dragging_base_line_or_window_does_not_segment_the_photo_again(
    tmp_path, monkeypatch
):
    picture = draw_pile(
        PileScene(angle_deg=30, size=(900, 600), pile_height=180),
        np.random.default_rng(0),
    )
    Image.fromarray(picture).save(tmp_path / "heap.png")
    recording = read_recording(tmp_path / "heap.png")
    sought = []
    find = measuring.find_region
    monkeypatch.setattr(
        measuring, "find_region", lambda cut: sought.append(cut.shape) or find(cut)
    )
    base = measuring.measure_pile(recording, PileOptions()).base
    for options in (
        PileOptions(baseline=(base[0], base[1] - 5, base[2], base[3] - 5)),
        PileOptions(window=(0.3, 0.7)),
    ):
        ours = measuring.measure_pile(recording, options).quantities
        anew = measure_repose(picture, recording.camera, options).quantities
        assert [(q.name, q.value, q.sd) for q in ours] == [
            (q.name, q.value, q.sd) for q in anew
        ]
    assert len(sought) == 1
    inside = replace(PileOptions(), roi=(100, 50, 700, 500))
    assert measuring.measure_pile(recording, inside).quantities[
        0
    ].value == pytest.approx(30, abs=0.2)
    assert len(sought) == 2  # another part of the picture
