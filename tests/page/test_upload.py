"""Dropped files become recordings: sorted by what they are, nothing replaced, nothing
half."""

import pytest
from benchtwin.page.folder import Folder, Refused
from benchtwin.page.upload import KINDS, LEAST_FRAMES, ReceivedFile, check, place_files
from benchtwin.vision.find_recordings import find_recordings
from benchtwin.vision.recording import Recording


@pytest.fixture
def drop(tmp_path):
    """drop(names) → the folders that were made; the files' content is their name,
    tables have a heading."""
    root = tmp_path / "bench"
    root.mkdir()
    folder, count = Folder(root), iter(range(1000))

    def dropped(names, text=None):
        arrived = []
        for name in names:
            file = tmp_path / f"arrived-{next(count)}"
            file.write_text(text or name)
            arrived.append(ReceivedFile(name, file))
        return place_files(arrived, root, folder)

    dropped.root = root
    return dropped


def test_each_photo_is_a_pile_of_its_own(drop):
    made = drop(["IMG_1.jpg", "IMG_2.png"])
    assert [p.name for p in made] == ["pile-01", "pile-02"]
    assert (made[0] / "IMG_1.jpg").read_text() == "IMG_1.jpg"
    assert 'rig = "pile"' in (made[0] / "recording.toml").read_text()
    assert drop(["IMG_1.jpg"])[0].name == "pile-03"  # nothing is replaced


def test_numbered_pictures_are_a_film(drop):
    (film,) = drop([f"drop_{n:04d}.png" for n in range(LEAST_FRAMES)])
    assert (
        film.name == "drop" and len(list((film / "frames").iterdir())) == LEAST_FRAMES
    )
    assert (
        len(drop([f"heap_{n:04d}.png" for n in range(LEAST_FRAMES - 1)]))
        == LEAST_FRAMES - 1
    )


@pytest.mark.parametrize(
    ("heading", "table"),
    [
        ("t_s,x_mm,y_mm", "track.csv"),
        ("frame,x_px,y_px", "track.csv"),
        ("x_mm,t_s,sd_s", "gates.csv"),
        ("t_s", "impacts.csv"),
        ("repeat,run_out_mm", "readings.csv"),
        ("a,b", "mine.csv"),
    ],
)
def test_tables_are_known_by_their_columns(drop, heading, table):
    (made,) = drop(["mine.csv"], heading + "\n1,2,3\n")
    assert (made / table).is_file() and "# rig" in (made / "recording.toml").read_text()


def test_a_dropped_folder_keeps_its_files_and_its_name(drop):
    made = drop(
        [
            "soy/drop-07/recording.toml",
            "soy/drop-07/track.csv",
            *(f"soy/roll-1/frames/{n:03d}.png" for n in range(3)),
            "soy/roll-1/recording.toml",
        ],
        'rig = "drop"',
    )
    assert sorted(p.name for p in made) == ["drop-07", "roll-1"]
    assert (drop.root / "drop-07" / "track.csv").is_file() and (
        drop.root / "roll-1" / "frames" / "002.png"
    ).is_file()


def test_a_film_and_its_sound_are_one_recording_and_sound_alone_is_a_drop(drop):
    made = drop(["fall.mp4", "fall.wav", "heard.m4a"])
    assert sorted(p.name for p in made[0].iterdir()) == [
        "fall.mp4",
        "fall.wav",
        "recording.toml",
    ]
    assert sorted(p.name for p in made[1].iterdir()) == ["heard.m4a", "recording.toml"]
    assert 'rig = "drop"' in (made[1] / "recording.toml").read_text()


def test_what_was_brought_is_found(drop):
    drop(["a.jpg", "b.mp4"])
    assert [r.id for r in find_recordings(drop.root) if isinstance(r, Recording)] == [
        "b",
        "pile-01",
    ]


@pytest.mark.parametrize(
    "name",
    ["virus.exe", "page.html", "script.svg", "archive.tar", "noend", "pickle.pkl"],
)
def test_other_kinds_are_refused(tmp_path, name):
    with pytest.raises(Refused, match="not something that benchtwin reads"):
        check(name, 10, Folder(tmp_path))


def test_too_large_and_a_full_disk_are_said(tmp_path, monkeypatch):
    for suffix, (kind, most) in KINDS.items():
        with pytest.raises(Refused, match=f"a {kind} has"):
            check(f"x{suffix}", most + 1, Folder(tmp_path))
    monkeypatch.setattr("shutil.disk_usage", lambda _: type("U", (), {"free": 1000})())
    with pytest.raises(Refused, match="than this disk has room for"):
        check("x.jpg", 2000, Folder(tmp_path))
