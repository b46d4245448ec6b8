"""A block that the background does not tell is found by a template of it, from before
it moves: drawn strips before a wall that passes by as the plate turns."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from benchtwin.vision.evidence.frames import Frame, FrameSource
from benchtwin.vision.motion.scene import learn_scene
from benchtwin.vision.motion.template import by_template
from benchtwin.vision.motion.track import make_track
from benchtwin.vision.motion.track_seed import TrackedSeed

COUNT, FIRST, LETS_GO, FPS = 90, 68, 60, 60.0
WIDE, HIGH, FOOT = 320, 70, 56  # px of a strip, and its row on which the block stands
BLOCK = (30, 14)
FINE = 4  # drawn that much larger, so that places are not whole px
START, ACCELERATION = 230.3, 0.5  # px, px/frame²


def way(k: int) -> float:
    """Left end of the block [px]: it rests and slides."""
    return START - 0.5 * ACCELERATION * max(0, k - LETS_GO) ** 2


def strip(k: int, wall: np.ndarray, *, there: bool = True) -> np.ndarray:
    """The block on its plate before a wall of blotches that passes by."""
    picture = wall[2 * k : 2 * k + FINE * HIGH, 3 * k : 3 * k + FINE * WIDE].copy()
    picture[FINE * FOOT :] = (150, 150, 155)
    if there:
        left, top = round(FINE * way(k)), FINE * (FOOT - BLOCK[1])
        picture[top : FINE * FOOT, left : left + FINE * BLOCK[0]] = (200, 190, 160)
    return cv2.resize(picture, (WIDE, HIGH), interpolation=cv2.INTER_AREA)


class Strips(FrameSource):
    """The strips; comes_at: the frame from which on the block is there."""

    def __init__(self, comes_at: int = 0):
        super().__init__(Path("strips"), COUNT, FPS)
        rng = np.random.default_rng(5)
        size = (FINE * HIGH + 2 * COUNT, FINE * WIDE + 3 * COUNT, 3)
        blotches = cv2.GaussianBlur(rng.normal(size=size), (0, 0), 6.0)
        grey = 128 + 45 * blotches / blotches.std()
        self.wall, self.comes_at = np.clip(grey, 0, 255).astype(np.uint8), comes_at

    def iterate(self):
        yield from self._holding(self.drawn())

    def drawn(self):
        for k in range(COUNT):
            there = k >= self.comes_at
            yield Frame(k, k / FPS, strip(k, self.wall, there=there))


def seen_late(source: FrameSource) -> TrackedSeed:
    """Places off by a pixel, from when the block has begun to slide."""
    frame = np.arange(FIRST, COUNT)
    rng = np.random.default_rng(1)
    x = np.array([way(k) for k in frame]) + BLOCK[0] / 2 + rng.normal(0, 1, len(frame))
    y = np.full(len(frame), HIGH - 1 - (FOOT - BLOCK[1] / 2)) + rng.normal(0, 0.5)
    track = make_track(frame / FPS, x, y, unit="px", frame=frame, sd=1.0)
    size = 2 * float(np.sqrt(BLOCK[0] * BLOCK[1] / np.pi))
    return TrackedSeed(track, learn_scene(source), size, np.full(len(frame), 420.0))


def test_the_block_is_found_from_before_it_moves():
    source = Strips()
    found = by_template(seen_late(source), source, along=True).track
    assert found.frame[0] == 0 and not found.outlier.any()
    assert any("from frame 0 on by a template of it" in note for note in found.notes)
    apart = found.x - np.array([way(int(k)) for k in found.frame])
    assert np.std(apart[found.frame < LETS_GO]) < 0.1
    # the same point of the block while it rests and while it slides
    slides = apart[found.frame >= FIRST].mean()
    assert slides == pytest.approx(apart[found.frame < LETS_GO].mean(), abs=0.3)
    assert np.std(apart[found.frame >= FIRST]) < 3 * found.sd[0] + 0.1


def test_a_block_that_was_not_there_before_is_not_found():
    source = Strips(comes_at=FIRST)
    found = by_template(seen_late(source), source, along=True)
    assert found.track.used().frame[0] == FIRST


def test_a_track_from_the_first_frame_on_is_left_as_it_is():
    source = Strips()
    tracked = seen_late(source)
    rows = np.arange(COUNT)
    x = np.array([way(k) for k in rows])
    whole = make_track(rows / FPS, x, np.full(COUNT, 20.0), unit="px", frame=rows)
    early = TrackedSeed(whole, tracked.scene, tracked.size, np.full(COUNT, 420.0))
    assert by_template(early, source, along=True) is early


RESTS, ROLLS = 60, 4.0  # frame from which on it lies still; px in its first frame


class Pale(FrameSource):
    """A pale ball that rolls to rest before a still wall hardly darker than it is."""

    def __init__(self) -> None:
        super().__init__(Path("pale"), COUNT, FPS)
        rng = np.random.default_rng(6)
        blotches = cv2.GaussianBlur(rng.normal(size=(120, 240, 3)), (0, 0), 5.0)
        self.wall, self.rng = 185 + 4 * blotches / blotches.std(), rng

    @staticmethod
    def at(k: np.ndarray) -> np.ndarray:
        """Column of its middle: it slows down evenly."""
        left = np.maximum(0, RESTS - np.asarray(k, float))
        return 30 + ROLLS / (2 * RESTS) * (RESTS**2 - left**2)

    def iterate(self):
        yield from self._holding(self.drawn())

    def drawn(self):
        y, x = np.mgrid[:120, :240]
        rng = np.random.default_rng(7)
        for k in range(COUNT):
            inside = np.clip(9.5 - np.hypot(x - self.at(k), y - 60), 0, 1)[..., None]
            picture = self.wall + inside * (np.array([210, 205, 160]) - self.wall)
            noisy = picture + rng.normal(0, 1.5, picture.shape)
            yield Frame(k, k / FPS, np.clip(np.round(noisy), 0, 255).astype(np.uint8))


def test_a_pale_ball_before_a_pale_wall_rests_where_it_rests():
    source, frame = Pale(), np.arange(COUNT)
    rng = np.random.default_rng(2)
    # what differs from the background: a part of it only, another one where it rests
    off = np.where(frame < RESTS, rng.normal(0, 2.0, COUNT), -6.0)
    x, y = source.at(frame) + off, np.full(COUNT, 59.0)
    track = make_track(frame / FPS, x, y, unit="px", frame=frame, sd=0.1)
    seen = TrackedSeed(track, learn_scene(source), 18.0, np.full(COUNT, 250.0))
    found = by_template(seen, source).track
    apart = found.x - source.at(found.frame)
    rolls, rests = apart[found.frame < RESTS - 5], apart[found.frame >= RESTS]
    assert np.std(rolls) < 0.2
    assert np.median(rests) == pytest.approx(np.median(rolls), abs=0.3)
    with pytest.raises(AssertionError):  # the control: places as they were
        assert np.median(off[frame >= RESTS]) == pytest.approx(np.median(off), abs=0.3)
