"""Heaps in photos: two flanks on a plate, drawn from a profile that each effect bends
in its own way, under a skin of grains.

No grains are simulated: an effect is put in as it shows. cohesion: the crest's top so
many mm higher than the flanks' line, on a length that does not grow with the heap, and
a toe cut short. wall-friction: the flanks bow out by so many mm. gate-speed: rounder
crest and longer toe by so many mm where 50 mm/s are stated, in proportion to what is.
base-vibration: the same, more in each later photo. base-tilt: plate and heap's foot
turned [deg], the flanks not, clockwise. particle-shape: flanks bow in and the
skin is rougher. camera-roll: all turned, clockwise positive. layered (outside): the
flank breaks half way up."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from benchtwin.prove.cases.bench import Bench, Recording, Request, log_uniform
from benchtwin.prove.cases.noise import Noise
from benchtwin.prove.cases.record import Cases, Effect
from benchtwin.prove.cases.snr import Channel, RecordingChange, Visibility, fitted
from benchtwin.prove.cases.stated import (
    PLUMB,
    UNSTATED_PLUMB_SD_DEG,
    camera_keys,
    known_plumb_deg,
)

EFFECTS = {
    "cohesion": Effect(("crest", "toe"), None, 0.3, 10.0),
    "wall-friction": Effect(("middle",), None, 0.2, 10.0),
    "gate-speed": Effect(("toe", "crest"), None, 0.3, 25.0),
    "base-vibration": Effect(("toe", "crest"), None, 0.2, 20.0),
    "base-tilt": Effect(("measurement",), "deg", 0.1, 4.0, 0),
    "particle-shape": Effect(("middle",), None, 0.2, 7.0),
    "camera-roll": Effect(("measurement",), "deg", 0.1, 6.0, 0),
    "layered": Effect(("middle",), None, 0.3, 12.0, 0, listed=False),
}
PHOTOS = 3
GATE_MM_S, GATES = 50.0, (25.0, 100.0)
# rounding and toe grow by themselves as a power of the gate's speed, by that much
GATE_POWER_SD = 0.1
# What is known of a sound heap before it is seen: how far one material's crest and toe
# (share of the height; of a grain) and its bow lie from another's; log of rounding and
# toe from heap to heap; what a gate e times as fast does to crest and toe where it does
# next to nothing; how heaps settle between photos [deg; crest and toe, mm].
KNOWN_ENDS = (0.03, 0.25)
KNOWN_BOW = (0.01, 0.05)
PACKING_LOG_SD = float(np.log(1.5) / np.sqrt(12))
KNOWN_GATE, SETTLING_DEG, SETTLING_MM = 0.01, 0.1, 0.15
# angle: of heaps alike; for e times the size, the gate
PACKING_DEG = 0.6
SIZE_DEG = 1.5
GATE_DEG = 0.4
HALF_MM = 60.0
# of the skin's noise is left between two photos of one heap: the same grains lie in it
REGISTERED = 0.1
PLUMB_SD_DEG, SKIN = 0.05, 0.22  # skin: sd of the surface, of a grain's diameter
PILE, PLATE, GROUND, GREY_SD = 200.0, 95.0, 38.0, 2.0


@dataclass(frozen=True)
class Run:
    """One pile: its shape, and the seed numbers of its noise."""

    half_mm: float  # of the base
    angle_off_deg: float
    round_mm: float
    toe_mm: float
    noise_seed: int
    gate_mm_s: float = GATE_MM_S


@dataclass(frozen=True)
class Scene:
    """The piles of one case, and the camera that saw them."""

    runs: tuple[Run, ...]
    angle_deg: float
    grain_mm: float
    roll_off_deg: float
    mm_per_px: float
    request: Request
    gate_power: float = 0.0
    gate_deg: float = 0.0  # flatter by itself where the gate is e times as fast


def draw(request: Request, rng: np.random.Generator) -> Scene:
    """A scene of the requested effects: heaps, their camera, and what is stated of
    them."""
    gates = request.separated and "gate-speed" in request.effects
    several = (request.separated and not gates) or rng.random() < 0.4
    halves, grain = ((45.0, 80.0) if several else (75.0,)), float(rng.uniform(2.0, 4.0))
    runs = tuple(
        Run(
            halves[i % len(halves)] * (1 + rng.normal(0, 0.02)),
            rng.normal(0, PACKING_DEG),
            grain * log_uniform(0.8, 1.2, rng) * 1.5,
            grain * log_uniform(0.8, 1.2, rng) * 2,
            int(rng.integers(2**62)),
        )
        for i in range(int(rng.integers(5, 9)))
    )
    plumb_sd = UNSTATED_PLUMB_SD_DEG if set(PLUMB) & request.absent else PLUMB_SD_DEG
    scene = Scene(
        runs,
        rng.uniform(22, 33),
        round(grain, 2),
        rng.normal(0, plumb_sd),
        round(float(rng.uniform(0.3, 0.4)), 3),
        request,
        rng.normal(0, GATE_POWER_SD),
        abs(rng.normal(0, GATE_DEG)),
    )
    if not (
        gates or (request.separated is None and not several and rng.random() < 0.3)
    ):
        return scene
    return replace(
        scene,
        runs=tuple(
            replace(run, gate_mm_s=GATES[i % len(GATES)]) for i, run in enumerate(runs)
        ),
    )


def profile(
    x: np.ndarray, scene: Scene, run: Run, sizes: dict[str, float], photo: int
) -> np.ndarray:
    """Height of the heap's skin [mm] at x [mm] from its middle; the plate's where there
    is none."""
    plate = -np.tan(np.radians(sizes.get("base-tilt", 0.0))) * x
    faster = run.gate_mm_s / GATE_MM_S
    lower = scene.gate_deg * np.log(faster)
    steep = np.tan(np.radians(scene.angle_deg + run.angle_off_deg - lower))
    shaken = sizes.get("base-vibration", 0.0) * (1 + photo) / PHOTOS
    longer = faster * sizes.get("gate-speed", 0.0) + shaken
    rounding = run.round_mm * faster**scene.gate_power + longer
    toe = run.toe_mm * faster**scene.gate_power + longer
    height = run.half_mm * steep
    line = height - steep * (np.sqrt(x**2 + rounding**2) - 0.3 * rounding)
    up = np.clip(line / height, 0, 1)
    bow = sizes.get("wall-friction", 0.0) - sizes.get("particle-shape", 0.0)
    line = (
        line
        + bow * np.sin(np.pi * up)
        + sizes.get("layered", 0.0) * (up * (up < 0.5) + (1 - up) * (up >= 0.5)) * 2
    )
    stuck = sizes.get("cohesion", 0.0)
    if stuck:
        line = line + stuck * np.exp(-np.abs(x) / (3 * stuck + 2 * scene.grain_mm))
        toe = toe / (1 + stuck / scene.grain_mm)
    return plate + toe * steep * np.logaddexp(
        0, np.clip((line - plate) / (toe * steep), -50, 500)
    )


def skin(
    x: np.ndarray,
    height: np.ndarray,
    plate: np.ndarray,
    scene: Scene,
    rough: float,
    rng: np.random.Generator,
) -> np.ndarray:
    """Outline of the grains that lie under `height`, and the plate where there are
    none."""
    radius = scene.grain_mm / 2
    centres = np.arange(x[0], x[-1], 0.55 * scene.grain_mm)
    centres = centres + rng.uniform(-0.15, 0.15, len(centres)) * scene.grain_mm
    top = np.interp(centres, x, height) + rng.normal(
        0, rough * scene.grain_mm, len(centres)
    )
    off = (x[:, None] - centres) / radius
    rise = np.sqrt(np.maximum(1 - off**2, 0))
    arcs = np.where(np.abs(off) < 1, top - radius + radius * rise, -np.inf)
    arcs[:, np.interp(centres, x, height - plate) < 0.35 * scene.grain_mm] = -np.inf
    return np.maximum(arcs.max(axis=1), plate)


def photograph(
    scene: Scene, run: Run, sizes: dict[str, float], photo: int
) -> np.ndarray:
    """One photo (h, w) uint8: in all photos of one heap the same grains lie in its
    skin, the camera's noise is each one's own."""
    rng = np.random.default_rng(run.noise_seed)
    camera = np.random.default_rng([run.noise_seed, photo])
    pixel, wide = scene.mm_per_px, _width_mm(scene, run, sizes, photo)
    tall = (
        run.half_mm * np.tan(np.radians(scene.angle_deg + 6))
        + sizes.get("cohesion", 0.0)
        + 22
    )
    columns, rows = np.arange(-wide, wide, pixel), np.arange(tall, -14, -pixel)
    x, y = np.meshgrid(columns, rows)
    turn = np.radians(scene.roll_off_deg + sizes.get("camera-roll", 0.0))
    x, y = (
        x * np.cos(turn) - y * np.sin(turn),
        y * np.cos(turn) + x * np.sin(turn),
    )  # from the picture to the bench
    plate = -np.tan(np.radians(sizes.get("base-tilt", 0.0)))
    rough = SKIN + 0.02 * sizes.get("particle-shape", 0.0)
    fine = np.arange(-wide - 15, wide + 15, pixel / 2)
    top = skin(
        fine, profile(fine, scene, run, sizes, photo), plate * fine, scene, rough, rng
    )
    heap = np.clip((np.interp(x, fine, top) - y) / pixel + 0.5, 0, 1)
    base = np.clip((plate * x - y) / pixel + 0.5, 0, 1)
    speckle = (
        rng.normal(0, 1, (len(rows) // 6 + 2, len(columns) // 6 + 2))
        .repeat(6, 0)
        .repeat(6, 1)[: len(rows), : len(columns)]
    )
    picture = GROUND + heap * (PILE + 12 * speckle - GROUND)
    picture += base * (PLATE - picture)
    return np.clip(
        np.round(picture + GREY_SD * camera.standard_normal(picture.shape)), 0, 255
    ).astype(np.uint8)


def _width_mm(scene: Scene, run: Run, sizes: dict[str, float], photo: int) -> float:
    """Half of the picture's: the whole heap is in it."""
    out = np.arange(1.55 * run.half_mm, 10 * run.half_mm)
    plate = -np.tan(np.radians(sizes.get("base-tilt", 0.0)))
    deep = np.max(
        [profile(x, scene, run, sizes, photo) - plate * x for x in (out, -out)], axis=0
    )
    return float(out[np.argmax(deep < 0.35 * scene.grain_mm)]) + 20


