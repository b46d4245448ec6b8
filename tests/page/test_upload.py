"""Dropped files become recordings: sorted by what they are, nothing replaced, nothing
half."""

import socket

import pytest
from synthetic.series import film_frames, heap_photos

from benchtwin.page.folder import Folder, Refused
from benchtwin.page.measuring import original_name
from benchtwin.page.upload import KINDS, ReceivedFile, check, place_files
from benchtwin.vision.evidence.film_or_photos import LEAST_FRAMES
from benchtwin.vision.find_recordings import find_recordings
from benchtwin.vision.recording import Recording, read_recording

from .visitor import Visitor


@pytest.fixture
def drop(tmp_path):
    """drop(names) → what was placed; the files' content is their name, or the text or
    the pictures that are given."""
    root = tmp_path / "bench"
    root.mkdir()
    count = iter(range(1000))

    def placed(names, text=None, pictures=None):
        arrived = []
        for n, name in enumerate(names):
            file = tmp_path / f"arrived-{next(count)}"
            if pictures:
                pictures[n].save(file, "JPEG")
            else:
                file.write_text(text or name)
            arrived.append(ReceivedFile(name, file))
        return place_files(arrived, root)

    def dropped(*args, **keys):
        done = placed(*args, **keys)
        assert not done.refused
        return done.made

    dropped.root, dropped.placed = root, placed
    return dropped


def test_each_photo_is_a_pile_of_its_own(drop):
    made = drop(["IMG_1.jpg", "IMG_2.png"])
    assert [p.name for p in made] == ["pile-01", "pile-02"]
    assert (made[0] / "IMG_1.jpg").read_text() == "IMG_1.jpg"
    assert 'rig = "pile"' in (made[0] / "recording.toml").read_text()
    assert drop(["IMG_1.jpg"])[0].name == "pile-03"  # nothing is replaced


def test_numbered_frames_are_a_film(drop):
    names = [f"drop_{n:04d}.png" for n in range(LEAST_FRAMES)]
    (film,) = drop(names, pictures=film_frames(LEAST_FRAMES))
    assert film.name == "drop"
    assert sorted(p.name for p in (film / "frames").iterdir()) == names
    few = [f"heap_{n:04d}.png" for n in range(LEAST_FRAMES - 1)]
    assert len(drop(few, pictures=film_frames(LEAST_FRAMES))) == LEAST_FRAMES - 1


def test_fifty_photos_of_heaps_are_fifty_heaps(drop):
    names = [f"IMG_{n}.jpg" for n in range(4300, 4350)]
    made = drop(names, pictures=heap_photos(50))
    assert [p.name for p in made] == [f"pile-{n:02d}" for n in range(1, 51)]
    found = [read_recording(p) for p in made]
    assert {(r.rig, r.evidence) for r in found} == {("pile", "photos")}
    assert [original_name(r) for r in found] == names


def test_pictures_that_may_be_either_are_one_recording_that_asks(drop):
    names = [f"a_{n:04d}.png" for n in range(1, 21)]  # as a frame grabber names them
    (made,) = drop(names, pictures=heap_photos(20))
    assert sorted(p.name for p in made.glob("*.png")) == names
    found = read_recording(made)
    assert (found.rig, found.evidence, len(found.files)) == (None, "photos", 20)


def test_a_folder_of_frames_keeps_the_name_of_its_film(drop):
    names = [f"soy/roll-1/frames/{n:03d}.png" for n in range(3)]
    (made,) = drop(names)
    assert made.name == "roll-1" and len(list((made / "frames").iterdir())) == 3


def test_what_cannot_be_placed_keeps_nothing_else_back(drop, monkeypatch):
    (drop.root / "bench.toml").write_text("")
    done = drop.placed(["bench.toml", "a.jpg", "b.mp4"])
    assert [p.name for p in done.made] == ["pile-01", "b"]
    assert "bench.toml exists already" in done.refused[0]
    assert (drop.root / "bench.toml").read_text() == ""


def test_files_that_would_have_one_name_both_stay(drop):
    names = ["what?.csv", "what.csv", "x/track.csv", "x/tra?ck.csv"]
    made = drop(names, "t_s,x_mm\n1,2")
    assert len([f for p in made for f in p.glob("*.csv")]) == len(names)


def test_the_name_of_a_table_is_kept(drop):
    (made,) = drop(["Tracker export 3.csv"], "t_s,x_mm,y_mm\n1,2,3\n")
    (made / "recording.toml").write_text(
        'rig = "drop"\n' + (made / "recording.toml").read_text()
    )
    assert original_name(read_recording(made)) == "Tracker export 3.csv"


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


def test_a_copy_that_is_cut_off_leaves_room_for_the_next(tmp_path, serve):
    """The connection breaks in the middle; the same batch then goes on as if nothing
    had been."""
    batch = "01234567-89ab-cdef-0123-456789abcdef"
    with serve(tmp_path / "bench") as address:
        visitor = Visitor(address)
        host = visitor.root.removeprefix("http://")
        cookie = "; ".join(f"{c.name}={c.value}" for c in visitor.cookies)
        head = f"PUT /upload/{batch}?name=a.jpg HTTP/1.1\r\nHost: {host}\r\nCookie:"
        name, port = host.split(":")
        with socket.create_connection((name, int(port))) as broken:
            broken.sendall(f"{head} {cookie}\r\nContent-Length: 999\r\n\r\nxx".encode())
        assert visitor.send("PUT", f"/upload/{batch}?name=b.jpg", b"whole") == 204
        assert visitor.send("POST", f"/sort/{batch}?bench=.", b"") == 200
        assert [p.read_bytes() for p in (tmp_path / "bench").rglob("*.jpg")] == [
            b"whole"
        ]
