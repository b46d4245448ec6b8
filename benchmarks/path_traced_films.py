"""Path-traced films of drops, rolls and slides with known truth, then measured: how
often intervals hold, what is good and wrong.

python benchmarks/path_traced_films.py FOLDER [--n 6] [--rng 1] [--rigs drop roll slide]

Motions and what is stated of them are those of phone_films.py; the pictures are
Mitsuba's (scalar_rgb, one thread; some minutes a film): real perspective and shadows,
mirror images in a glossy plate, tweezers that let go, a lamp and a lit room, pale seeds
before pale, dark and busy walls, motion blur, a rolling shutter of 2 to 15 ms, photon
noise, H.264. Films that lie in FOLDER are not drawn anew. What the seed changes is
drawn in a window around it and added to the still picture, with the same random numbers
with and without it, so that nothing else changes from frame to frame than what its
light and shadow change."""

import argparse
import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import cv2
import numpy as np
import pandas as pd
from drawn_films import DRAWN, HIGH, RIGS, WIDE, Film, write_h264
from mitsuba_scene import box, painted_surface, plain_surface, sphere_mesh, srgb
from phone_films import found_in, report, write

LOOKS = ("pale on pale", "pale on busy", "dark on pale", "pale on dark")
INSTANTS = 6  # a frame: of blur and rolling shutter
SAMPLES = 6  # a pixel and instant
STILL_SAMPLES = 48
MOST_FPS = 120.0  # more frames take longer to draw and are easier to measure
PLATE_DEEP_MM = 40.0  # half of it, before and behind the plane of motion


