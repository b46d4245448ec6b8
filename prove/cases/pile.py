"""Heaps in photos: two flanks on a plate, drawn from a profile that each effect bends in its own way, under a skin of grains.

No grains are simulated: an effect is put in as it shows. cohesion: the crest's top so many mm higher than the flanks' line, on a
length that does not grow with the heap, and a toe cut short. wall-friction: the flanks bow out by so many mm. gate-speed:
rounder crest and longer toe. base-vibration: the same, more in each later photo. base-tilt: plate and heap's foot turned [deg],
the flanks not, rising along +x. particle-shape: flanks bow in and the skin is rougher. camera-roll: all turned, clockwise
positive. layered (outside): the flank breaks half way up.
"""

from dataclasses import dataclass

import numpy as np

from prove.cases.noise import Noise
from prove.cases.snr import Channel, Visible, track_snr
from prove.cases.truth import Bench, Made, Wish, spread

RANGES = {
    "cohesion": (0.3, 25.0, 1), "wall-friction": (0.2, 10.0, 1), "gate-speed": (0.3, 25.0, 1), "base-vibration": (0.2, 20.0, 1),
    "base-tilt": (0.1, 4.0, 0), "particle-shape": (0.2, 7.0, 1), "camera-roll": (0.1, 6.0, 0), "layered": (0.3, 12.0, 0),
}  # fmt: skip
SEPARATED = ("cohesion",)
PHOTOS = 3
PLUMB_SD_DEG, SKIN = 0.05, 0.22  # skin: sd of the surface, of a grain's diameter
PILE, PLATE, GROUND, GREY_SD = 200.0, 95.0, 38.0, 2.0


@dataclass(frozen=True)
class Run:
    half_mm: float  # of the base
    angle_off_deg: float
    round_mm: float
    toe_mm: float
    noise_seed: int


@dataclass(frozen=True)
class Scene:
    runs: tuple[Run, ...]
    angle_deg: float
    grain_mm: float
    roll_off_deg: float
    mm_per_px: float
    wish: Wish


def draw(wish: Wish, rng: np.random.Generator) -> Scene:
    several = wish.separated or rng.random() < 0.4
    halves, grain = ((45.0, 80.0) if several else (75.0,)), float(rng.uniform(2.0, 4.0))
    runs = tuple(
        Run(halves[i % len(halves)] * (1 + rng.normal(0, 0.02)), rng.normal(0, 0.6), grain * spread(0.8, 1.2, rng) * 1.5,
            grain * spread(0.8, 1.2, rng) * 2, int(rng.integers(2**62)))
        for i in range(int(rng.integers(5, 9)))
    )  # fmt: skip
    return Scene(
        runs, rng.uniform(22, 33), round(grain, 2), rng.normal(0, PLUMB_SD_DEG), round(float(rng.uniform(0.3, 0.4)), 3), wish
    )


def profile(x: np.ndarray, scene: Scene, run: Run, sizes: dict[str, float], photo: int, angle_more: float = 0.0) -> np.ndarray:
    """Height of the heap's skin [mm] at x [mm] from its middle; the plate's where there is none."""
    plate = np.tan(np.radians(sizes.get("base-tilt", 0.0))) * x
    steep = np.tan(np.radians(scene.angle_deg + run.angle_off_deg + angle_more))
    shaken = sizes.get("base-vibration", 0.0) * (1 + photo) / PHOTOS
    rounding = run.round_mm + sizes.get("gate-speed", 0.0) + shaken
    toe = run.toe_mm + sizes.get("gate-speed", 0.0) + shaken
    height = run.half_mm * steep
    line = height - steep * (np.sqrt(x**2 + rounding**2) - 0.3 * rounding)
    up = np.clip(line / height, 0, 1)
    bow = sizes.get("wall-friction", 0.0) - sizes.get("particle-shape", 0.0)
    line = line + bow * np.sin(np.pi * up) + sizes.get("layered", 0.0) * (up * (up < 0.5) + (1 - up) * (up >= 0.5)) * 2
    stuck = sizes.get("cohesion", 0.0)
    if stuck:
        line = line + stuck * np.exp(-np.abs(x) / (3 * stuck + 2 * scene.grain_mm))
        toe = toe / (1 + stuck / scene.grain_mm)
    return plate + toe * steep * np.logaddexp(0, np.clip((line - plate) / (toe * steep), -50, 500))


def skin(
    x: np.ndarray, height: np.ndarray, plate: np.ndarray, scene: Scene, rough: float, rng: np.random.Generator
) -> np.ndarray:
    """Outline of the grains that lie under `height`, and the plate where there are none."""
    radius = scene.grain_mm / 2
    centres = np.arange(x[0], x[-1], 0.55 * scene.grain_mm)
    centres = centres + rng.uniform(-0.15, 0.15, len(centres)) * scene.grain_mm
    top = np.interp(centres, x, height) + rng.normal(0, rough * scene.grain_mm, len(centres))
    off = (x[:, None] - centres) / radius
    arcs = np.where(np.abs(off) < 1, top - radius + radius * np.sqrt(np.maximum(1 - off**2, 0)), -np.inf)
    arcs[:, np.interp(centres, x, height - plate) < 0.35 * scene.grain_mm] = -np.inf
    return np.maximum(arcs.max(axis=1), plate)


