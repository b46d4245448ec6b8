"""The drops as files: tracks with their noise, or frames, and what the recordings
state."""

import numpy as np
import pandas as pd

from benchtwin.prove.cases.bench import Bench, Recording
from benchtwin.prove.cases.camera import magnification, project
from benchtwin.prove.cases.drop import Scene, SimulatedDrop, fly_all
from benchtwin.prove.cases.ellipsoid import angle, outlines
from benchtwin.prove.cases.noise import kept, noisy, shocks
from benchtwin.prove.cases.picture import film
from benchtwin.prove.cases.stated import camera_keys

ORIGIN_MM = (
    40.0,
    12.0,
)  # the picture's corner is the origin; where the plate lies in it


def bench(scene: Scene, sizes: dict[str, float]) -> Bench:
    """The bench folder of a scene with these effects."""
    length, width, thickness = (round(v, 2) for v in scene.stated_axes_mm)
    volume = np.pi / 6 * np.prod(scene.stated_axes_mm)
    toml = {
        "provenance": "measured",
        "seed": {
            "length_mm": length,
            "width_mm": width,
            "thickness_mm": thickness,
            "mass_g": float(f"{volume * scene.density * 1e-6:.4g}"),
        },
        "air": {"density_kg_m3": scene.air.density},
    }
    return Bench(
        toml,
        tuple(_recording(scene, i, d) for i, d in enumerate(fly_all(scene, sizes))),
    )


def _recording(scene: Scene, i: int, drop: SimulatedDrop) -> Recording:
    rng = np.random.default_rng(drop.run.noise_seed)
    camera = drop.camera
    keys = _keys(scene, i, drop)
    shapes = outlines(drop.rows, np.array(drop.run.axes))
    turned = angle(shapes)
    depth = drop.rows[:, 1] * 1e3
    x, y = project(camera, drop.rows[:, 0] * 1e3, drop.rows[:, 2] * 1e3, turned, depth)
    if scene.request.rendered:
        keys["camera"]["exposure_s"] = 1e-4
        per_px = (1e3 / scene.mm_per_px * magnification(camera, depth)) ** 2
        pixels = np.column_stack([x, y]) / scene.mm_per_px
        outline = shapes * per_px[:, None, None]
        return Recording(
            keys["id"], keys, frames=film(pixels, outline, camera, scene.mm_per_px, rng)
        )
    x, y = x + ORIGIN_MM[0], y + camera.centre_mm[1] + ORIGIN_MM[1]
    table: dict[str, np.ndarray | float] = {
        "t_s": np.round(drop.stated_s, 7),
        "x_mm": noisy(x, scene.noise, rng).round(5),
        "y_mm": noisy(y, scene.noise, rng).round(5),
    }
    if scene.angle_sd_deg:
        table["angle_deg"] = (
            np.degrees(turned) + scene.angle_sd_deg * shocks(len(x), 1, np.inf, rng)[0]
        ).round(3)
    table["sd_mm"] = float(f"{scene.noise.sd:.3g}")
    return Recording(
        keys["id"], keys, track=pd.DataFrame(table)[kept(len(x), scene.noise, rng)]
    )


def _keys(scene: Scene, i: int, drop: SimulatedDrop) -> dict:
    """recording.toml of the i-th drop."""
    away = scene.stated_distance_mm[drop.run.session]
    plumb = (drop.camera.plumb_deg, round(scene.plumb_sd_deg, 4))
    camera = camera_keys(
        scene.mm_per_px, scene.scale_sd, *plumb, fps=scene.fps, distance_mm=away
    )
    named = {
        "rig": "drop",
        "id": f"drop-{i + 1:02d}",
        "session": f"day-{drop.run.session + 1}",
    }
    height = {"height_mm": drop.run.stated_mm, "height_sd_mm": 1.0}
    return named | {"camera": camera, "drop": height}
