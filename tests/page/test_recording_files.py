"""Recordings split, joined, renamed, moved, removed and put back: every picture stays,
also when it is cut off anywhere."""

import hashlib
import os
import shutil
from collections import Counter
from contextlib import suppress
from pathlib import Path

import pytest
from synthetic.series import film_frames

from benchtwin.page.folder import Folder, Refused
from benchtwin.page.recording_files import (
    join_as_film,
    move,
    own_folder,
    put_back,
    remove,
    removed,
    rename,
    series,
    split_into_photos,
)
from benchtwin.vision.find_recordings import find_recordings
from benchtwin.vision.recording import Recording, read_recording

NAMES = [f"IMG_{n}.jpg" for n in range(4300, 4306)]


@pytest.fixture
def bench(tmp_path):
    """A bench with one recording of six frames, its keys stated."""
    (tmp_path / "bench" / "IMG" / "frames").mkdir(parents=True)
    for name, picture in zip(NAMES, film_frames(6), strict=True):
        picture.save(tmp_path / "bench" / "IMG" / "frames" / name)
    (tmp_path / "bench" / "IMG" / "recording.toml").write_text(
        'id = "day 1"\n[camera]\nmm_per_px = 0.2 # with the ruler\n[pile]\n'
        "baseline_px = [0, 1, 2, 3]\n"
    )
    return tmp_path / "bench"


def contents(bench):
    """Every picture in the bench by its content, hidden or not."""
    return {hashlib.sha256(p.read_bytes()).hexdigest() for p in bench.rglob("*.jpg")}


def recordings(bench):
    return [r for r in find_recordings(bench) if isinstance(r, Recording)]


def test_a_film_is_split_into_piles_and_joined_again(bench):
    folder, before = Folder(bench), contents(bench)
    frames = bench / "IMG" / "frames"
    order = [p.read_bytes() for p in sorted(frames.iterdir())]
    made = split_into_photos(read_recording(bench / "IMG"), folder)
    assert [p.name for p in made] == [n.removesuffix(".jpg") for n in NAMES]
    found = recordings(bench)
    assert [(r.rig, r.evidence, r.id) for r in found] == [
        ("pile", "photos", p.name) for p in made
    ]
    assert {r.camera.mm_per_px for r in found} == {0.2}
    assert found[0].pile.baseline_px is None  # it was of another picture
    assert "with the ruler" in (made[0] / "recording.toml").read_text()

    together = series(found[2], found)
    assert [r.files[0].name for r in together] == NAMES
    film = read_recording(join_as_film(together, folder))
    assert (film.id, film.rig, film.evidence) == ("IMG", None, "frames")
    assert [p.read_bytes() for p in film.files] == order
    assert recordings(bench) == [film] and contents(bench) == before


def test_photos_of_one_recording_are_joined(bench):
    (bench / "IMG" / "frames").rename(bench / "x")
    (bench / "x").rename(bench / "heaps")
    (bench / "IMG" / "recording.toml").rename(bench / "heaps" / "recording.toml")
    photos = read_recording(bench / "heaps")
    assert photos.evidence == "photos" and series(photos, []) == [photos]
    film = read_recording(join_as_film([photos], Folder(bench)))
    assert film.evidence == "frames" and film.path.name == "heaps-film"


def test_what_is_removed_is_put_back(bench):
    folder, before = Folder(bench), contents(bench)
    remove(bench / "IMG", folder)
    assert not recordings(bench)
    (gone,) = removed(bench)
    (bench / "IMG").mkdir()  # the name is taken meanwhile
    back = put_back(gone, bench)
    assert back.name == "IMG-02" and contents(bench) == before
    assert read_recording(back).id == "day 1" and not removed(bench)


