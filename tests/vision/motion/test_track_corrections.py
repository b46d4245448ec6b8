"""Corrections that a person makes on a film: frames struck out are used by no fit, the
thing pointed at is the one followed."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchtwin.bench.keys import Tracking
from benchtwin.measure.observe import observe
from benchtwin.rigs.drop.keys import Drop
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import Recording, read_recording

BENCH = Path(__file__).parents[3] / "samples" / "drawn-bench"


def test_struck_frames_are_left_out_and_the_places_say_so():
    recording = read_recording(BENCH / "drop-frames")
    struck = replace(recording, track=Tracking(left_out_frames=(40, 41)))
    places = observe(struck).places.set_index("frame")
    assert (
        places.left_out[[40, 41]].all()
        and not observe(recording).places.set_index("frame").left_out[[40, 41]].any()
    )
    assert (
        places.y_px.max() > places.y_px.min() + 300
    )  # from the picture's top, down to the plate


@pytest.fixture
def two_balls(tmp_path):
    """A film in which two balls bounce side by side, the right one half as high."""
    for n in range(120):
        frame = np.full((300, 240), 60, np.uint8)
        for column, e, top in ((60, 0.8, 200.0), (180, 0.6, 180.0)):
            cv2.circle(
                frame,
                (column * 16, round(16 * (280 - height(n / 60, top, e)))),
                9 * 16,
                220,
                -1,
                cv2.LINE_AA,
                4,
            )
        (tmp_path / "frames").mkdir(exist_ok=True)
        cv2.imwrite(str(tmp_path / "frames" / f"{n:06d}.png"), frame)
    files = tuple(sorted((tmp_path / "frames").iterdir()))
    known = read_recording(BENCH / "drop-frames").camera.model_copy(
        update={"fps": 60.0, "mm_per_px": None, "plumb_deg": 0.0}
    )
    return Recording(
        "two", tmp_path, "drop", "frames", files, camera=known, drop=Drop()
    )


def height(t: float, top: float, e: float, g: float = 1000.0) -> float:
    """Of a ball let go at `top` [px] that bounces with restitution e."""
    fall, speed = np.sqrt(2 * top / g), e * np.sqrt(2 * g * top)
    if t < fall:
        return top - g * t**2 / 2
    t -= fall
    while speed > 1 and t > 2 * speed / g:
        t, speed = t - 2 * speed / g, e * speed
    return max(speed * t - g * t**2 / 2, 0.0)


@pytest.mark.parametrize(("column", "e"), [(60, 0.8), (180, 0.6)])
def test_what_somebody_points_at_is_followed(two_balls, column, e):
    seen = observe(
        replace(
            two_balls,
            track=Tracking(follow_px=(0, column, 280 - (200 if column == 60 else 180))),
        )
    )
    assert seen.places.x_px.median() == pytest.approx(column, abs=1)
    first = seen.bounces.iloc[0]
    assert first.restitution == pytest.approx(
        e, abs=0.03
    )  # circles drawn to 1/16 px, gravity given in px


def test_nothing_where_somebody_points_is_said(two_balls):
    with pytest.raises(MeasurementError, match="nothing moves near"):
        observe(replace(two_balls, track=Tracking(follow_px=(0, 120, 20))))
