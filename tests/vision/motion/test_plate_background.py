"""A block before a wall full of things, which turn in pictures that are rotated with
its plate: the wall is learnt where it stands still, and subtracted."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from benchtwin.bench.keys import Camera
from benchtwin.rigs.slide.keys import Slide
from benchtwin.vision.evidence.frames import Frame, FrameSource
from benchtwin.vision.motion.edge_line import track_edge
from benchtwin.vision.motion.plate_frames import background_of
from benchtwin.vision.motion.tilting_plate import track_slide
from benchtwin.vision.recording import Recording

COUNT, LETS_GO, FPS = 90, 68, 60.0
WIDE, HIGH, FINE = 480, 400, 4  # drawn FINE times larger, so that places are not whole
PIVOT = np.array([40.0, 330.0])
LONG, THICK, BLOCK = 320.0, 9.0, (34.0, 22.0)
FIRST_DEG, RATE_DEG, START, ACCELERATION = 8.0, 0.22, 230.0, 0.6  # a frame; px


def tilt(k: int) -> float:
    return np.radians(FIRST_DEG + RATE_DEG * k)


def way(k: int) -> float:
    """Middle of the block along the plate [px]: it rests and slides."""
    return START - 0.5 * ACCELERATION * max(0, k - LETS_GO) ** 2


class Busy(FrameSource):
    """The film."""

    def __init__(self) -> None:
        super().__init__(Path("busy"), COUNT, FPS)
        rng = np.random.default_rng(3)
        wall = np.full((FINE * HIGH, FINE * WIDE, 3), 150, np.uint8)
        for _ in range(60):
            middle = rng.uniform(0, 1, 2) * [FINE * WIDE, FINE * HIGH]
            size = rng.uniform(60, 400, 2)
            box = cv2.boxPoints((middle, size, float(rng.uniform(0, 180))))
            colour = [int(v) for v in rng.integers(20, 250, 3)]
            cv2.fillConvexPoly(wall, box.astype(np.int32), colour)
        self.wall = cv2.GaussianBlur(wall, (0, 0), 4.0)

    def iterate(self):
        yield from self._holding(self.drawn())

    def drawn(self):
        rng = np.random.default_rng(4)
        for k in range(COUNT):
            picture, angle = self.wall.copy(), tilt(k)
            along = np.array([np.cos(angle), -np.sin(angle)])
            up = np.array([-np.sin(angle), -np.cos(angle)])

            def part(low, high, left, right, along=along, up=up):
                corners = [(left, low), (right, low), (right, high), (left, high)]
                places = [PIVOT + a * along + b * up for a, b in corners]
                return (FINE * np.array(places)).round().astype(np.int32)

            cv2.fillConvexPoly(picture, part(-THICK, 0, 0, LONG), (205, 205, 205))
            half = BLOCK[0] / 2
            block = part(0, BLOCK[1], way(k) - half, way(k) + half)
            cv2.fillConvexPoly(picture, block, (190, 225, 235))
            small = cv2.resize(picture, (WIDE, HIGH), interpolation=cv2.INTER_AREA)
            noisy = small + rng.normal(0, 2.0, small.shape)
            yield Frame(k, k / FPS, np.clip(np.round(noisy), 0, 255).astype(np.uint8))


@pytest.fixture(scope="module")
def film() -> Busy:
    return Busy()


def test_the_wall_is_learnt_wherever_plate_and_block_leave_it(film):
    lines = track_edge(film)[0]
    assert lines is not None
    size = (WIDE, HIGH)
    true = cv2.resize(film.wall, size, interpolation=cv2.INTER_AREA).astype(float)
    off = np.abs(background_of(film, lines, 1) - true).max(axis=2)
    assert np.mean(off > 12) < 0.02  # but near the hinge, where the plate hardly moves
    assert not (off[:, 300:] > 12).any()


def test_the_block_is_followed_from_before_it_slides(film):
    recording = Recording(
        "s",
        Path("s"),
        "slide",
        "video",
        (),
        camera=Camera(plumb_deg=0.0),
        slide=Slide(),
    )
    tracked, _ = track_slide(film, recording)
    used = tracked.track.used()
    assert used.frame[0] < LETS_GO - 20
    apart = used.x - np.array([way(int(k)) for k in used.frame])
    # what lies behind the block bites at its outline where both are alike
    assert np.std(apart) < 1.0
    assert np.allclose(
        used.tilt_deg, np.degrees([tilt(int(k)) for k in used.frame]), atol=0.15
    )
    assert any("subtracted" in note for note in tracked.track.notes)
