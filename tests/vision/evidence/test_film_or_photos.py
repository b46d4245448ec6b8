"""Frames and photos told apart by what the pictures and their files show, and asked
where both fit."""

from datetime import datetime, timedelta

import numpy as np
import pytest
from PIL import Image
from synthetic.series import film_frames, heap_photos

from benchtwin.measure.batch import find_all
from benchtwin.measure.observe import observe
from benchtwin.vision.evidence.film_or_photos import (
    EXPOSURE,
    FILM,
    LEAST_FRAMES,
    ORIGINAL,
    PHOTOS,
    UNCLEAR,
    film_or_photos,
    numbered_runs,
)
from benchtwin.vision.find_recordings import find_recordings
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import Recording, read_recording

COUNT = 16


def saved(folder, pictures, name, exif=None):
    """The pictures as files; name: with a place for the number; exif: tags of each."""
    folder.mkdir(parents=True, exist_ok=True)
    for n, picture in enumerate(pictures):
        tags = Image.Exif()
        if exif:
            tags[0x8769] = exif(n)
        picture.save(folder / name.format(n), exif=tags)
    return {p.name: p for p in sorted(folder.iterdir())}


def taken(every_s, exposure=lambda n: 0.01):
    """EXIF tags of pictures taken at these intervals."""

    def tags(n):
        moment = datetime(2026, 3, 2, 10) + timedelta(seconds=every_s(n))
        return {
            ORIGINAL: moment.strftime("%Y:%m:%d %H:%M:%S"),
            0x9291: f"{moment.microsecond // 1000:03d}",
            EXPOSURE: exposure(n),
        }

    return tags


def irregular(n):
    return 20 * n + 7 * (n % 3)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", ["IMG_{:04d}.jpg", "heap {:d}.jpg", "DSC{:05d}.JPG"])
def test_photos_of_heaps(tmp_path, name, seed):
    files = saved(tmp_path, heap_photos(COUNT, seed), name)
    assert film_or_photos(files).kind == PHOTOS


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    "name", ["drop_{:04d}.png", "{:06d}.tif", "frame{:d}.jpg", "IMG_{:04d}.jpg"]
)
def test_frames_of_a_still_camera(tmp_path, name, seed):
    files = saved(tmp_path, film_frames(COUNT, seed), name)
    assert film_or_photos(files).kind == FILM


def test_times_between_exposures_speak_for_photos(tmp_path):
    """The same heap photographed again and again from a stand: only the times tell."""
    pictures = film_frames(COUNT)
    photos = saved(tmp_path / "a", pictures, "IMG_{:04d}.jpg", taken(irregular))
    burst = saved(tmp_path / "b", pictures, "IMG_{:04d}.jpg", taken(lambda n: n / 20))
    assert film_or_photos(photos).kind != FILM
    assert film_or_photos(burst).kind == FILM


def test_pictures_of_several_sizes_are_no_film(tmp_path):
    pictures = film_frames(COUNT)
    pictures[3] = pictures[3].resize((200, 300))
    assert film_or_photos(saved(tmp_path, pictures, "a{:03d}.png")).kind == PHOTOS


def test_both_fit_where_signs_disagree_or_nothing_can_be_read(tmp_path):
    heaps = saved(tmp_path / "a", heap_photos(COUNT), "a_{:04d}.png")
    judged = film_or_photos(heaps)
    assert judged.kind == UNCLEAR and "as between any two" in judged.why
    broken = saved(tmp_path / "b", film_frames(COUNT), "a_{:04d}.png")
    for path in broken.values():
        path.write_bytes(b"no picture")
    assert film_or_photos(broken).kind == UNCLEAR


def test_a_few_or_differently_named_pictures_are_photos(tmp_path):
    few = saved(tmp_path / "a", film_frames(LEAST_FRAMES - 1), "a_{:04d}.png")
    assert film_or_photos(few).kind == PHOTOS
    assert numbered_runs(["a1.png", "b1.png", "a3.png", "a2.png"], least=3) == {
        "a": ["a1.png", "a2.png", "a3.png"]
    }


def test_a_folder_is_judged_as_an_upload_is(tmp_path):
    saved(tmp_path / "film", film_frames(COUNT), "drop_{:04d}.png")
    saved(tmp_path / "heaps", heap_photos(COUNT), "IMG_{:04d}.jpg")
    saved(tmp_path / "either", heap_photos(COUNT), "a_{:04d}.png")
    (tmp_path / "bench.toml").write_text("")
    found = find_recordings(tmp_path)
    assert all(isinstance(r, Recording) for r in found)
    assert [(r.id, r.rig, r.evidence) for r in found if r.path.is_dir()] == [
        ("either", None, "photos"),
        ("film", None, "frames"),
    ]
    assert len([r for r in found if r.rig == "pile"]) == COUNT
    assert len(find_all([tmp_path / "either"])) == 1  # not one failure a picture
    with pytest.raises(MeasurementError, match="photos of piles, or one film"):
        observe(found[0])


def test_what_is_stated_is_not_judged(tmp_path):
    saved(tmp_path / "a", heap_photos(COUNT), "a_{:04d}.png")
    for rig, evidence in (("pile", "photos"), ("drop", "frames"), ("drum", "frames")):
        (tmp_path / "a" / "recording.toml").write_text(f'rig = "{rig}"\n')
        found = read_recording(tmp_path / "a")
        assert (found.rig, found.evidence) == (rig, evidence)


def test_frames_among_other_files_are_named_with_what_to_do(tmp_path):
    saved(tmp_path, film_frames(COUNT), "drop_{:04d}.png")
    Image.fromarray(np.zeros((40, 40), np.uint8)).save(tmp_path / "heap.png")
    found = find_recordings(tmp_path)
    (error,) = [e for e in found if isinstance(e, MeasurementError)]
    assert "drop_0000.png to drop_0015.png, 16 pictures, are one film" in str(error)
    assert [r.id for r in found if isinstance(r, Recording)] == ["heap"]
