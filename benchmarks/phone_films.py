"""Films as phones make them, drawn with known answers: how often are a bounce's restitution and a roll's run-out right?

A ball falls and bounces, or rolls down an incline and runs out, before a textured background: pale on pale, pale on dark or pale
on busy; with a shadow and a soft mirror image in the plate, light that falls off, exposure up to a whole frame, a rolling shutter,
sensor noise and H.264. A hand lets go and stays in some drops, somebody moves behind in some. Motion is integrated here in closed
form; nothing is shared with the code that measures.
"""

import argparse
import itertools
import tempfile
import time
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
import pandas as pd

from vision.batch import measure

G = 9806.65  # mm/s²
SUB, BANDS = 8, 12  # times within an exposure; bands of rows read one after the other
BACKGROUNDS = {"pale on pale": (185, 18), "pale on dark": (55, 12), "pale on busy": (120, 60)}  # mean grey, contrast of the texture


@dataclass(frozen=True)
class Scene:
    """One film. scale [px/mm]; radius [mm]; floor: the plate's row [px]; exposure, readout [s]."""

    rig: str
    background: str
    width: int
    height: int
    fps: float
    scale: float
    radius: float
    exposure: float
    readout: float
    floor: float
    hand: bool
    person: bool
    e: float = 0.5
    drop_mm: float = 0.0
    incline_deg: float = 0.0
    incline_mm: float = 0.0
    friction: float = 0.0


def drawn_scene(rig: str, rng: np.random.Generator) -> Scene:
    """A scene as benches have it."""
    fps = float(rng.choice([30, 60, 120, 240] if rig == "drop" else [30, 60]))
    width, height = (360, 640) if rig == "drop" else (960, 360)
    scale = float(rng.uniform(1.6, 2.2)) if rig == "drop" else float(rng.uniform(2.2, 3.0))
    return Scene(
        rig, str(rng.choice(list(BACKGROUNDS))), width, height, fps, scale, float(rng.uniform(3.3, 4.5)),
        float(rng.uniform(0.02, 0.6)) / fps, float(rng.uniform(0.002, min(0.015, 0.9 / fps))), height - float(rng.uniform(50, 80)),
        bool(rng.random() < 0.4), bool(rng.random() < 0.3), float(rng.uniform(0.45, 0.75)), float(rng.uniform(180, 250)),
        float(rng.uniform(8, 14)), float(rng.uniform(25, 45)), float(rng.uniform(0.035, 0.06)),
    )  # fmt: skip