class Stage:
    """Everything about one film that stays: camera, light, plate, wall; `still` is the
    picture without seed [linear light]."""

    def __init__(self, film: Film, look: str, rng: np.random.Generator):
        import mitsuba as mi

        self.film, self.mi = film, mi
        pale = look.startswith("pale")
        self.seed_bsdf = mi.load_dict(
            {
                "type": "principled",
                "roughness": float(rng.uniform(0.3, 0.6)),
                "specular": 0.4,
                "base_color": {
                    "type": "rgb",
                    "value": [
                        float(v)
                        for v in ((0.72, 0.6, 0.36) if pale else (0.09, 0.05, 0.03))
                    ],
                },
            }
        )
        tone = (
            rng.uniform(0.5, 0.7) if look != "pale on dark" else rng.uniform(0.05, 0.15)
        )
        gloss = {
            "type": "roughconductor",
            "alpha": float(rng.uniform(0.05, 0.25)),
            "specular_reflectance": 0.9,
        }
        body = {
            "type": "blendbsdf",
            "weight": float(rng.uniform(0.03, 0.25)),
            "a": plain_surface(mi, tone),
            "b": gloss,
        }
        self.plate_bsdf = mi.load_dict({"type": "twosided", "bsdf": body})
        wall = {
            "pale on busy": lambda: painted_surface(mi, _clutter(rng)),
            "pale on dark": lambda: plain_surface(mi, 0.04),
        }
        wall_bsdf = wall.get(
            look,
            lambda: plain_surface(
                mi, rng.uniform(0.55, 0.75) * np.array([1.0, 0.98, 0.93])
            ),
        )()
        far = float(rng.uniform(80, 300))
        span = 1.5 * (film.distance_mm + far) * HIGH * film.mm_per_px / film.distance_mm
        self.wall = mi.load_dict(box(mi, [0, 0, far + 5], [span, span, 5], wall_bsdf))
        side = float(rng.uniform(60, 250))
        at = [
            float(rng.uniform(-250, 250)),
            float(rng.uniform(300, 600)),
            float(rng.uniform(-500, -50)),
        ]
        place = mi.ScalarTransform4f
        self.light = {
            "sky": {"type": "constant", "radiance": float(rng.uniform(0.3, 0.8))},
            "lamp": {
                "type": "rectangle",
                "to_world": place()
                .look_at(origin=at, target=[0, 0, 0], up=[0, 0, 1])
                .scale([side, side, 1]),
                "emitter": {
                    "type": "area",
                    "radiance": float(3e5 / side**2 * rng.uniform(0.6, 1.2)),
                },
            },
        }
        self.eye = np.array(
            [
                (WIDE / 2 - film.corner_px[0]) * film.mm_per_px,
                (film.corner_px[1] - HIGH / 2) * film.mm_per_px,
                -film.distance_mm,
            ]
        )
        self.ball = sphere_mesh(24, 40)
        whole = (0, 0, WIDE, HIGH)
        self.still = self.shot(math.inf, whole, STILL_SAMPLES)

    def shot(
        self, t: float, window: tuple[int, int, int, int], samples: int
    ) -> np.ndarray:
        """The window (column, row, width, height) at time t; at infinity without the
        seed, at the end of all other motion."""
        mi, film = self.mi, self.film
        x0, y0, wide, high = window
        fov = float(
            np.degrees(2 * np.arctan(WIDE * film.mm_per_px / 2 / film.distance_mm))
        )
        target = self.eye + np.array([0.0, 0.0, 100.0])
        camera = {
            "type": "perspective",
            "fov": fov,
            "fov_axis": "x",
            "near_clip": 5.0,
            "far_clip": 1e5,
            "to_world": mi.ScalarTransform4f().look_at(
                origin=self.eye.tolist(), target=target.tolist(), up=[0, 1, 0]
            )
            @ mi.ScalarTransform4f().scale([-1, 1, 1]),
            "film": {
                "type": "hdrfilm",
                "width": WIDE,
                "height": HIGH,
                "crop_offset_x": x0,
                "crop_offset_y": y0,
                "crop_width": wide,
                "crop_height": high,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
            },
            "sampler": {"type": "multijitter", "sample_count": samples, "seed": 5},
        }
        scene = {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 4},
            "camera": camera,
            "wall": self.wall,
            **self.light,
        }
        scene |= self._plate(0.0 if math.isinf(t) else t)
        if film.rig == "drop":
            scene |= self._tweezers(t)
        if not math.isinf(t):
            scene["seed"] = self._seed(t)
        return np.array(mi.render(mi.load_dict(scene), seed=5))[..., :3].astype(float)

    def _seed(self, t: float):
        x, y, z, turn = (float(v[0]) for v in self.film.place(np.array([t])))
        c, s = math.cos(turn), math.sin(turn)
        rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        a, b = self.film.axes_mm
        if self.film.boxy:
            matrix = np.eye(4)
            matrix[:3, :3], matrix[:3, 3] = rotation * [a, b, b], (x, y, z)
            to_world = self.mi.ScalarTransform4f(matrix.astype(np.float32))
            return self.mi.load_dict(
                {"type": "cube", "to_world": to_world, "bsdf": self.seed_bsdf}
            )
        points, faces = self.ball
        normals = points / [a, b, b]
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return self._mesh(
            points * [a, b, b] @ rotation.T + [x, y, z],
            faces,
            self.seed_bsdf,
            normals @ rotation.T,
        )

    def _mesh(
        self,
        points: np.ndarray,
        faces: np.ndarray,
        bsdf,
        normals: np.ndarray | None = None,
    ):
        mi = self.mi
        props = mi.Properties()
        props["bsdf"] = bsdf
        mesh = mi.Mesh(
            "mesh",
            len(points),
            len(faces),
            has_vertex_normals=normals is not None,
            props=props,
        )
        values = mi.traverse(mesh)
        values["vertex_positions"] = points.ravel().astype(np.float32)
        if normals is not None:
            values["vertex_normals"] = normals.ravel().astype(np.float32)
        values["faces"] = faces.ravel().astype(np.uint32)
        values.update()
        return mesh

    def _plate(self, t: float) -> dict:
        """The ground's line as a board PLATE_DEEP_MM to either side of the plane of
        motion, 5 mm thick."""
        line = np.array(self.film.ground, float)
        if self.film.tilt is not None:
            c, s = math.cos(self.film.tilt(t)), math.sin(self.film.tilt(t))
            line = line @ np.array([[c, s], [-s, c]])
        deep = 12.0 if self.film.tilt is not None else PLATE_DEEP_MM
        under = line - [0, 5.0]
        points = np.concatenate(
            [np.c_[p, np.full(len(p), z)] for p in (line, under) for z in (-deep, deep)]
        )
        n = len(line)
        quads = []
        for k in range(n - 1):
            low = 2 * n + k
            quads += [
                (k, k + 1, n + k + 1, n + k),
                (low, low + n, low + n + 1, low + 1),
                (k, low, low + 1, k + 1),
            ]
        faces = np.array(
            [(q[0], q[1], q[2]) for q in quads] + [(q[0], q[2], q[3]) for q in quads]
        )
        return {"plate": self._mesh(points, faces, self.plate_bsdf)}

    def _tweezers(self, t: float) -> dict:
        """Two fingers that open when they let go, and stay."""
        x, y, *_ = (float(v[0]) for v in self.film.place(np.zeros(1)))
        gap = self.film.axes_mm[0] + 10 * min(
            max(t - self.film.let_go_s + 0.005, 0) / 0.05, 1
        )
        skin = plain_surface(self.mi, [0.6, 0.35, 0.25])
        return {
            f"finger{side}": box(
                self.mi, [x + side * (gap + 2.5), y + 8, 0], [2.5, 12, 3], skin
            )
            for side in (-1, 1)
        }


