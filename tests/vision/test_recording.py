"""Recording folders: what is read, what is inherited, and errors that name file and
field."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from benchtwin.vision.find_recordings import find_recordings
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import Recording, read_recording, write_recording

TRACK = "t_s,x_mm,y_mm\n0,0,0\n0.1,0,1\n0.2,0,2\n"


def bench(folder: Path, recording: str, defaults: str = "", name="drop-01") -> Path:
    """A bench folder with one recording holding a track."""
    (folder / name).mkdir(parents=True, exist_ok=True)
    if defaults:
        (folder / "bench.toml").write_text(defaults)
    (folder / name / "recording.toml").write_text(recording)
    (folder / name / "track.csv").write_text(TRACK)
    return folder / name


def test_the_recording_wins_over_the_bench(tmp_path):
    path = bench(
        tmp_path,
        'rig = "drop"\n[camera]\nfps = 5200.0',
        'session = "a"\n[camera]\nfps = 100.0\nmm_per_px = 0.2',
    )
    recording = read_recording(path)
    assert (recording.rig, recording.id, recording.session) == ("drop", "drop-01", "a")
    assert (recording.camera.fps, recording.camera.mm_per_px) == (5200.0, 0.2)
    assert recording.drop.height_mm is None  # absent is unknown
    assert recording.air.density_kg_m3 == 1.20
    assert recording.provenance == "measured"


def test_scale_and_plumb_without_a_stated_sd_are_not_trusted():
    camera = Recording("a", Path(), "drop", "track.csv", ()).camera.model_copy(
        update={"mm_per_px": 0.25}
    )
    assert camera.scale_sd == 0.01
    assert camera.plumb_sd == 1.0
    assert camera.model_copy(update={"plumb_deg": 0.0}).plumb_sd == 0.5
    assert camera.model_copy(update={"mm_per_px_sd": 0.0005}).scale_sd == pytest.approx(
        0.002
    )


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (
            'rig = "dorp"',
            ["recording.toml: rig = 'dorp'", "drop", "slide", "roll", "pile"],
        ),
        ("[camera]\nfpss = 3", ["unknown key [camera] fpss", "did you mean fps?"]),
        (
            "[drop]\nheigth_mm = 310",
            ["unknown key [drop] heigth_mm", "did you mean height_mm?"],
        ),
        (
            "[drop]\nheight_mm = 310000",
            ["[drop] height_mm = 310000 means 310 m", "is it in millimetres?"],
        ),
        ("[drop]\nheight_mm = nan", ["[drop] height_mm", "finite"]),
        ('[camera]\nfps = "fast"', ["[camera] fps = 'fast'", "number"]),
        ("[camera]\nfps = -1", ["[camera] fps = -1", "greater than 0"]),
        ("[pile]\nbox_mm = [1, 2]", ["[pile] box_mm"]),
        ("[camra]\nfps = 3", ["unknown key camra", "did you mean camera?"]),
        ("camera = 3", ["camera = 3"]),
        ("[camera]\nfps = true", ["[camera] fps = True", "number"]),
        ("rig =", ["not valid TOML", "rig has no value; a # before a line"]),
        ("[drop]\nbounces = 2\n[drop]\nheight_mm = 3", ["stands once in a file"]),
        ("[drop]\nheight_mm = 300,5", ["line 2", "'height_mm = 300,5'", "a point"]),
        ("[drop]\nheight_mm = 300 mm", ["'height_mm = 300 mm'", "no unit"]),
        ("[roll]\ndirection = +x", ["'direction = +x'", "quotation marks"]),
    ],
)
@pytest.mark.parametrize("where", ["recording", "bench"])
def test_wrong_keys_are_named_with_their_file(tmp_path, content, words, where):
    path = (
        bench(tmp_path, content)
        if where == "recording"
        else bench(tmp_path, 'rig = "drop"', content)
    )
    (error,) = find_recordings(tmp_path)
    assert isinstance(error, MeasurementError)
    file = path / "recording.toml" if where == "recording" else tmp_path / "bench.toml"
    for word in (str(file), *words[1:]):
        assert word in str(error)


def test_a_missing_key_is_asked_for_by_name(tmp_path):
    recording = read_recording(bench(tmp_path, 'rig = "drop"'))
    with pytest.raises(
        MeasurementError,
        match=r"recording.toml: \[drop\] height_mm is missing; it is needed for Eq. 1",
    ):
        recording.need("drop.height_mm", "for Eq. 1")


def test_one_kind_of_evidence_in_order(tmp_path):
    path = bench(tmp_path, 'rig = "drop"')
    (path / "photo.png").write_bytes(b"x")
    assert read_recording(path).evidence == "track.csv"
    (path / "track.csv").unlink()
    assert read_recording(path).evidence == "photos"
    (path / "a.mp4").write_bytes(b"x")
    assert read_recording(path).evidence == "video"
    (path / "b.mov").write_bytes(b"x")
    with pytest.raises(MeasurementError, match="2 videos; a recording holds one"):
        read_recording(path)
    (path / "frames").mkdir()
    with pytest.raises(MeasurementError, match="holds no frames"):
        read_recording(path)
    (path / "frames" / "000.png").write_bytes(b"x")
    assert read_recording(path).evidence == "frames"


def test_folders_of_photos_and_mixed_benches(tmp_path):
    photo = np.zeros((30, 30), np.uint8)
    (tmp_path / "photos").mkdir()
    for name in ("a.png", "b.JPG", "c.tif"):
        Image.fromarray(photo).save(tmp_path / "photos" / name)
    (tmp_path / "photos" / "notes.txt").write_text("x")
    assert [r.id for r in find_recordings(tmp_path / "photos")] == ["a", "b", "c"]
    bench(tmp_path, 'rig = "drop"')
    bench(tmp_path, 'rig = "dorp"', name="drop-02")
    found = find_recordings(tmp_path)
    assert [getattr(r, "id", "error") for r in found] == [
        "drop-01",
        "error",
        "a",
        "b",
        "c",
    ]
    assert found[1].recording == "drop-02"


def test_benches_in_a_folder_and_frames_named_directly(tmp_path):
    for day in ("day1", "day2"):
        bench(tmp_path / "season" / day, 'rig = "drop"', "[camera]\nfps = 100.0")
    assert [r.camera.fps for r in find_recordings(tmp_path / "season")] == [
        100.0,
        100.0,
    ]
    frames = tmp_path / "season" / "day1" / "drop-01" / "frames"
    frames.mkdir()
    (found,) = find_recordings(frames)
    assert (found.id, found.rig) == ("drop-01", "drop")


def test_nothing_there(tmp_path):
    for path, words in (
        (tmp_path, "nothing to measure here"),
        (tmp_path / "no", "no such file or folder"),
    ):
        (error,) = find_recordings(path)
        assert words in str(error)
    (tmp_path / "x.mp4").write_bytes(b"")
    (tmp_path / "sub").mkdir()
    with pytest.raises(MeasurementError, match="not something to measure"):
        (tmp_path / "x.doc").write_text("x")
        read_recording(tmp_path / "x.doc")


def test_what_is_written_is_read_back(tmp_path):
    keys = (
        '[roll]\nincline_deg = 15.0\ndirection = "-x"\n[seed]\nlength_mm ='
        " 8.72\n[camera]\nfps = 60.0"
    )
    path = bench(tmp_path, f'rig = "roll"\n{keys}')
    recording = read_recording(path)
    write_recording(recording)
    assert read_recording(path) == recording


@settings(max_examples=150, deadline=None, derandomize=True)
@given(
    st.one_of(
        st.binary(max_size=60),
        st.text(max_size=60).map(lambda t: t.encode("utf8", "surrogatepass")),
    )
)
def test_no_file_content_makes_a_traceback(tmp_path_factory, content):
    folder = tmp_path_factory.mktemp("fuzz")
    (folder / "recording.toml").write_bytes(content)
    (folder / "track.csv").write_text(TRACK)
    (entry,) = find_recordings(folder)
    assert isinstance(entry, Recording | MeasurementError)
