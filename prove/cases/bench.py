"""What a case shall hold, and a bench folder before it is written."""

import shutil
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np
import pandas as pd
import tomli_w


@dataclass(frozen=True)
class Request:
    """What a case shall hold."""

    effects: tuple[str, ...] = ()
    # with recordings that tell the effect apart; None: either
    separated: bool | None = None
    rendered: bool = False  # pictures instead of tracks
    absent: frozenset[str] = frozenset()  # keys that the bench will not state

    def known(self, key: str, stated: float, unstated: float) -> float:
        """The sd to which a quantity is known: as stated, or as benches have it where
        `key` is left out."""
        return unstated if key in self.absent else stated

    def sizes_known(self) -> bool:
        return not self.absent & {"seed.sizes", "seed.mass_g"}


@dataclass(frozen=True, eq=False)
class Recording:
    """One recording with one kind of evidence."""

    name: str  # of its folder
    toml: dict  # content of recording.toml
    track: pd.DataFrame | None = None  # columns of track.csv
    readings: pd.DataFrame | None = None
    frames: tuple[np.ndarray, ...] = ()  # (n, h, w) uint8
    photos: tuple[np.ndarray, ...] = ()  # (h, w) each


@dataclass(frozen=True)
class Bench:
    """A bench folder: bench.toml's content and the recordings."""

    toml: dict
    recordings: tuple[Recording, ...] = field(default=())


def log_uniform(low: float, high: float, rng: np.random.Generator) -> float:
    """Log-uniform between low and high."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def write_bench(bench: Bench, folder: Path) -> None:
    """Write the bench folder; OSError when it cannot be."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(prefix=".prove-", dir=folder.parent) as beside:
        part = Path(beside) / "part"
        part.mkdir()
        (part / "bench.toml").write_text(tomli_w.dumps(bench.toml), encoding="utf8")
        for recording in bench.recordings:
            _write(recording, part / recording.name)
        part.replace(folder)


def _write(recording: Recording, folder: Path) -> None:
    folder.mkdir()
    (folder / "recording.toml").write_text(
        tomli_w.dumps(recording.toml), encoding="utf8"
    )
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
    """Take the frames out of a bench folder that is done with: they are most of its
    size, and can be made again."""
    for frames in folder.glob("*/frames"):
        shutil.rmtree(frames, ignore_errors=True)