def _clutter(rng: np.random.Generator) -> np.ndarray:
    """A shelf full of things, as a picture in linear light."""
    picture = np.full((768, 768, 3), 0.25) * rng.uniform(0.5, 1.2, 3)
    for _ in range(140):
        box = cv2.boxPoints(
            (
                tuple(rng.uniform(0, 768, 2)),
                tuple(rng.uniform(10, 110, 2)),
                float(rng.uniform(0, 180)),
            )
        )
        cv2.fillConvexPoly(
            picture, box.astype(np.int32), tuple(rng.uniform(0.02, 0.6, 3)), cv2.LINE_AA
        )
    return cv2.GaussianBlur(picture, (0, 0), 1.5)


def seen_window(film: Film, times: np.ndarray) -> tuple[int, int, int, int]:
    """All that the seed, its near shadow and its mirror image may change at these
    times: column, row, width, height."""
    x, y, z, _ = film.place(times)
    size = film.distance_mm / (film.distance_mm + z)
    level, side = (
        (film.corner_px[1] - HIGH / 2) * film.mm_per_px,
        (WIDE / 2 - film.corner_px[0]) * film.mm_per_px,
    )
    column = WIDE / 2 + (x - side) * size / film.mm_per_px
    row = HIGH / 2 - (y - level) * size / film.mm_per_px
    reach = 1.3 * max(film.axes_mm) / film.mm_per_px + 4
    x0, x1, y0, y1 = (
        column.min() - reach,
        column.max() + reach,
        row.min() - reach,
        row.max() + reach,
    )
    ground = HIGH / 2 - (film.surface(x) - level) * size / film.mm_per_px
    height = float((y - film.surface(x)).min())
    if film.tilt is None and height < 5 * max(
        film.axes_mm
    ):  # shadow and mirror image on the plate
        wide = (height + 3 * max(film.axes_mm)) / film.mm_per_px
        x0, x1, y1 = (
            min(x0, column.min() - wide),
            max(x1, column.max() + wide),
            max(y1, ground.max() + 0.6 * wide),
        )
    if film.rig == "drop" and times[0] < film.let_go_s + 0.05:
        x0, x1, y0 = (
            x0 - 18 / film.mm_per_px,
            x1 + 18 / film.mm_per_px,
            y0 - 20 / film.mm_per_px,
        )
    if film.tilt is not None:
        rise = (
            film.ground[-1][0] * math.sin(film.tilt(times[-1])) + 25
        ) / film.mm_per_px
        x0, x1, y0, y1 = (
            20,
            60 + film.ground[-1][0] / film.mm_per_px,
            film.corner_px[1] - rise,
            film.corner_px[1] + 25,
        )
    left, top = int(np.clip(x0, 0, WIDE - 8)), int(np.clip(y0, 0, HIGH - 8))
    return (
        left,
        top,
        max(int(np.clip(x1, 0, WIDE)) - left, 8),
        max(int(np.clip(y1, 0, HIGH)) - top, 8),
    )


def linear_frame(stage: Stage, t: float, readout: float, exposure: float) -> np.ndarray:
    """One frame in linear light: the mean of the instants that each row is exposed
    to."""
    film = stage.film
    window = seen_window(film, np.linspace(t, t + readout + exposure, 25))
    x0, y0, wide, high = window
    # The rows that the seed itself is in, for whose times the instants are chosen.
    own = seen_row(film, t + readout / 2 + exposure / 2) / HIGH * readout
    slack = 1.5 * max(film.axes_mm) / film.mm_per_px / HIGH * readout
    moves = film.rig != "slide"
    first, last = t + own - slack, t + own + slack + exposure
    still = (
        np.ptp(np.array(film.place(np.array([first, last]))), axis=1)[:3].max()
        < 0.002 * film.mm_per_px
    )
    count = 1 if still else INSTANTS if moves else 3
    instants = first + (np.arange(count) + 0.5) / count * (last - first)
    samples = SAMPLES if count > 1 else 2 * SAMPLES
    begin = t + readout * (y0 + np.arange(high)) / HIGH
    inside = (
        (instants >= begin[:, None]) & (instants <= begin[:, None] + exposure)
    ).astype(float)
    off = np.abs(instants - begin[:, None] - exposure / 2)
    nearest = off == off.min(axis=1, keepdims=True)
    weight = np.where(inside.any(axis=1, keepdims=True), inside, nearest)
    weight /= weight.sum(axis=1, keepdims=True)
    picture = stage.still.copy()
    if film.tilt is None:
        change = -stage.shot(math.inf, window, samples)
        picture[y0 : y0 + high, x0 : x0 + wide] += change
    else:
        picture[y0 : y0 + high, x0 : x0 + wide] = 0
    for k, instant in enumerate(instants):
        picture[y0 : y0 + high, x0 : x0 + wide] += weight[
            :, k, None, None
        ] * stage.shot(float(instant), window, samples)
    return picture


