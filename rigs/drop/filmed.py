"""A drop of the twin in pictures: several moments in one, and films that the measuring
code follows."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import tomli_w

from benchtwin.bench.language import tr
from benchtwin.rigs.drop import RIG
from benchtwin.rigs.drop.flown import motion_of
from benchtwin.sim.picture import Camera, Look, film
from benchtwin.twin.run import observe
from benchtwin.twin.write import PNG
from benchtwin.vision.recording import read_recording

MARGIN_M = 0.02
TALLEST_PX = 1100


@dataclass(frozen=True, eq=False)
class Seed:
    """One seed on its way: time (n,) [s], places (n, 2) [m] of its centre, angle (n,)
    [rad] anticlockwise; plate_z [m]."""

    description: dict
    time: np.ndarray
    places: np.ndarray
    angle: np.ndarray
    plate_z: float


def camera_for(
    places: np.ndarray, plate_z: float, mm_per_px: float | None = None
) -> Camera:
    """A camera that sees all places (n, 2) [m] and the plate, at the stated scale or as
    fine as TALLEST_PX allow."""
    low, high = places.min(0) - MARGIN_M, places.max(0) + MARGIN_M
    low[1] = min(low[1], plate_z - 0.008)
    wide, tall = high - low
    scale = max(mm_per_px or 0.0, 1e3 * tall / TALLEST_PX)
    size = [
        int(np.ceil(1e3 * v / scale / 16)) * 16 for v in (max(wide, 0.12 * tall), tall)
    ]
    middle = (low + high) / 2
    return Camera(
        size[0], size[1], scale, (float(middle[0]), 0.0, float(middle[1])), 10.0
    )


def moments(seed: Seed, camera: Camera) -> np.ndarray:
    """All moments in one picture, as a flash in the dark shows them: uint8 (rows,
    columns)."""
    motion = motion_of(
        seed.description, seed.time, seed.places, seed.angle, seed.plate_z
    )
    return np.max(
        np.stack(list(film(motion, camera, Look(grey=True, variation=0.0)))), axis=0
    )


def followed(
    seed: Seed, fps: float, folder: Path, watch: Callable[[str], None]
) -> tuple[np.ndarray, np.ndarray]:
    """The seed filmed into `folder` (a recording of a drop, replaced) and followed by
    the measuring code.

    Returns time (m,) [s] from the first frame, and places (m, 2) [m] with the origin of
    `seed.places`."""
    camera = camera_for(seed.places, seed.plate_z, 0.25)
    (folder / "frames").mkdir(parents=True, exist_ok=True)
    for old in (folder / "frames").glob("*.png"):
        old.unlink()
    motion = motion_of(
        seed.description, seed.time, seed.places, seed.angle, seed.plate_z
    )
    for n, image in enumerate(film(motion, camera, Look(grey=True))):
        (folder / "frames" / f"{n:06d}.png").write_bytes(
            cv2.imencode(".png", image, PNG)[1].tobytes()
        )
        if n % 20 == 0:
            watch(f"filming {folder.name}, {100 * n / motion.frames:.0f} %")
    told = {
        "rig": RIG.name,
        "provenance": "simulated",
        "camera": {"fps": float(fps), "mm_per_px": camera.mm_per_px, "plumb_deg": 0.0},
    }
    (folder / "recording.toml").write_text(tomli_w.dumps(told), encoding="utf8")
    watch(f"following {folder.name}")
    track = observe(read_recording(folder, {})).track
    if track is None:
        raise ValueError(
            tr("{}: the measuring code found no seed in the twin's film", folder)
        )
    found = 1e-3 * track[["x_mm", "y_mm"]].to_numpy()
    frame = track["frame"].to_numpy(int)
    # the measuring code's origin is its own
    off = np.median(seed.places[frame] - found, axis=0)
    return seed.time[frame] - seed.time[0], found + off