def visibility(scene: Scene, sizes: dict[str, float], name: str) -> Visibility:
    """How visible `name` is beside what packings vary and what is not known of a
    material."""
    grain = scene.grain_mm
    rough = SKIN + 0.02 * sizes.get("particle-shape", 0.0)
    rho = float(np.exp(-scene.mm_per_px * 2 / grain))
    noise = Noise(rough * grain, rho, 0.02, np.inf, 0, 1, 0)
    recordings = [_recording_change(scene, run, sizes, name) for run in scene.runs]
    plumb_sd = known_plumb_deg(scene.request, PLUMB_SD_DEG)
    known = np.r_[plumb_sd, [1.0] * 11, SETTLING_DEG, SETTLING_MM, SETTLING_MM]
    return Visibility(fitted(recordings, known, noise).snr)


def _recording_change(
    scene: Scene, run: Run, sizes: dict[str, float], name: str
) -> RecordingChange:
    """Beside the nearest heap without the effect, and between photos.

    Own nuisances: level, shift, angle, size, rounding, toe; between photos level,
    shift, turn. Shared: roll, the material's crest, toe, bow and angle, what size and
    gate do to them, settling."""
    x = np.arange(-run.half_mm, run.half_mm, scene.mm_per_px)
    without = {k: v for k, v in sizes.items() if k != name}
    photos = np.array([profile(x, scene, run, sizes, k) for k in range(PHOTOS)])
    drawn, run = run, _nearest(x, photos.mean(axis=0), scene, run, without)
    plain = np.array([profile(x, scene, run, without, k) for k in range(PHOTOS)])
    middle = plain[PHOTOS // 2]
    height = run.half_mm * np.tan(np.radians(scene.angle_deg + run.angle_off_deg))

    def more(changed: Run) -> np.ndarray:
        return profile(x, scene, changed, without, PHOTOS // 2) - middle

    rounder = more(replace(run, round_mm=run.round_mm * 1.1)) / np.log(1.1)
    longer = more(replace(run, toe_mm=run.toe_mm * 1.1)) / np.log(1.1)
    steeper = more(replace(run, angle_off_deg=run.angle_off_deg + 0.1)) / 0.1
    larger = more(replace(run, half_mm=run.half_mm + 0.1)) / 0.1
    turned = -np.radians(sizes[name]) * x if name == "camera-roll" else np.zeros_like(x)
    changes = (
        photos - plain + turned + (run.angle_off_deg - drawn.angle_off_deg) * steeper
    )
    crest, toe = (
        column / max(float(np.abs(column).max()), 1e-12) for column in (rounder, longer)
    )
    bow = np.sin(np.pi * np.clip(middle / height, 0, 1))
    faster = np.log(run.gate_mm_s / GATE_MM_S)
    gate, size = KNOWN_GATE * height * faster, np.log(drawn.half_mm / HALF_MM)
    angles = [20.0 * steeper, SIZE_DEG * size * steeper, GATE_DEG * faster * steeper]
    scales = (height, scene.grain_mm)
    known = [
        sd * scale * part
        for part, sds in ((crest, KNOWN_ENDS), (toe, KNOWN_ENDS), (bow, KNOWN_BOW))
        for sd, scale in zip(sds, scales)
    ]
    one, nil = np.ones_like(x), np.zeros_like(x)
    own = [one, np.gradient(middle, x), steeper, larger, rounder, longer, nil, nil, nil]
    shared = [np.radians(x), *known, *angles, gate * crest, gate * toe, nil, nil, nil]
    shape = Channel(changes.mean(axis=0), np.column_stack(own), np.column_stack(shared))
    between = Channel(
        changes[-1] - changes[0],
        np.column_stack([*[nil] * 6, one, np.gradient(middle, x), x]),
        np.column_stack([*[nil] * 12, steeper, crest, toe]),
    )
    between = Channel(
        *(part / REGISTERED for part in (between.change, between.own, between.shared))
    )
    free = np.inf
    own_sd = np.r_[free, free, PACKING_DEG, free, [PACKING_LOG_SD] * 2, [free] * 3]
    return RecordingChange(
        (shape, between) if np.ptp(between.change) > 0 else (shape,), own_sd
    )


def _nearest(
    x: np.ndarray, seen: np.ndarray, scene: Scene, run: Run, without: dict[str, float]
) -> Run:
    """The heap of this run without the effect, of whatever angle and size comes nearest
    to what is seen: neither is known."""

    def made(values: np.ndarray) -> Run:
        return replace(run, angle_off_deg=float(values[0]), half_mm=float(values[1]))

    def off(values: np.ndarray) -> np.ndarray:
        heap = made(values)
        photos = [profile(x, scene, heap, without, k) for k in range(PHOTOS)]
        return np.mean(photos, axis=0) - seen

    x_scale = [1.0, run.half_mm / 20]
    return made(least_squares(off, [run.angle_off_deg, run.half_mm], x_scale=x_scale).x)


def bench(scene: Scene, sizes: dict[str, float]) -> Bench:
    """The bench folder of a scene with these effects."""
    d = scene.grain_mm
    toml = {
        "provenance": "measured",
        "seed": {
            "length_mm": d,
            "width_mm": d,
            "thickness_mm": d,
            "density_kg_m3": 1250.0,
        },
    }
    return Bench(
        toml, tuple(_recording(scene, sizes, i) for i in range(len(scene.runs)))
    )


def _recording(scene: Scene, sizes: dict[str, float], i: int) -> Recording:
    run, name = scene.runs[i], f"pile-{i + 1:02d}"
    toml = {
        "rig": "pile",
        "id": name,
        "session": "day-1",
        "camera": camera_keys(scene.mm_per_px, 0.001),
        "pile": {
            "cylinder_mm": [round(0.9 * run.half_mm, 1), 200.0],
            "gate_speed_mm_s": run.gate_mm_s,
        },
    }
    photos = tuple(photograph(scene, run, sizes, k) for k in range(PHOTOS))
    return Recording(name, toml, photos=photos)


CASES = Cases(
    rig="pile",
    share=0.1,
    colour="#b3261e",
    effects=EFFECTS,
    draw=draw,
    visibility=visibility,
    bench=bench,
    design=("half_mm", "gate_mm_s"),
    singles=("cohesion", "gate-speed", "base-vibration", "base-tilt"),
    need_separation=("cohesion", "gate-speed"),
    confounded=("gate-speed", "wall-friction", "particle-shape", "camera-roll"),
    separable=("cohesion", "gate-speed"),
)
