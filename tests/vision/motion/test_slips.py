"""A tracker that slips to another thing and back: those rows are told, and a bouncing,
rolling or resting thing has none."""

import numpy as np
import pandas as pd
import pytest

from benchtwin.vision.motion.outliers import slips
from benchtwin.vision.motion.track import track_from_table
from benchtwin.vision.recording import Camera

G = 9810.0


def bouncing(
    fps: float, e: float, height: float = 500.0
) -> tuple[np.ndarray, np.ndarray]:
    """Frames and heights [mm] of a ball from its rest in a hand to its rest on the
    plate, in closed form."""
    fall = np.sqrt(2 * height / G)
    t = np.arange(0, 0.5 + fall * (1 + 2 * e / (1 - e)) + 0.3, 1 / fps) - 0.5
    y, at, speed = np.where(t < 0, height, height - G * t**2 / 2), fall, G * fall
    while speed > 20:
        speed *= e
        s = t - at
        y = np.where(s >= 0, np.maximum(speed * s - G * s**2 / 2, 0), y)
        at += 2 * speed / G
    return np.arange(len(t)), np.where(t > at, 0, y)


@pytest.mark.parametrize("fps", [15, 24, 30, 60, 240, 1000])
@pytest.mark.parametrize("e", [0.2, 0.5, 0.8, 0.9])
@pytest.mark.parametrize("noise", [0.0, 0.3, 3.0])
def test_a_bouncing_ball_does_not_slip(fps, e, noise):
    frame, y = bouncing(fps, e)
    rng = np.random.default_rng(1)
    x = 0.05 * frame * 1000 / fps + rng.normal(0, noise, y.size)
    assert not slips(frame, x, y + rng.normal(0, noise, y.size)).any()


def test_noise_and_a_run_out_do_not_slip():
    rng, frame = np.random.default_rng(2), np.arange(400)
    for scatter in (0.01, 1.0):
        assert not slips(
            frame, rng.normal(0, scatter, 400), rng.normal(0, scatter, 400)
        ).any()
    assert not slips(
        frame,
        200 * (1 - np.exp(-frame / 80)) + rng.normal(0, 0.2, 400),
        rng.normal(0, 0.2, 400),
    ).any()


@pytest.mark.parametrize("fps", [24, 60, 240])
def test_rows_on_another_thing_are_told(fps):
    frame, y = bouncing(fps, 0.8)
    x, rng = np.full(y.size, 90.0), np.random.default_rng(3)
    gone = np.zeros(y.size, dtype=bool)
    for first in rng.choice(np.arange(20, y.size - 20), 4, replace=False):
        gone[first : first + rng.integers(1, 6)] = True
    x, y = np.where(gone, 450 + rng.normal(0, 0.5, y.size), x), np.where(gone, 700.0, y)
    assert (slips(frame, x, y) == gone).all()


def test_what_leaps_and_stays_away_is_kept():
    frame, y = bouncing(60, 0.8)
    y = np.where(frame > 60, y + 800, y)
    assert not slips(frame, np.zeros(y.size), y).any()


def test_a_track_says_that_its_tracker_slipped():
    frame, y = bouncing(60, 0.8)
    y[40:43] += 900
    rows = pd.DataFrame({"frame": frame, "x_px": np.zeros(y.size), "y_px": y})
    track = track_from_table(rows, Camera())
    assert np.flatnonzero(track.outlier).tolist() == [40, 41, 42]
    assert "3 rows are leaps away and back" in track.notes[0]
