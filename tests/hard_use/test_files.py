"""Files that are wrong on purpose: refused in words that name the file, in little time
and memory."""

import struct
import time
import zlib

import numpy as np
import pytest
from measure_all import measure
from PIL import Image
from synthetic.film import Look, film, write_video
from synthetic.motion import draw_drop

from benchtwin.vision.evidence import photo, read_keys, tables
from benchtwin.vision.evidence.frames import Video
from benchtwin.vision.evidence.photo import read_photo
from benchtwin.vision.evidence.read_keys import read_toml
from benchtwin.vision.evidence.tables import read_readings
from benchtwin.vision.find_recordings import find_recordings
from benchtwin.vision.foreign.as_evidence import read_impacts, read_track
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import Recording


def chunk(kind: bytes, data: bytes) -> bytes:
    return (
        struct.pack(">I", len(data))
        + kind
        + data
        + struct.pack(">I", zlib.crc32(kind + data))
    )


def png(width: int, height: int, *chunks: bytes) -> bytes:
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
        + b"".join(chunks)
    )


BOMB = zlib.compress(b"\0" * 50_000_000, 9)
PICTURES = {
    "large.png": (png(100_000, 100_000, chunk(b"IDAT", BOMB)), "megapixels"),
    "cut.png": (
        png(8000, 8000, chunk(b"IDAT", zlib.compress(b"\0" * 1000))),
        "damaged or cut short",
    ),
    "text.png": (
        png(10, 10, chunk(b"zTXt", b"a\0\0" + BOMB), chunk(b"IDAT", BOMB)),
        "damaged or cut short",
    ),
    "wrong.png": (png(10, 10)[:20] + b"\xff" * 40, "damaged|not a picture"),
    "float.png": (b"PF\n30000 30000\n-1.0\n" + b"\0" * 100, "not a picture"),
    "wide.tif": (
        b"II*\0"
        + struct.pack("<IHHHIIHHII", 8, 2, 256, 4, 1, 2**31, 257, 4, 1, 2**31)
        + b"\0" * 4,
        "damaged|not a picture|megapixels",
    ),
}


