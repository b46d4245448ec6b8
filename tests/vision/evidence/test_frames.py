"""Frames streamed from folders and videos: numbers, times, and what is skipped."""

from fractions import Fraction

import numpy as np
import pytest
from PIL import Image
from synthetic.film import write_video

from benchtwin.vision.evidence.frames import open_frames
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import Camera, Recording


def folder_of(folder, numbers, shape=(40, 60), **camera):
    files = []
    for n in numbers:
        files.append(folder / f"shot_{n:05d}.png")
        Image.fromarray(np.full(shape, n % 250, np.uint8)).save(files[-1])
    return Recording(
        "r", folder, "drop", "frames", tuple(files), camera=Camera(**camera)
    )


def video_of(folder, count=30, *, times=None, shape=(64, 96), fps=30.0, **camera):
    frames = [np.full(shape, 5 * n, np.uint8) for n in range(count)]
    for frame in frames:
        frame[:20, :20] = 250  # upper left: the frame has an orientation
    known = Recording("v", folder, "drop", "video", (), camera=Camera(**camera))
    return write_video(known, frames, fps=fps, times=times)


def test_numbers_in_file_names_are_frame_numbers_and_gaps_are_said(tmp_path):
    source = open_frames(folder_of(tmp_path, [12, 10, 15], fps=100))
    assert [(f.index, round(f.t_s, 3)) for f in source.iterate()] == [
        (10, 0.0),
        (12, 0.02),
        (15, 0.05),
    ]
    assert "3 frame numbers missing" in source.notes[0]


def test_a_damaged_frame_is_skipped_with_its_number(tmp_path):
    recording = folder_of(tmp_path, range(6), fps=100)
    whole = recording.files[3].read_bytes()
    recording.files[3].write_bytes(whole[: len(whole) // 2])
    recording.files[4].write_bytes(b"")
    Image.fromarray(np.zeros((10, 10), np.uint8)).save(recording.files[5])
    source = open_frames(recording)
    assert [f.index for f in source.iterate()] == [0, 1, 2]
    assert [note.split(":")[0] for note in source.notes] == [
        "frame 3 skipped",
        "frame 4 skipped",
        "frame 5 skipped",
    ]


def test_two_frames_of_one_number_are_refused(tmp_path):
    recording = folder_of(tmp_path, [1, 2])
    twin = tmp_path / "other_00002.png"
    twin.write_bytes(recording.files[1].read_bytes())
    with pytest.raises(MeasurementError, match="two frames numbered 2"):
        open_frames(
            Recording("r", tmp_path, "drop", "frames", (*recording.files, twin))
        )


def test_times_without_a_frame_rate_are_unknown(tmp_path):
    assert all(
        np.isnan(f.t_s) for f in open_frames(folder_of(tmp_path, range(3))).iterate()
    )


def test_a_phone_video_keeps_its_own_uneven_times(tmp_path):
    times = np.cumsum([0, *[0.033, 0.034, 0.050, 0.033] * 5])
    frames = list(open_frames(video_of(tmp_path, len(times), times=times)).iterate())
    assert np.allclose([f.t_s for f in frames], times, atol=1e-4)


def test_a_stated_frame_rate_wins_over_the_playback_rate(tmp_path):
    slow = video_of(tmp_path, 10)
    fast = Recording(
        "v", slow.path, "drop", "video", slow.files, camera=Camera(fps=5200)
    )
    assert list(open_frames(fast).iterate())[9].t_s == pytest.approx(9 / 5200)
    assert list(open_frames(slow).iterate())[9].t_s == pytest.approx(9 / 30)  # control


def test_a_video_that_stops_early_says_so(tmp_path):
    noisy = np.random.default_rng(0)
    recording = write_video(
        Recording("v", tmp_path, "drop", "video", ()),
        (noisy.integers(0, 255, (240, 320), dtype=np.uint8) for _ in range(60)),
    )
    file = recording.files[0]
    data = file.read_bytes()
    moov = data.find(b"moov") - 4
    cut = (
        data.find(b"mdat") + (moov - data.find(b"mdat")) // 2
        if moov > data.find(b"mdat")
        else len(data) // 2
    )
    file.write_bytes(
        data[:cut] + bytes(moov - cut) + data[moov:]
    )  # half of the pictures zeroed, the index kept
    source = open_frames(recording)
    got = len(list(source.iterate()))
    assert 0 < got < 60
    assert any("stops early" in note or "damaged" in note for note in source.notes)


@pytest.mark.parametrize(
    ("content", "says"), [(b"", "empty"), (b"not a video at all" * 100, "not a video")]
)
def test_no_video_is_told_by_name(tmp_path, content, says):
    file = tmp_path / "film.mp4"
    file.write_bytes(content)
    with pytest.raises(MeasurementError, match=says) as caught:
        open_frames(Recording("v", tmp_path, "drop", "video", (file,)))
    assert "film.mp4" in str(caught.value)


def test_a_rotated_phone_video_stands_upright(tmp_path):
    """The display matrix of an upright phone: turn the picture a quarter clockwise."""
    recording = video_of(tmp_path, 5)
    file = recording.files[0]
    data = bytearray(file.read_bytes())
    matrix = data.find(b"tkhd") + 4 + 4 + 20 + 16
    one, minus = (0x10000).to_bytes(4, "big"), (0xFFFF0000).to_bytes(4, "big")
    assert data[matrix : matrix + 4] == one  # found the matrix
    nought = bytes(4)
    data[matrix : matrix + 20] = nought + one + nought + minus + nought
    file.write_bytes(bytes(data))
    frame = next(iter(open_frames(recording).iterate()))
    assert frame.pixels.shape[:2] == (96, 64)
    assert (
        frame.pixels[:15, -15:].mean() > 200
    )  # upper left has gone to the upper right
    assert frame.pixels[:15, :15].mean() < 100


def test_samples_are_spread_over_the_whole(tmp_path):
    picked = open_frames(video_of(tmp_path, 50)).picked(10)
    assert 8 <= len(picked) <= 20 and picked[0].index == 0 and picked[-1].index >= 40


def test_a_film_that_was_read_is_not_decoded_again(tmp_path):
    """The frames kept on the way through it are those that are picked else."""
    source = open_frames(video_of(tmp_path, 50))
    before = source.spread()
    for _ in source.iterate():
        pass
    source.path.unlink()
    after = source.spread()
    assert [f.index for f in after] == [f.index for f in before]
    assert all(
        np.array_equal(a.pixels, b.pixels) for a, b in zip(after, before, strict=True)
    )


def test_fractions_of_a_frame_rate(tmp_path):
    source = open_frames(video_of(tmp_path, 12, fps=float(Fraction(30000, 1001))))
    assert source.fps == pytest.approx(29.97, abs=0.01)
