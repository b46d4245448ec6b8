"""A film of a heap: its last frame is measured, whatever bars are laid round it, and
gate and flow by all of them."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from synthetic.piles import PileScene, draw_pile

from benchtwin.rigs.pile.heap_outline import collapsed
from benchtwin.rigs.pile.observe import MOVING, observe_pile
from benchtwin.rigs.pile.read import read_piles
from benchtwin.twin.parameters import Parameters
from benchtwin.twin.paths import like
from benchtwin.twin.run import run, simulate
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


CHANNEL = {
    "pile": {
        "box_mm": [60.0, 20.0, 80.0],
        "channel_mm": [250.0, 20.0],
        "fill_height_mm": 60.0,
        "gate_speed_mm_s": 200.0,
    },
    "seed": dict.fromkeys(("length_mm", "width_mm", "thickness_mm"), 6.0),
    "camera": {
        "fps": 60.0,
        "mm_per_px": 0.4,
        "width_px": 680,
        "height_px": 240,
        "target_mm": [125.0, 0.0, 35.0],
    },
}


def test_the_film_of_a_simulated_collapse_tells_gate_and_flow(tmp_path):
    """The gate's time within 2 sd of 60 mm at 200 mm/s, in the film and by the outlines
    that are compared with films; the flow alike in both within 2 sd of a film's."""
    parameters, rig = Parameters(), like("pile", CHANNEL)
    filmed = replace(rig, evidence="video")
    rng = [np.random.default_rng(3) for _ in range(2)]
    simulate("pile", parameters, rng=rng[0], out=tmp_path / "film", like=filmed)
    (seen,) = read_piles(tmp_path)
    motion, _ = run(filmed, parameters, rng=rng[1])
    outlines = collapsed(motion, 0.06, 0.06)
    for found in (seen.collapse, outlines):
        assert abs(found.gate_s - 0.3) < 2 * found.gate_sd_s < 0.2
        assert not found.late
    apart = seen.collapse.flow_s - outlines.flow_s
    assert abs(apart) < 2 * np.hypot(seen.collapse.flow_sd_s, outlines.flow_sd_s)
    assert seen.clocked and (tmp_path / "film" / "frames").is_dir()
    frames = sorted((tmp_path / "film" / "frames").iterdir())
    for frame in frames[len(frames) // 4 :]:
        frame.unlink()
    (cut,) = find_recordings(tmp_path)
    times = [q for q in observe_pile(cut).quantities if q.unit == "s"]
    assert times and all(MOVING in q.reason for q in times)
