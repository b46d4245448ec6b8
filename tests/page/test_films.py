"""Frames by their own numbers, in any order, the first at once."""

import io
import time

import numpy as np
import pytest
from PIL import Image
from synthetic.film import write_video

from benchtwin.page.pictures import Film, thumbnail
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import Recording

COUNT = 100
BAR = 6  # px of a frame's mark a bit


def marked(number, size=(160, 96)):
    """A frame that says its number as bars, which survive any compression."""
    pixels = np.full((size[1], size[0]), 30, np.uint8)
    for bit in range(10):
        if number >> bit & 1:
            pixels[20:60, 10 + 14 * bit : 10 + 14 * bit + BAR] = 230
    return pixels


def read_mark(jpeg):
    picture = np.asarray(Image.open(io.BytesIO(jpeg)).convert("L"))
    columns = [picture[25:55, 11 + 14 * bit : 9 + 14 * bit + BAR] for bit in range(10)]
    return sum(1 << bit for bit, c in enumerate(columns) if c.mean() > 128)


def folder_film(folder, numbers):
    files = []
    for n in numbers:
        files.append(folder / f"{n:04d}.png")
        Image.fromarray(marked(n)).save(files[-1])
    return Recording("r", folder, "drop", "frames", tuple(files))


@pytest.fixture(scope="module")
def video(tmp_path_factory):
    known = Recording("v", tmp_path_factory.mktemp("video"), "drop", "video", ())
    return write_video(known, [marked(n) for n in range(COUNT)])


@pytest.mark.parametrize("start", [0, 1, 700])
def test_frames_have_their_own_numbers_from_the_first_to_the_last(tmp_path, start):
    film = Film(folder_film(tmp_path, range(start, start + 20)))
    assert film.numbers == [*range(start, start + 20)] and film.size == (160, 96)
    for n in (start, start + 19, start + 7):
        assert read_mark(film.frame(n)) == n


def test_a_lost_frame_shows_the_one_before_and_no_number_fails(tmp_path):
    film = Film(folder_film(tmp_path, [10, 11, 15]))
    shown = {10: 10, 13: 11, 15: 15, 99: 15, 0: 10, -5: 10}
    assert {n: read_mark(film.frame(n)) for n in shown} == shown


@pytest.mark.parametrize("order", ["on", "back", "jumps"])
def test_a_video_in_any_order(video, order):
    film = Film(video)
    wanted = {
        "on": range(COUNT),
        "back": range(COUNT - 1, -1, -1),
        "jumps": np.random.default_rng(0).integers(0, COUNT, 40),
    }[order]
    assert [read_mark(film.frame(int(n))) for n in wanted] == [*map(int, wanted)]
    assert read_mark(film.frame(10_000)) == COUNT - 1


def test_a_video_that_ends_before_its_header_says(video, tmp_path):
    """The index promises more than the file holds: the last frame that is there."""
    data = video.files[0].read_bytes()
    file = tmp_path / "film.mp4"
    file.write_bytes(data)
    recording = Recording("v", tmp_path, "drop", "video", (file,))
    film = Film(recording)
    film.numbers = [*range(2 * COUNT)]
    assert read_mark(film.frame(2 * COUNT - 1)) == COUNT - 1
    assert read_mark(film.frame(3)) == 3


def test_a_damaged_frame_is_said_and_the_others_are_shown(tmp_path):
    recording = folder_film(tmp_path, range(5))
    recording.files[0].write_bytes(b"")
    recording.files[2].write_bytes(recording.files[2].read_bytes()[:60])
    film = Film(recording)
    assert film.size == (160, 96) and read_mark(film.frame(3)) == 3
    with pytest.raises(MeasurementError, match=r"0002.png"):
        film.frame(2)


@pytest.mark.parametrize("content", [b"", b"no film at all" * 100])
def test_what_is_no_film_is_said(tmp_path, content):
    file = tmp_path / "film.mp4"
    file.write_bytes(content)
    with pytest.raises(MeasurementError, match=r"film.mp4"):
        Film(Recording("v", tmp_path, "drop", "video", (file,)))
    with pytest.raises(MeasurementError, match=r"film.mp4"):
        thumbnail(Recording("v", tmp_path, "drop", "video", (file,)))


def test_the_first_frame_does_not_wait_for_the_others(tmp_path):
    """The first frame takes no longer in a film of fifty times as many frames."""
    rng = np.random.default_rng(0)
    noise = rng.integers(0, 255, (480, 640), dtype=np.uint8)

    def first_frame_s(count):
        known = Recording("v", tmp_path / f"{count}", "drop", "video", ())
        frames = (np.roll(noise, 7 * n, axis=1) for n in range(count))
        film = write_video(known, frames)
        begun = time.perf_counter()
        Film(film).frame(0)
        return time.perf_counter() - begun

    short = min(first_frame_s(12) for _ in range(3))
    assert first_frame_s(600) < 5 * short + 0.3  # other work on the machine
