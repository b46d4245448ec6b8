"""Slides and rolls of the twin like a recording's: how far along their path; and
pictures of twins beside each other."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from benchtwin.bench.keys import Keys
from benchtwin.sim.motion import Motion
from benchtwin.sim.picture import Camera, photo
from benchtwin.twin.parameters import Parameters
from benchtwin.twin.run import observe, run, simulate
from benchtwin.twin.scene import camera_of, setup_of
from benchtwin.vision.evidence.read_keys import validate
from benchtwin.vision.recording import Recording

MOST_PX = 900  # of a picture's width


@dataclass(frozen=True, eq=False)
class Path1D:
    """time (n,) [s], way (n,) [mm] along the path."""

    time: np.ndarray
    way: np.ndarray

    def reached(self, way_mm: float) -> float:
        """When `way_mm` was first reached [s]; NaN if never."""
        there = np.flatnonzero(self.way >= way_mm)
        if not len(there):
            return float("nan")
        k = int(there[0])
        if k == 0:
            return float(self.time[0])
        part = (way_mm - self.way[k - 1]) / (self.way[k] - self.way[k - 1])
        return float(self.time[k - 1] + part * (self.time[k] - self.time[k - 1]))

    def at(self, time: np.ndarray) -> np.ndarray:
        """Way at these times; at rest before and behind."""
        return np.interp(time, self.time, self.way)


@dataclass(frozen=True, eq=False)
class Ran(Path1D):
    """The way of a twin, and its whole motion."""

    motion: Motion


def like(rig: str, description: dict, **changes: Any) -> Recording:
    """A recording with these sections, keys that no recording.toml has left out, and
    `changes` to the rig's section."""
    kept = {}
    for name in ("seed", "camera", "air", rig):
        known = type(getattr(Keys(), name)).model_fields
        kept[name] = {k: v for k, v in description.get(name, {}).items() if k in known}
    kept[rig] |= changes
    sections = validate(kept, Path("recording.toml"))
    told = {name: getattr(sections, name) for name in kept}
    return Recording("twin", Path("twin"), rig, "", (), **told)


def run_path(recording: Recording, parameters: Parameters, number: int) -> Ran:
    """The twin's run; the same number, the same seed and placing."""
    motion, _ = run(recording, parameters, rng=np.random.default_rng([5, number]))
    way = motion.series["travel_mm"]
    return Ran(motion.t_s, way - way[0], motion)


def filmed(
    recording: Recording,
    parameters: Parameters,
    number: int,
    out: Path,
    watch: Callable[[str], None],
) -> Path1D:
    """The same filmed into the folder `out`, and followed by the measuring code."""

    def told(stage: str, share: float) -> None:
        watch(f"{out.name}: {stage}, {100 * share:.0f} %")

    rng = np.random.default_rng([5, number])
    made = simulate(
        recording.need_rig(), parameters, rng=rng, out=out, like=recording, watch=told
    )
    track = observe(made).track
    if track is None:
        raise ValueError(
            f"{out}: the measuring code found nothing that moves in the twin's film"
        )
    way = track["x_mm"].to_numpy()
    return Path1D(track["t_s"].to_numpy(), np.abs(way - way[0]))


def shown(recording: Recording, motion: Motion, frames: list[int]) -> np.ndarray:
    """Those frames of a run in one grey picture, the brightest of each pixel."""
    camera = camera_of(recording)
    shrink = max(1.0, camera.width_px / MOST_PX)
    small = Camera(
        int(camera.width_px / shrink),
        int(camera.height_px / shrink),
        camera.mm_per_px * shrink,
        camera.target_m,
        camera.distance_m,
    )
    look = setup_of(recording).look
    return np.max(
        np.stack([photo(motion, small, look, frame=f) for f in frames]), axis=0
    )


def above(pictures: list[np.ndarray], titles: list[str]) -> bytes:
    """Wide grey pictures under each other, their empty rows cut, with titles, as
    PNG."""
    rows = np.flatnonzero(np.ptp(pictures[0], axis=1) > 12)
    low, high = max(int(rows.min()) - 10, 0), int(rows.max()) + 10
    out = []
    for picture, title in zip(pictures, titles, strict=True):
        band = np.full((26, picture.shape[1]), 255, np.uint8)
        _write(band, title, (4, 19), 0.5)
        out += [band, picture[low:high]]
    return cv2.imencode(".png", np.vstack(out))[1].tobytes()


def beside(pictures: list[np.ndarray], titles: list[str]) -> bytes:
    """Grey pictures of one size side by side with their titles above, as PNG."""
    rows, columns = pictures[0].shape
    width, band = max(columns, 170), 34
    canvas = np.full((rows + band, len(pictures) * (width + 8) - 8), 255, np.uint8)
    for k, (picture, title) in enumerate(zip(pictures, titles, strict=True)):
        x = k * (width + 8)
        canvas[band:, x + (width - columns) // 2 :][:rows, :columns] = picture
        _write(canvas, title, (x + 4, 23), 0.55)
    return cv2.imencode(".png", canvas)[1].tobytes()


def _write(picture: np.ndarray, text: str, at: tuple[int, int], size: float) -> None:
    cv2.putText(picture, text, at, cv2.FONT_HERSHEY_SIMPLEX, size, 40, 1, cv2.LINE_AA)
