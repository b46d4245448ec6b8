"""A camera that is touched while it films is found and doubted; what moves in front of
a still camera is not."""

import numpy as np
import pytest

from benchtwin.vision.evidence.frames import Frame
from benchtwin.vision.motion.film_doubts import camera_moved, common_shift

HIGH, WIDE = 240, 320


class Film:
    """Frames given one by one."""

    def __init__(self, pictures):
        self.pictures = pictures

    def spread(self):
        kept = np.unique(np.linspace(0, len(self.pictures) - 1, 9).astype(int))
        return [Frame(int(k), k / 100, self.pictures[k]) for k in kept]


def film(rng, touched_at, shift=(4, 3), noise=3.0, frames=40):
    """A cluttered wall with a ball that falls past it; from frame touched_at on the
    camera looks elsewhere."""
    wall = (
        rng.uniform(60, 200, (HIGH // 8 + 4, WIDE // 8 + 4)).repeat(8, 0).repeat(8, 1)
    )
    rows, columns = np.mgrid[:HIGH, :WIDE]
    pictures = []
    for k in range(frames):
        x, y = shift if k >= touched_at else (0, 0)
        picture = wall[y : y + HIGH, x : x + WIDE].copy()
        picture[np.hypot(rows - 6 * k, columns - 150) < 25] = 240
        pictures.append(
            np.clip(picture + rng.normal(0, noise, picture.shape), 0, 255).astype(
                np.uint8
            )
        )
    return Film(pictures)


@pytest.mark.parametrize("touched_at", [1, 13, 25, 38])
def test_a_touch_is_found_where_it_happened(touched_at):
    said = camera_moved(film(np.random.default_rng(touched_at), touched_at))
    assert float(said.split(" px")[0].split()[-1]) == pytest.approx(
        5.0, abs=0.5
    )  # the ball shifts the tiles that it crosses
    first, last = (int(w) for w in said.replace(":", " ").split() if w.isdigit())
    assert first < touched_at <= last


@pytest.mark.parametrize("seed", range(10))
def test_a_falling_ball_and_noise_do_not_move_the_camera(seed):
    assert camera_moved(film(np.random.default_rng(seed), 99, noise=12.0)) == ""


def test_a_plain_wall_says_nothing():
    rng = np.random.default_rng(1)
    one, other = (np.float32(120 + rng.normal(0, 1, (HIGH, WIDE))) for _ in range(2))
    assert common_shift(one, other) is None


def test_the_shift_is_right_to_a_fraction_of_a_pixel():
    rng = np.random.default_rng(2)
    wall = np.float32(rng.uniform(60, 200, (40, 50))).repeat(8, 0).repeat(8, 1)
    assert common_shift(wall[5:245, 9:329], wall[3:243, 6:326]) == pytest.approx(
        (3.0, 2.0), abs=0.2
    )
