"""A Bench as the folder that the solver is given; it appears whole."""

import shutil
from pathlib import Path

import cv2
import tomli_w

from prove.cases.bench import Bench, Recording


def write_bench(bench: Bench, folder: Path) -> None:
    """Write the bench folder; OSError when it cannot be."""
    part = folder.with_name(f".{folder.name}.part")
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir(parents=True)
    (part / "bench.toml").write_text(tomli_w.dumps(bench.toml), encoding="utf8")
    for recording in bench.recordings:
        _write(recording, part / recording.name)
    part.replace(folder)


def _write(recording: Recording, folder: Path) -> None:
    folder.mkdir()
    (folder / "recording.toml").write_text(tomli_w.dumps(recording.toml), encoding="utf8")
    if recording.track is not None:
        recording.track.to_csv(folder / "track.csv", index=False)
    if recording.readings is not None:
        recording.readings.to_csv(folder / "readings.csv", index=False)
    if recording.frames:
        (folder / "frames").mkdir()
    for i, frame in enumerate(recording.frames):
        _picture(folder / "frames" / f"{i:06d}.png", frame)
    for i, photo in enumerate(recording.photos):
        _picture(folder / f"photo-{i + 1}.png", photo)


def _picture(file: Path, pixels) -> None:
    if not cv2.imwrite(str(file), pixels, [cv2.IMWRITE_PNG_COMPRESSION, 4]):
        raise OSError(f"{file}: cannot be written")


def drop_frames(folder: Path) -> None:
    """Take the frames out of a bench folder that is done with: they are most of its size, and can be made again."""
    for frames in folder.glob("*/frames"):
        shutil.rmtree(frames, ignore_errors=True)