def fall(scene: Scene, hold: float, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """x [mm] and height of the ball's lowest point [mm] of a drop let go after `hold` [s]."""
    t = np.maximum(np.asarray(t, float) - hold, 0.0)
    high, across = scene.drop_mm - G * t**2 / 2, np.zeros_like(t)
    begin, speed = np.sqrt(2 * scene.drop_mm / G), scene.e * np.sqrt(2 * G * scene.drop_mm)
    for _ in range(30):
        flying = t >= begin
        tau = t[flying] - begin
        high[flying] = speed * tau - G * tau**2 / 2
        begin, speed = begin + 2 * speed / G, scene.e * speed
        if speed < 10:
            high[t >= begin] = 0.0
            break
    return across + 12.0 * t, high


def roll(scene: Scene, hold: float, t: np.ndarray) -> np.ndarray:
    """Way along the path [mm] from the release: a solid ball, rolling friction μ: a = g (sin β − μ cos β)/1.4, −g μ/1.4."""
    beta, t = np.radians(scene.incline_deg), np.maximum(np.asarray(t, float) - hold, 0.0)
    down, level = G * (np.sin(beta) - scene.friction * np.cos(beta)) / 1.4, G * scene.friction / 1.4
    corner = np.sqrt(2 * scene.incline_mm / down)
    speed = down * corner
    on = np.minimum(t, corner)
    off = np.clip(t - corner, 0, speed / level)
    return down * on**2 / 2 + speed * off - level * off**2 / 2


def run_out(scene: Scene) -> float:
    beta = np.radians(scene.incline_deg)
    return float(scene.incline_mm * (np.sin(beta) - scene.friction * np.cos(beta)) / scene.friction)


def place(scene: Scene, hold: float, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The ball's centre [px], x to the right, y down."""
    if scene.rig == "drop":
        x, high = fall(scene, hold, t)
        return 0.45 * scene.width + scene.scale * x, scene.floor - scene.scale * (high + scene.radius)
    s, beta = roll(scene, hold, t) - scene.incline_mm, np.radians(scene.incline_deg)
    x = np.where(s < 0, s * np.cos(beta), s)
    y = np.where(s < 0, -s * np.sin(beta), 0.0) + scene.radius
    return 0.12 * scene.width + scene.scale * (x + scene.incline_mm), scene.floor - scene.scale * y


def texture(shape: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
    """Noise of several grain sizes, of unit contrast."""
    out = np.zeros(shape, np.float32)
    for size in (2, 6, 20, 60):
        small = rng.normal(0, 1, (shape[0] // size + 2, shape[1] // size + 2)).astype(np.float32)
        out += cv2.resize(small, (shape[1], shape[0]), interpolation=cv2.INTER_CUBIC)
    return out / out.std()


def background(scene: Scene, rng: np.random.Generator) -> np.ndarray:
    """Wall and plate, (h, w, 3) float."""
    mean, contrast = BACKGROUNDS[scene.background]
    rows, columns = np.mgrid[: scene.height, : scene.width].astype(np.float32)
    light = 1 + 0.15 * (columns / scene.width - 0.5) - 0.1 * (rows / scene.height - 0.5)
    wall = mean + 0.5 * contrast * texture((scene.height, scene.width), rng)
    plate = 0.85 * mean + 15 + 0.2 * contrast * texture((scene.height, scene.width), rng)
    surface = np.full(scene.width, scene.floor)
    if scene.rig == "roll":
        corner = 0.12 * scene.width + scene.scale * scene.incline_mm
        along = np.arange(scene.width) - corner
        surface = np.where(along < 0, scene.floor + along * np.tan(np.radians(scene.incline_deg)), scene.floor)
        surface[: int(0.02 * scene.width)] = scene.floor
    below = np.clip(rows - surface[None, :], 0, 1)
    grey = (wall * (1 - below) + plate * below) * light
    return np.clip(grey[..., None] * np.array([0.97, 1.0, 1.03], np.float32), 0, 250)


def disc(shape: tuple[int, int], x: float, y: float, r: float) -> tuple[tuple[slice, slice], np.ndarray, np.ndarray]:
    """Where a ball lies, its cover and its shading there."""
    a, b = max(int(x - r - 2), 0), min(int(x + r + 3), shape[1])
    c, d = max(int(y - r - 2), 0), min(int(y + r + 3), shape[0])
    rows, columns = np.mgrid[c:max(c, d), a:max(a, b)].astype(np.float32)
    u, v = (columns - x) / r, (rows - y) / r
    away = np.hypot(u, v)
    cover = np.clip((1 - away) * r + 0.5, 0, 1)
    depth = np.sqrt(np.clip(1 - away**2, 0, 1))
    return (slice(c, max(c, d)), slice(a, max(a, b))), cover, 0.5 + 0.5 * np.clip(0.75 * depth - 0.55 * v - 0.3 * u, 0, 1.2)


def one_frame(scene: Scene, behind: np.ndarray, hold: float, t: float, colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A frame that begins at t: each band of rows exposed later than the one above."""
    r, out = scene.scale * scene.radius, behind.copy()
    edges = np.linspace(0, scene.height, BANDS + 1).astype(int)
    for band, (top, foot) in enumerate(itertools.pairwise(edges)):
        begin = t + scene.readout * (band + 0.5) / BANDS
        x, y = place(scene, hold, begin + scene.exposure * (np.arange(SUB) + 0.5) / SUB)
        if (y.max() + 3 * r < top and y.max() + r < scene.floor - 3 * r) or y.min() - 2 * r > foot:
            continue
        piece = np.zeros_like(behind)
        for column, row in zip(x, y):
            part = behind.copy() if SUB == 1 else behind
            piece += _with_ball(scene, part, float(column), float(row), r, colour)
        out[top:foot] = piece[top:foot] / SUB
    return np.clip(out + rng.normal(0, 3.0, out.shape), 0, 255).astype(np.uint8)


def _with_ball(scene: Scene, behind: np.ndarray, x: float, y: float, r: float, colour: np.ndarray) -> np.ndarray:
    out = behind.copy()
    over = max(scene.floor - y - r, 0.0) if scene.rig == "drop" else 0.0
    foot = y + r + over
    region, cover, _ = disc(out.shape[:2], x + 0.3 * over + 0.3 * r, foot + 0.25 * r, 1.2 * r)  # the shadow on the plate
    below = np.clip(np.arange(region[0].start, region[0].stop) - foot, 0, 1)[:, None]
    out[region] *= 1 - (0.35 * np.exp(-over / (6 * r)) * cover * below)[..., None]
    region, cover, light = disc(out.shape[:2], x, 2 * foot - y, r)  # its mirror image
    below = np.clip(np.arange(region[0].start, region[0].stop) - foot, 0, 1)[:, None]
    weight = (0.18 * cover * below)[..., None]
    out[region] = out[region] * (1 - weight) + weight * light[..., None] * colour
    region, cover, light = disc(out.shape[:2], x, y, r)
    out[region] = out[region] * (1 - cover[..., None]) + cover[..., None] * light[..., None] * colour
    return out


def film(scene: Scene, folder: Path, rng: np.random.Generator) -> None:
    """Draw the film and its recording.toml."""
    folder.mkdir(parents=True)
    behind, hold = background(scene, rng), float(rng.uniform(0.25, 0.4))
    colour = np.array([235, 222, 190], np.float32) * (0.9 if scene.background == "pale on pale" else 1.0)
    if scene.rig == "drop":
        end = hold + np.sqrt(2 * scene.drop_mm / G) * (1 + 2 * scene.e + 2 * scene.e**2 + 2 * scene.e**3)
    else:
        beta = np.radians(scene.incline_deg)
        down = G * (np.sin(beta) - scene.friction * np.cos(beta)) / 1.4
        corner = np.sqrt(2 * scene.incline_mm / down)
        end = hold + corner + down * corner / (G * scene.friction / 1.4) + 0.4
    with av.open(str(folder / "film.mp4"), "w") as container:
        stream = container.add_stream("libx264", rate=Fraction(scene.fps).limit_denominator(1000))
        stream.width, stream.height, stream.pix_fmt = scene.width, scene.height, "yuv420p"
        stream.options = {"crf": "20"}
        for n in range(int(end * scene.fps) + 1):
            t = n / scene.fps
            seen = _people(scene, behind, t, hold)
            picture = av.VideoFrame.from_ndarray(one_frame(scene, seen, hold, t, colour, rng), format="rgb24")
            container.mux(stream.encode(picture))
        container.mux(stream.encode())
    known = 1 / scene.scale * float(rng.normal(1, 0.002))
    own = {
        "drop": f"[drop]\nheight_mm = {scene.drop_mm + rng.normal(0, 0.5):.1f}\n",
        "roll": f"[roll]\nincline_deg = {scene.incline_deg:.1f}\nincline_length_mm = {scene.incline_mm:.1f}\ndirection = \"+x\"\n",
    }[scene.rig]
    sizes = "".join(f"{axis}_mm = {2 * scene.radius:.2f}\n" for axis in ("length", "width", "thickness"))
    camera = f"fps = {scene.fps}\nmm_per_px = {known:.5f}\nmm_per_px_sd = {0.002 / scene.scale:.5f}\n"
    (folder / "recording.toml").write_text(f'rig = "{scene.rig}"\n[seed]\n{sizes}[camera]\n{camera}{own}')


def _people(scene: Scene, behind: np.ndarray, t: float, hold: float) -> np.ndarray:
    """A hand at the release that opens and draws back, somebody who walks by behind."""
    if not (scene.hand or scene.person):
        return behind
    out = behind.astype(np.uint8).copy()
    if scene.person:
        at = (int(scene.width * (0.8 + 0.15 * np.sin(2.1 * t))), int(0.45 * scene.height))
        size = (int(0.05 * scene.width), int(0.3 * scene.height))
        cv2.ellipse(out, at, size, 0, 0, 360, (70, 60, 90), -1, cv2.LINE_AA)
    if scene.hand:
        x, y = place(scene, hold, np.array([0.0]))
        gone = 25 * scene.scale * min(max(t - hold, 0.0) / 0.3, 1.0)
        away = (int(x[0] - 14 * scene.scale - gone), int(y[0] - 6 * scene.scale))
        cv2.ellipse(out, away, (int(11 * scene.scale), int(5 * scene.scale)), 20, 0, 360, (215, 170, 150), -1, cv2.LINE_AA)
    return out.astype(np.float32)


def truths(scene: Scene) -> dict[str, float]:
    """Quantities by name; a bounce's restitution as bounce 1, 2, 3."""
    if scene.rig == "drop":
        return {"restitution": scene.e, "bounce 1": scene.e, "bounce 2": scene.e, "bounce 3": scene.e}
    return {"run_out": run_out(scene)}


def scored(folder: Path, scenes: dict[str, Scene]) -> pd.DataFrame:
    """A row a quantity: what was found beside the truth."""
    rows = []
    for observation in measure(folder):
        scene = scenes[observation.recording]
        found = {q.name: (q.value, q.sd, q.quality, q.reason) for q in observation.quantities}
        if observation.bounces is not None:
            for b in observation.bounces.itertuples():
                found[f"bounce {b.bounce}"] = (b.restitution, b.restitution_sd, getattr(b, "quality", "good"), "")
        for name, truth in truths(scene).items():
            value, sd, quality, reason = found.get(name, (np.nan, np.nan, "none", "; ".join(q.reason for q in observation.quantities[:1])))
            rows.append((observation.recording, scene.rig, scene.background, scene.fps, name, truth, value, sd, quality, reason))
    columns = ["film", "rig", "background", "fps", "quantity", "truth", "value", "sd", "quality", "reason"]
    return pd.DataFrame(rows, columns=columns)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--n", type=int, default=12, help="films of each rig")
    options.add_argument("--rng", type=int, default=1)
    options.add_argument("--keep", type=Path, help="folder for the films; else they are thrown away")
    options.add_argument("--table", type=Path, help="write every quantity into this .csv")
    asked = options.parse_args()
    with tempfile.TemporaryDirectory() as place_:
        folder = asked.keep or Path(place_)
        scenes = {}
        for rig in ("drop", "roll"):
            for k in range(asked.n):
                rng = np.random.default_rng([asked.rng, k, len(rig) + ord(rig[0])])
                name = f"{rig}-{k:02d}"
                scenes[name] = drawn_scene(rig, rng)
                if not (folder / name).exists():
                    film(scenes[name], folder / name, rng)
        began = time.perf_counter()
        table = scored(folder, scenes)
        took = time.perf_counter() - began
    if asked.table:
        table.to_csv(asked.table, index=False)
    table["z"] = (table["value"] - table["truth"]) / table["sd"]
    print(f"{'':14}{'n':>4}{'found':>7}{'good':>6}{'in 95 %':>9}{'good, wrong':>13}{'rms error':>11}")
    for (rig, name), rows in table.groupby(["rig", "quantity"]):
        there = rows[np.isfinite(rows["value"])]
        held, good = there["z"].abs() < 1.96, there["quality"] == "good"
        error = float(np.sqrt(np.mean((there["value"] - there["truth"]) ** 2))) if len(there) else np.nan
        wrong = int((good & (there["z"].abs() > 3)).sum())
        print(f"{rig} {name:9}{len(rows):4}{len(there):7}{int(good.sum()):6}{100 * held.mean():8.0f}%{wrong:13}{error:11.4f}")
    print(f"{took:.0f} s for {len(scenes)} films")


if __name__ == "__main__":
    main()