def test_a_name_that_is_taken_is_refused_and_nothing_is_replaced(bench, tmp_path):
    folder = Folder(tmp_path)
    (tmp_path / "other" / "IMG").mkdir(parents=True)
    (bench / "b").mkdir()
    for act in (
        lambda: rename(bench / "IMG", "b", folder),
        lambda: rename(bench / "IMG", " ", folder),
        lambda: rename(bench / "IMG", "results", folder),
        lambda: move(bench / "IMG", tmp_path / "other", folder),
        lambda: remove(tmp_path, folder),
    ):
        with pytest.raises(Refused):
            act()
    assert read_recording(bench / "IMG").id == "day 1"


def test_renamed_and_moved(bench, tmp_path):
    folder = Folder(tmp_path)
    (tmp_path / "other").mkdir()
    named = rename(bench / "IMG", "../heaps of 2 March", folder)
    assert named == bench / "heaps of 2 March"
    assert read_recording(named).id == "heaps of 2 March"  # the old id would hide it
    moved = move(named, tmp_path / "other", folder)
    assert read_recording(moved).camera.mm_per_px == 0.2


def test_a_loose_photo_gets_a_folder_of_its_own(bench):
    photo = bench / "heap.jpg"
    film_frames(1)[0].save(photo)
    made = own_folder(photo, Folder(bench))
    found = read_recording(made)
    assert (made.name, found.rig, found.files[0].name) == ("heap", "pile", "heap.jpg")
    assert not photo.exists()


def test_a_disk_without_hard_links_copies(bench, monkeypatch):
    def no_links(*_, **__):
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(os, "link", no_links)
    before = contents(bench)
    made = split_into_photos(read_recording(bench / "IMG"), Folder(bench))
    assert len(made) == 6 and contents(bench) == before


class Killed(BaseException):
    """The process ends here."""


def cut_off(monkeypatch, after):
    """Let the process end before its `after`-th change to the disk."""
    left = [after]

    def guarded(work):
        def step(*args, **keys):
            left[0] -= 1
            if left[0] < 0:
                raise Killed
            return work(*args, **keys)

        return step

    for name in ("link", "unlink", "mkdir", "rename", "rmdir"):
        monkeypatch.setattr(os, name, guarded(getattr(os, name)))
    monkeypatch.setattr("shutil.rmtree", lambda *_, **__: None)  # nobody tidies up


def tidied(bench: Path) -> None:
    """What was half-made is hidden, and removed by whoever writes there next."""
    for part in bench.glob(".*.part"):
        shutil.rmtree(part)


@pytest.mark.parametrize("after", range(0, 40))
def test_what_is_cut_off_is_completed_by_doing_it_again(bench, monkeypatch, after):
    """Splitting six pictures makes some 40 changes to the disk; any may be the last."""
    folder, before = Folder(bench), contents(bench)
    with monkeypatch.context() as patch:
        cut_off(patch, after)
        with suppress(Killed):
            split_into_photos(read_recording(bench / "IMG"), folder)
    tidied(bench)
    assert contents(bench) == before
    if (bench / "IMG").exists():
        split_into_photos(read_recording(bench / "IMG"), folder)
    found = recordings(bench)
    assert Counter(f.name for r in found for f in r.files) == Counter(NAMES)
    assert contents(bench) == before and len(removed(bench)) == 1
    film = join_as_film(series(found[0], found), folder)
    assert recordings(bench) == [read_recording(film)]


@pytest.mark.parametrize("after", range(0, 25))
def test_joining_that_is_cut_off_is_completed_by_doing_it_again(
    bench, monkeypatch, after
):
    folder, before = Folder(bench), contents(bench)
    split_into_photos(read_recording(bench / "IMG"), folder)
    with monkeypatch.context() as patch:
        cut_off(patch, after)
        with suppress(Killed):
            found = recordings(bench)
            join_as_film(series(found[0], found), folder)
    tidied(bench)
    assert contents(bench) == before
    found = recordings(bench)
    if left := [r for r in found if r.evidence == "photos"]:
        if len(left) == 1:  # a film of one picture is none: it is removed by hand
            remove(left[0].path, folder)
        else:
            join_as_film(series(left[0], left), folder)
    assert contents(bench) == before
    films = [r for r in recordings(bench) if r.evidence == "frames"]
    assert {f.name for r in films for f in r.files} == {*NAMES}
