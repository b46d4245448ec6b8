"""Evidence of a simulated run: frames or a photo as a camera would have taken them, or
the numbers that the simulation knows."""

from pathlib import Path

import cv2
import numpy as np
import pandas as pd

from benchtwin.bench.keys import Seed
from benchtwin.sim.motion import Motion
from benchtwin.sim.picture import film, photo
from benchtwin.sim.rigs.bench import Bench, Watch
from benchtwin.sim.seed.sizes import Sizes
from benchtwin.twin.scene import camera_of, rig_of, sees, setup_of
from benchtwin.vision.recording import Recording

PNG = [cv2.IMWRITE_PNG_COMPRESSION, 1]
RENDERED, STRAIGHT = "rendered", "straight from the simulation"


def pictures(
    motion: Motion,
    recording: Recording,
    folder: Path,
    rng: np.random.Generator,
    watch: Watch,
) -> str:
    """A photo of what lies still, frames of a motion; ValueError when the camera misses
    it."""
    camera, setup = camera_of(recording), setup_of(recording)
    _check(motion, setup.many, camera)
    if setup.photographed and motion.frames == 1:
        watch("rendering", 0.0)
        _save(folder / "photo.png", photo(motion, camera, setup.look, rng=rng))
        return RENDERED
    (folder / "frames").mkdir()
    for n, image in enumerate(film(motion, camera, setup.look, rng=rng)):
        _save(folder / "frames" / f"{n:06d}.png", image)
        if n % 20 == 0:
            watch("rendering", n / motion.frames)
    return RENDERED


def _check(motion: Motion, many: bool, camera) -> None:
    """What must be in the picture: a pile whole, a seed where it starts."""
    last = motion.positions_m[-1 if many else 0]
    there = last[np.isfinite(last).all(axis=1)]
    if not len(there):
        raise ValueError("no seed is left on the plate: there is nothing to photograph")
    seen = sees(camera, there)
    if not seen.all():
        what = (
            f"{(~seen).sum()} of {len(seen)} seeds" if many else "the seed at the start"
        )
        low, high = 1e3 * there.min(axis=0), 1e3 * there.max(axis=0)
        raise ValueError(
            f"the camera does not see {what}: x = {low[0]:.0f} … {high[0]:.0f}, z ="
            f" {low[2]:.0f} … {high[2]:.0f} mm; change camera.mm_per_px,"
            " camera.target_mm, camera.width_px or camera.height_px"
        )


def _save(file: Path, image: np.ndarray) -> None:
    done, data = cv2.imencode(
        ".png", image if image.ndim == 2 else image[:, :, ::-1], PNG
    )
    if not done:
        raise OSError(f"{file}: the picture could not be encoded")
    file.write_bytes(data.tobytes())


def numbers(motion: Motion, recording: Recording, folder: Path) -> str:
    """track.csv as a perfect tracker would give it; or readings.csv with what the
    simulation knows, for a pile the angles of the true outline."""
    setup = setup_of(recording)
    if setup.truth:
        known = {name: [motion.truth[name]] for name in setup.truth} | motion.readings
        pd.DataFrame(known).to_csv(folder / "readings.csv", index=False)
        return STRAIGHT
    x, z = 1e3 * motion.positions_m[:, 0, 0], 1e3 * motion.positions_m[:, 0, 2]
    columns = {"t_s": motion.t_s, "x_mm": motion.series.get("travel_mm", x), "y_mm": z}
    if setup.straight:
        columns["y_mm"] = np.zeros(motion.frames)
    if "tilt_deg" in motion.series:
        columns["tilt_deg"] = motion.series["tilt_deg"]
    pd.DataFrame(columns).to_csv(folder / "track.csv", index=False, float_format="%.9g")
    return STRAIGHT


def seed_section(motion: Motion, bench: Bench, recording: Recording) -> Seed:
    """[seed]: the very seed of a drop or roll; of taped seeds and heaps the lot."""
    update: dict = {"density_kg_m3": bench.seed.density_kg_m3}
    if setup_of(recording).one_seed:
        seed = motion.shapes[0]
        sizes = () if seed.dimensions_m is None else seed.dimensions_m
        update |= {
            name: float(f"{1e3 * v:.6g}")
            for name, v in zip(("length_mm", "width_mm", "thickness_mm"), sizes)
        }
        update |= {"mass_g": 1e3 * seed.mass_kg}
    elif isinstance(bench.sizes, Sizes):
        for name in ("length", "width", "thickness"):
            size = getattr(bench.sizes, name)
            update[f"{name}_mm"] = 1e3 * size.mean_m
            update[f"{name}_range_mm"] = (1e3 * size.least_m, 1e3 * size.most_m)
    else:
        sides = ("length_mm", "width_mm", "thickness_mm")
        update |= dict(zip(sides, (1e3 * v for v in bench.mean_dimensions_m)))
    count = getattr(rig_of(recording), "count", None)
    if count is not None:
        update["count"] = count
    return recording.seed.model_copy(update=update)
