"""A film of a heap: its last frame is measured, whatever bars are laid round it."""

import cv2
import numpy as np
import pytest
from synthetic.piles import PileScene, draw_pile

from benchtwin.rigs.pile.observe import observe_pile
from benchtwin.vision.find_recordings import find_recordings
from benchtwin.vision.measurement import DOUBTFUL, GOOD, MeasurementError

ANGLE_DEG, BAR = 28.0, 80


def recording(folder, frames):
    """Frames (h, w) written as a film with black bars above and below."""
    folder.mkdir()
    (folder / "recording.toml").write_text('rig = "pile"\n')
    size = (frames[0].shape[1], frames[0].shape[0] + 2 * BAR)
    writer = cv2.VideoWriter(
        str(folder / "video.mp4"), cv2.VideoWriter_fourcc(*"mp4v"), 30.0, size
    )
    for frame in frames:
        padded = np.pad(frame, ((BAR, BAR), (0, 0)))
        writer.write(cv2.cvtColor(padded, cv2.COLOR_GRAY2BGR))
    writer.release()
    return find_recordings(folder)[0]


def heap(angle_deg: float) -> np.ndarray:
    scene = PileScene(size=(800, 480), pile_height=150, angle_deg=angle_deg)
    return draw_pile(scene, np.random.default_rng(0))


@pytest.mark.parametrize("rests", [True, False])
def test_the_last_frame_is_measured_and_must_be_at_rest(tmp_path, rests):
    """Black frames after it do not count; what still falls is doubted."""
    falling = [heap(angle) for angle in (45.0, 36.0)]
    frames = [
        *falling,
        *[heap(ANGLE_DEG)] * (1 + rests),
        np.zeros((480, 800), np.uint8),
    ]
    seen = observe_pile(recording(tmp_path / "film", frames))
    q = seen.quantities[0]
    assert q.value == pytest.approx(ANGLE_DEG, abs=0.3)
    assert q.quality == (GOOD if rests else DOUBTFUL)
    assert rests or "at rest" in q.reason
    assert "measured on the film's last frame" in seen.notes


def test_a_black_film_is_refused(tmp_path):
    film = recording(tmp_path / "film", [np.zeros((480, 800), np.uint8)] * 3)
    with pytest.raises(MeasurementError, match="every frame is black"):
        observe_pile(film)