@pytest.mark.parametrize("name", PICTURES)
def test_a_hostile_picture_is_refused(tmp_path, name):
    content, said = PICTURES[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(MeasurementError, match=f"{name}.*({said})"):
        read_photo(tmp_path / name)


def test_whatever_a_decoder_raises_names_the_file(tmp_path, monkeypatch):
    Image.new("L", (4, 4)).save(tmp_path / "a.png")

    def broken(path):
        raise struct.error("unpack requires a buffer of 4 bytes")

    monkeypatch.setattr(photo, "_decode", broken)
    with pytest.raises(MeasurementError, match=r"a\.png: the picture is damaged"):
        read_photo(tmp_path / "a.png")


TOML = {
    "many": ("".join(f"k{i} = 1\n" for i in range(1_000_000)), "30,000 at most"),
    "deep": ("a = " + "[" * 5000, "too deep"),
    "dotted": ("seed.length_mm" + ".a" * 3000 + " = 1", "length_mm"),
    "long": (f'rig = "{"x" * 20_000}"', "rig"),
    "huge": ("[camera]\nfps = 1e999", "fps"),
}


@pytest.mark.parametrize("name", TOML)
def test_hostile_keys_are_refused_in_a_short_line(tmp_path, name):
    content, said = TOML[name]
    file = tmp_path / "recording.toml"
    file.write_text(content)
    start = time.process_time()
    with pytest.raises(MeasurementError, match=said) as refused:
        read_toml(file)
    assert (
        str(file) in str(refused.value)
        and len(str(refused.value)) < len(str(file)) + 300
    )
    assert time.process_time() - start < 2
    assert read_keys.MOST_BYTES < 1e5


def test_one_of_several_kinds_is_named_by_its_key(tmp_path):
    (tmp_path / "recording.toml").write_text("[drop]\norientation = 3\n")
    with pytest.raises(
        MeasurementError,
        match=r"\[drop\] orientation = 3: input should be 'flat' or 'any'",
    ):
        read_toml(tmp_path / "recording.toml")


TRACK = "t_s,x_mm,y_mm\n0,0,0\n1,{},0\n2,0,0\n"
CSV = {
    "one line": (read_track, "t_s," * 5000, "a line of more than"),
    "more fields than names": (
        read_track,
        "t_s,x_mm,y_mm\n0,0,0,5\n1,0,0,5\n2,0,0,5\n",
        "more fields",
    ),
    "too large": (
        read_track,
        TRACK.format("1e308"),
        "x_mm = 1e.308 in row 3 cannot be",
    ),
    "digits": (
        read_track,
        TRACK.format("9" * 400),
        "x_mm = .* in row 3 is not a number",
    ),
    "words": (read_track, TRACK.format("one"), "x_mm = 'one' in row 3 is not a number"),
    "an sd of next to nothing": (
        read_track,
        "t_s,x_mm,y_mm,sd_mm\n0,0,0,.1\n1,0,0,2e-313\n2,0,0,.1\n",
        "sd_mm = 2e-313 in row 3",
    ),
    "an sd of nil": (
        read_track,
        "frame,x_px,y_px,sd_px\n0,0,0,.1\n1,0,0,0\n2,0,0,.1\n",
        "sd_px = 0 in row 3; it should be above 0",
    ),
    "an angle's sd below nil": (
        read_track,
        "t_s,x_mm,y_mm,angle_sd_deg\n0,0,0,-2\n1,0,0,1\n2,0,0,1\n",
        "angle_sd_deg = -2 in row 2",
    ),
    "decimals in two ways": (
        read_track,
        "t_s;x_mm;y_mm\n0;0,1;0\n1;0.2;0\n2;0;0\n",
        "separated by ';', its numbers written in two ways",
    ),
    "readings of digits": (
        read_readings,
        "rebound_height_mm\n" + "9" * 400 + "\n100\n",
        "rebound_height_mm = .* in row 2",
    ),
    "impacts at no time": (read_impacts, "t_s\nnan\ninf\n", "no row has numbers"),
    "zeros": (read_impacts, "\0\0\0\n\0\n", "a.csv"),
    "not text": (read_impacts, "t_s\n\udcff\udcfe\n", "a.csv"),
}


@pytest.mark.parametrize("name", CSV)
def test_a_hostile_table_is_refused(tmp_path, name):
    read, content, said = CSV[name]
    (tmp_path / "a.csv").write_bytes(content.encode("utf8", "surrogateescape"))
    with pytest.raises(MeasurementError, match=said) as refused:
        read(tmp_path / "a.csv")
    assert "a.csv" in str(refused.value) and len(str(refused.value)) < 400 + len(
        str(tmp_path)
    )


def test_a_table_of_gigabytes_is_not_read(tmp_path, monkeypatch):
    monkeypatch.setattr(tables, "MOST_BYTES", 10)
    (tmp_path / "a.csv").write_text(TRACK)
    with pytest.raises(
        MeasurementError, match=r"a\.csv: 0 MB; a table has 0 MB at most"
    ):
        read_track(tmp_path / "a.csv")


def test_links_in_a_circle_end(tmp_path):
    drop = tmp_path / "bench" / "drop-01"
    drop.mkdir(parents=True)
    (drop / "recording.toml").write_text('rig = "drop"\n')
    (drop / "impacts.csv").write_text("t_s\n0.1\n0.4\n0.6\n")
    for where in (
        tmp_path / "bench",
        tmp_path / "bench" / "notes",
        tmp_path / "bench" / "more",
    ):
        where.mkdir(exist_ok=True)
        for k in range(4):
            (where / f"loop-{k}").symlink_to(tmp_path / "bench")
    (tmp_path / "bench" / "self").symlink_to(tmp_path / "bench" / "self")
    assert [found.id for found in find_recordings(tmp_path / "bench")] == ["drop-01"]


def test_a_film_of_too_large_frames_is_refused(tmp_path, monkeypatch):
    motion, look = draw_drop(height_mm=50, end_s=0.05), Look(width=64, height=48)
    recording = Recording("a", tmp_path, "drop", "", ())
    video = write_video(
        recording, film(motion, look, np.random.default_rng(1), fps=100), fps=100
    ).files[0]
    monkeypatch.setattr("benchtwin.vision.evidence.frames.MAX_PIXELS", 1000)
    with pytest.raises(
        MeasurementError, match=r"video\.mp4: 64 × 48 pixels a frame is more than"
    ):
        Video(video, None)


def test_a_film_with_spoilt_bytes_is_told_not_fatal(tmp_path):
    motion, look, rng = (
        draw_drop(height_mm=50, end_s=0.2),
        Look(width=64, height=48),
        np.random.default_rng(1),
    )
    recording = Recording("a", tmp_path / "a", "drop", "", ())
    good = (
        write_video(recording, film(motion, look, rng, fps=200), fps=200)
        .files[0]
        .read_bytes()
    )
    for k in range(6):
        folder = tmp_path / f"drop-{k}"
        folder.mkdir()
        (folder / "recording.toml").write_text('rig = "drop"\n')
        spoilt = bytearray(good)
        for at in rng.integers(len(spoilt) // 4, len(spoilt), 30):
            spoilt[at] = rng.integers(256)
        (folder / "video.mp4").write_bytes(
            bytes(spoilt) if k else good[: len(good) // 2]
        )
        reasons = [
            q.reason for observation in measure(folder) for q in observation.quantities
        ]
        assert reasons and not any("a fault of benchtwin" in r for r in reasons), (
            reasons
        )