def photograph(scene: Scene, run: Run, sizes: dict[str, float], photo: int, rng: np.random.Generator) -> np.ndarray:
    """One photo (h, w) uint8."""
    pixel, wide = scene.mm_per_px, run.half_mm * 1.55 + 20
    tall = run.half_mm * np.tan(np.radians(scene.angle_deg + 6)) + sizes.get("cohesion", 0.0) + 22
    columns, rows = np.arange(-wide, wide, pixel), np.arange(tall, -14, -pixel)
    x, y = np.meshgrid(columns, rows)
    turn = np.radians(scene.roll_off_deg + sizes.get("camera-roll", 0.0))
    x, y = x * np.cos(turn) - y * np.sin(turn), y * np.cos(turn) + x * np.sin(turn)  # from the picture to the bench
    plate = np.tan(np.radians(sizes.get("base-tilt", 0.0)))
    rough = SKIN + 0.02 * sizes.get("particle-shape", 0.0)
    fine = np.arange(-wide - 15, wide + 15, pixel / 2)
    top = skin(fine, profile(fine, scene, run, sizes, photo), plate * fine, scene, rough, rng)
    heap = np.clip((np.interp(x, fine, top) - y) / pixel + 0.5, 0, 1)
    base = np.clip((plate * x - y) / pixel + 0.5, 0, 1)
    speckle = rng.normal(0, 1, (len(rows) // 6 + 2, len(columns) // 6 + 2)).repeat(6, 0).repeat(6, 1)[: len(rows), : len(columns)]
    picture = GROUND + heap * (PILE + 12 * speckle - GROUND)
    picture += base * (PLATE - picture)
    return np.clip(np.round(picture + GREY_SD * rng.standard_normal(picture.shape)), 0, 255).astype(np.uint8)


def visibility(scene: Scene, sizes: dict[str, float], name: str) -> float:
    """SNR of `name` in the world of all `sizes`, the skin taken for noise correlated over a grain."""
    recordings, without = [], {k: v for k, v in sizes.items() if k != name}
    grain = scene.grain_mm
    noise = Noise(SKIN * grain, float(np.exp(-scene.mm_per_px * 2 / grain)), 0.02, np.inf, 0, 1, 0)
    for run in scene.runs:
        x = np.arange(-run.half_mm, run.half_mm, scene.mm_per_px)
        channels = []
        for photo in range(PHOTOS):
            base = profile(x, scene, run, sizes, photo)
            change = base - profile(x, scene, run, without, photo) + _turned(x, sizes, name)
            rounder = profile(x, scene, Run(run.half_mm, run.angle_off_deg, run.round_mm * 1.1, run.toe_mm, 0), sizes, photo)
            longer = profile(x, scene, Run(run.half_mm, run.angle_off_deg, run.round_mm, run.toe_mm * 1.1, 0), sizes, photo)
            steeper = profile(x, scene, run, sizes, photo, 0.1)
            own = np.column_stack([np.ones_like(x), np.gradient(base, x), (steeper - base) / 0.1])
            shared = np.column_stack([np.radians(x), (rounder - base) / 0.1, (longer - base) / 0.1])
            channels.append(Channel(change, own, shared))
        # three photos of one heap show one skin, not three
        recordings.append(Visible(tuple(channels) if name == "base-vibration" else (channels[0],), np.full(3, np.inf)))
    return track_snr(recordings, np.array([PLUMB_SD_DEG, 0.3, 0.3]), noise)


def _turned(x: np.ndarray, sizes: dict[str, float], name: str) -> np.ndarray:
    if name == "camera-roll":
        return -np.radians(sizes[name]) * x
    return np.zeros_like(x)


def bench(scene: Scene, sizes: dict[str, float]) -> Bench:
    """The bench folder of a scene with these effects."""
    d = scene.grain_mm
    toml = {"provenance": "measured", "seed": {"length_mm": d, "width_mm": d, "thickness_mm": d, "density_kg_m3": 1250.0}}
    return Bench(toml, tuple(_recording(scene, sizes, i) for i in range(len(scene.runs))))


def _recording(scene: Scene, sizes: dict[str, float], i: int) -> Made:
    run, name = scene.runs[i], f"pile-{i + 1:02d}"
    toml = {
        "rig": "pile", "id": name, "session": "day-1",
        "camera": {"mm_per_px": scene.mm_per_px, "mm_per_px_sd": round(0.001 * scene.mm_per_px, 6), "plumb_deg": 0.0,
                   "plumb_sd_deg": PLUMB_SD_DEG},
        "pile": {"cylinder_mm": [round(0.9 * run.half_mm, 1), 200.0], "gate_speed_mm_s": 50.0},
    }  # fmt: skip
    # one heap photographed again: the same grains lie in its skin
    photos = tuple(photograph(scene, run, sizes, k, np.random.default_rng(run.noise_seed)) for k in range(PHOTOS))
    return Made(name, toml, photos=photos)
