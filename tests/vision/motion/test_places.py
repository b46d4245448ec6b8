"""Places set by hand stand instead of what the tracker finds, or are the track."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchtwin.measure.observe import observe
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import read_recording

SAMPLES = Path(__file__).parents[3] / "samples" / "drawn-bench"


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """A drawn film of a drop with what the tracker finds in it."""
    folder = tmp_path_factory.mktemp("bench") / "film"
    shutil.copytree(SAMPLES / "drop-frames", folder)
    shutil.copy(SAMPLES / "bench.toml", folder.parent)
    recording = read_recording(folder)
    return recording, observe(recording)


def by_hand(recording, places, only=None):
    update = {"places_px": tuple(places), "only_places": only}
    return replace(recording, track=recording.track.model_copy(update=update))


def value(found, name):
    return next(q for q in found.quantities if q.name == name)


def test_a_film_clicked_through_by_hand_gives_the_tracker_s_restitution(film):
    """Every second frame, clicked to a pixel: rounding errs by 0.29 px a click, and
    both values lie within their own 95 % intervals of each other."""
    recording, tracked = film
    clicked = [
        (int(r.frame), round(r.x_px), round(r.y_px))
        for r in tracked.places.iloc[::2].itertuples()
    ]
    found = observe(by_hand(recording, clicked, only=True))
    hand, machine = (value(o, "restitution_normal") for o in (found, tracked))
    assert len(found.track) == len(clicked)
    assert abs(hand.value - machine.value) < 2 * np.hypot(hand.sd, machine.sd)
    assert 0 < hand.sd < 0.05


def test_a_place_replaces_what_was_found_in_its_frame_and_leaves_the_others(film):
    recording, tracked = film
    row = tracked.places.iloc[40]
    frame = int(row.frame)
    wrong = by_hand(recording, [(frame, row.x_px + 30, row.y_px)])
    places = observe(wrong).places.set_index("frame")
    before = tracked.places.set_index("frame")
    assert places.loc[frame, "x_px"] == pytest.approx(row.x_px + 30)
    others = before.index != frame
    assert np.allclose(places[others].x_px, before[others].x_px)


def test_a_place_in_a_frame_that_was_lost_is_added(film, tmp_path):
    """A frame without the seed in it: its place comes from the hand alone."""
    recording, tracked = film
    folder = tmp_path / "film"
    shutil.copytree(recording.path, folder)
    row = tracked.places.iloc[40]
    frames = sorted((folder / "frames").iterdir())
    shutil.copy(frames[0], frames[int(row.frame)])  # the seed is elsewhere there
    lost = observe(replace(read_recording(folder), camera=recording.camera))
    assert int(row.frame) not in set(lost.places.frame[~lost.places.left_out])
    again = by_hand(read_recording(folder), [(int(row.frame), row.x_px, row.y_px)])
    places = observe(replace(again, camera=recording.camera)).places
    assert places.set_index("frame").loc[int(row.frame), "y_px"] == row.y_px


def test_too_few_places_and_a_frame_that_is_not_there_are_said(film):
    recording, _ = film
    with pytest.raises(MeasurementError, match="2 places set by hand"):
        observe(by_hand(recording, [(1, 5, 5), (2, 6, 6)], only=True))
    with pytest.raises(MeasurementError, match="has no frame 99999"):
        observe(by_hand(recording, [(99999, 5, 5)]))