def seen_row(film: Film, t: float) -> float:
    _, y, z, _ = film.place(np.array([t]))
    level = (film.corner_px[1] - HIGH / 2) * film.mm_per_px
    return float(
        np.clip(
            HIGH / 2
            - (y[0] - level)
            * film.distance_mm
            / (film.distance_mm + z[0])
            / film.mm_per_px,
            0,
            HIGH,
        )
    )


def draw(film: Film, look: str, rng: np.random.Generator, path: Path) -> None:
    """Write the film as H.264."""
    import drjit
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    drjit.set_thread_count(1)
    stage = Stage(film, look, rng)
    readout, exposure = (
        rng.uniform(0.002, min(0.015, 0.95 / film.fps)),
        rng.uniform(0.1, 0.8) / film.fps,
    )
    x0, y0, wide, high = seen_window(film, np.zeros(1))
    near = stage.shot(0.0, (x0, y0, wide, high), SAMPLES)
    gain, blur = (
        0.8 / max(np.percentile(stage.still, 97), np.percentile(near, 97)),
        float(rng.uniform(0.4, 0.9)),
    )
    quality, cache = int(rng.integers(18, 26)), dict[Any, np.ndarray]()

    def frames() -> Iterator[np.ndarray]:
        for n in range(int(film.lasts_s * film.fps)):
            t = n / film.fps
            at = np.array(film.place(np.array([t, t + readout + exposure])))
            rests = (
                film.tilt is None
                and np.ptp(at, axis=1).max() == 0
                and t > film.let_go_s + 0.06
            ) or t + 0.02 < film.let_go_s
            key = tuple(np.round(at[:, 0], 9)) if rests else n
            if key not in cache:
                cache.clear()
                cache[key] = cv2.GaussianBlur(
                    linear_frame(stage, t, readout, exposure), (0, 0), blur
                )
            light = np.clip(gain * cache[key], 0, None)
            light = np.clip(
                light + rng.standard_normal(light.shape) * np.sqrt(3e-4 * light + 1e-5),
                0,
                1,
            )
            yield (255 * srgb(light) + 0.5).astype(np.uint8)

    write_h264(path, film.fps, quality, frames())


def study(
    folder: Path, count: int, seed: int, rigs: list[str], drawn_only: bool
) -> None:
    truth = []
    for k in range(count):
        for rig in rigs:
            rng = np.random.default_rng([seed, RIGS.index(rig), k])
            film, look = DRAWN[rig](rng), LOOKS[k % len(LOOKS)]
            film.fps = min(film.fps, MOST_FPS)
            name = f"{rig}-{seed}-{k + 1:02d}"
            if not (folder / name / "recording.toml").exists():
                write(film, look, rng, folder / name, draw)
            truth += [(name, rig, look, q, v) for q, v in film.truth.items()]
    table = pd.DataFrame(
        truth, columns=["recording", "rig", "look", "quantity", "truth"]
    )
    if drawn_only:
        return
    table.to_csv(folder / "truth.csv", index=False)
    report(table.merge(found_in(folder), how="left", on=["recording", "quantity"]))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="where the films lie and stay")
    parser.add_argument("--n", type=int, default=6, help="films a rig")
    parser.add_argument(
        "--rng",
        type=int,
        default=1,
        help="start of the random numbers; another set is another number",
    )
    parser.add_argument("--rigs", nargs="+", choices=RIGS, default=list(RIGS))
    parser.add_argument(
        "--draw-only",
        action="store_true",
        help="draw the films that are missing, measure none",
    )
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    arguments.folder.mkdir(parents=True, exist_ok=True)
    study(
        arguments.folder,
        arguments.n,
        arguments.rng,
        arguments.rigs,
        arguments.draw_only,
    )
