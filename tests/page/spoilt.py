"""A bench of recordings whose files are spoilt in many ways, drawn from a seed."""

import io
import struct
import zlib
from pathlib import Path

import numpy as np
from synthetic.film import write_video
from synthetic.series import film_frames, heap_photos

from benchtwin.vision.recording import Recording

TOMLS = (
    'rig = "heap"',
    "rig = 3",
    'rig = ["pile"]',
    'rig = "drop"\nrig = "pile"',
    'rig = "pile"\n[camera]\nfps = "fast"\nmm_per_px = [1]',
    "camera = 3\nseed = 'soy'\nconditions = 7",
    'rig = "pile"\n[pile]\nbaseline_px = "low"\nroi_px = [1, 2]\nwindow_pct = [80, 20]',
    'rig = "drum"\n[unheard]\nof = 1',
    'rig = "slide"\nfavourite = "blue"\n[seed]\nlenght_mm = 8',
    "rig = ",
    "[" * 5000,
    "\x00\x01\x02",
    'rig = "pile"\n[pile]\nroi_px = [0, 0, 60000, 60000]',
    'rig = "pile"\n[pile]\nbaseline_px = [1e300, 0, -1e300, 5]',
    'rig = "drop"\n[drop]\nimpacts_added_s = [nan, 1e9]',
    'id = "../../etc"\nrig = "roll"',
    'rig = "pile"\n[conditions]\na = {b = 1}',
    'rig = "pile"\nsession = "' + "x" * 40_000 + '"',
)


def bomb(side: int = 100_000) -> bytes:
    """A PNG of side × side pixels in a few kilobytes."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        check = struct.pack(">I", zlib.crc32(kind + data))
        return struct.pack(">I", len(data)) + kind + data + check

    head = struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)
    rows = chunk(b"IDAT", zlib.compress(b"\0" * 1_000_000, 9))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + rows


def valid_files(place: Path) -> dict[str, bytes]:
    """One whole file of each kind that a bench holds."""
    (place / "film").mkdir(parents=True)
    frames = film_frames(12)
    recording = Recording("v", place / "film", "drop", "video", ())
    film = write_video(recording, [np.asarray(f) for f in frames]).files[0]

    def saved(kind: str) -> bytes:
        out = io.BytesIO()
        heap_photos(1)[0].save(out, kind)
        return out.getvalue()

    sound = (3000 * np.sin(np.arange(8000))).astype("<i2").tobytes()
    sizes = struct.pack("<IHHIIHH", 16, 1, 1, 8000, 16000, 2, 16)
    wav = b"RIFF" + struct.pack("<I", 36 + len(sound)) + b"WAVEfmt " + sizes
    return {
        "film.mp4": film.read_bytes(),
        "heap.jpg": saved("JPEG"),
        "heap.png": saved("PNG"),
        "heap.tif": saved("TIFF"),
        "heap.bmp": saved("BMP"),
        "heap.webp": saved("WEBP"),
        "fall.wav": wav + b"data" + struct.pack("<I", len(sound)) + sound,
        "track.csv": b"t_s,x_mm,y_mm\n" + b"0.1,2,3\n" * 40,
        "impacts.csv": b"t_s\n0.1\n0.3\n0.4\n",
        "readings.csv": b"repeat,slide_angle_deg\n1,23\n2,24\n",
        "gates.csv": b"x_mm,t_s\n1,2\n3,4\n",
    }


def spoil(data: bytes, rng: np.random.Generator) -> bytes:
    """The data cut, emptied, overwritten, shuffled or left whole."""
    how, at = rng.integers(7), int(rng.integers(1, len(data)))
    if how == 0:
        return data[:at]
    if how == 1:
        return b""
    if how == 2:
        return bytes(rng.integers(0, 256, 500, dtype=np.uint8))
    if how == 3:
        noise = bytes(rng.integers(0, 256, min(60, len(data) - at), dtype=np.uint8))
        return data[:at] + noise + data[at + len(noise) :]
    if how == 4:
        return data[:at] + bytes(len(data) - at)
    if how == 5:
        return data[at:] + data[:at]
    return data


def spoilt_bench(bench: Path, place: Path, count: int, seed: int) -> None:
    """Write `count` recordings into `bench`: one spoilt file each, or keys that are
    wrong beside a whole one; place: for what is written on the way."""
    rng = np.random.default_rng(seed)
    valid = valid_files(place)
    names = list(valid)
    for n in range(count):
        folder = bench / f"r{n:03d}"
        folder.mkdir(parents=True)
        name = names[n % len(names)]
        rigs = ("drop", "slide", "roll", "pile", "drum")
        keys = f'rig = "{rigs[rng.integers(5)]}"\n'
        data = valid[name]
        if n % 3 == 0:
            keys = TOMLS[n // 3 % len(TOMLS)]
        else:
            data = spoil(data, rng)
        (folder / name).write_bytes(data)
        (folder / "recording.toml").write_bytes(keys.encode("latin-1"))
        if n % 17 == 5:  # frames of which one is spoilt
            (folder / "frames").mkdir()
            for i, frame in enumerate(film_frames(4, n)):
                file = folder / "frames" / f"{1000 + i}.png"
                frame.save(file)
                if i == n % 4:
                    file.write_bytes(spoil(file.read_bytes(), rng))
        if n % 23 == 7:
            (folder / "huge.png").write_bytes(bomb())
    (bench / "loose.png").write_bytes(bomb())
    (bench / "IMG_1.jpg").write_bytes(valid["heap.jpg"])
    (bench / "latin.toml").write_bytes(b"\xff\xfe")
    (bench / "odd" / "frames").mkdir(parents=True)
    (bench / "folder.jpg").mkdir()
    (bench / "deep" / "recording.toml").mkdir(parents=True)
    (bench / "bench.toml").write_text("[camera]\nmm_per_px = 0.2\n")
