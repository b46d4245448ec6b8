"""What a case shall hold, a bench as it is, and as a folder."""

import shutil
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Self

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


@dataclass(frozen=True)
class Scene:
    """A bench as it is. worlds: what is true of each recording, named tuples whose
    fields hold the effects, too, 0 where they are not; toml: of bench.toml."""

    worlds: tuple[Any, ...]
    request: Request
    toml: dict
    noise: Any = None  # of its camera, a Noise
    scale_sd: float = 0.001  # of mm per pixel, relative
    plumb_sd_deg: float = 0.05

    def changed(self, **fields: Any) -> Self:
        """The scene with these fields in all of its worlds."""
        worlds = tuple(world._replace(**fields) for world in self.worlds)
        return replace(self, worlds=worlds)


@dataclass(frozen=True, eq=False)
class Recording:
    """One recording with one kind of evidence."""

    name: str  # of its folder
    toml: dict  # content of recording.toml
    track: pd.DataFrame | None = None  # columns of track.csv
    readings: pd.DataFrame | None = None
    pictures: dict[str, np.ndarray] = field(default_factory=dict)  # file → (h, w) uint8


@dataclass(frozen=True)
class Bench:
    """A bench folder: bench.toml's content and the recordings."""

    toml: dict
    recordings: tuple[Recording, ...]


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
    for name, table in (("track", recording.track), ("readings", recording.readings)):
        if table is not None:
            table.to_csv(folder / f"{name}.csv", index=False)
    for name, pixels in recording.pictures.items():
        file = folder / name
        file.parent.mkdir(exist_ok=True)
        if not cv2.imwrite(str(file), pixels, [cv2.IMWRITE_PNG_COMPRESSION, 4]):
            raise OSError(f"{file}: cannot be written")


def drop_frames(folder: Path) -> None:
    """Take the frames out of a bench folder that is done with: they are most of its
    size, and can be made again."""
    for frames in folder.glob("*/frames"):
        shutil.rmtree(frames, ignore_errors=True)
