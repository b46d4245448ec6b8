"""Heaps in photos: two flanks on a plate, drawn from a profile that each effect bends
in its own way, under a skin of grains.

No grains are simulated: an effect is put in as it shows, by its field of a world.
cohesion: the crest's top so many mm higher than the flanks' line, on a length that does
not grow with the heap, and a toe cut short. wall_friction: the flanks bow out by so
many mm. gate_speed: rounder crest and longer toe by so many mm where 50 mm/s are
stated, in proportion to what is. base_vibration: the same, more in each later photo.
base_tilt: plate and heap's foot turned [deg], the flanks not, clockwise.
particle_shape: flanks bow in and the skin is rougher. camera_roll: all turned,
clockwise positive. layered (outside): the flank breaks half way up."""

from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

from benchtwin.prove.cases.bench import Recording, Request, Scene, log_uniform
from benchtwin.prove.cases.noise import Noise
from benchtwin.prove.cases.record import Cases, Effect, world_with
from benchtwin.prove.cases.snr import Change, Visibility, fitted, slopes
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


class Pile(NamedTuple):
    """One heap, as it is without effects."""

    half_mm: float  # of the base
    angle_off_deg: float
    round_mm: float
    toe_mm: float
    noise_seed: int
    gate_mm_s: float
    lot_angle_deg: float
    grain_mm: float
    roll_off_deg: float
    mm_per_px: float
    gate_power: float
    gate_deg: float  # flatter by itself where the gate is e times as fast


World = world_with(EFFECTS, Pile)


def draw(request: Request, rng: np.random.Generator) -> Scene:
    """Heaps as requested: their camera, and what is stated of them."""
    gates = request.separated and "gate-speed" in request.effects
    several = (request.separated and not gates) or rng.random() < 0.4
    halves, grain = ((45.0, 80.0) if several else (75.0,)), float(rng.uniform(2.0, 4.0))
    runs = [
        {
            "half_mm": halves[i % len(halves)] * (1 + rng.normal(0, 0.02)),
            "angle_off_deg": rng.normal(0, PACKING_DEG),
            "round_mm": grain * log_uniform(0.8, 1.2, rng) * 1.5,
            "toe_mm": grain * log_uniform(0.8, 1.2, rng) * 2,
            "noise_seed": int(rng.integers(2**62)),
        }
        for i in range(int(rng.integers(5, 9)))
    ]
    plumb_sd = UNSTATED_PLUMB_SD_DEG if set(PLUMB) & request.absent else PLUMB_SD_DEG
    shared = {
        "lot_angle_deg": rng.uniform(22, 33),
        "grain_mm": round(grain, 2),
        "roll_off_deg": rng.normal(0, plumb_sd),
        "mm_per_px": round(float(rng.uniform(0.3, 0.4)), 3),
        "gate_power": rng.normal(0, GATE_POWER_SD),
        "gate_deg": abs(rng.normal(0, GATE_DEG)),
    }
    if gates or (request.separated is None and not several and rng.random() < 0.3):
        gates_mm_s = list(GATES)
    else:
        gates_mm_s = [GATE_MM_S]
    worlds = tuple(
        World(**run, **shared, gate_mm_s=gates_mm_s[i % len(gates_mm_s)])
        for i, run in enumerate(runs)
    )
    sizes = ("length_mm", "width_mm", "thickness_mm")
    seed = dict.fromkeys(sizes, shared["grain_mm"]) | {"density_kg_m3": 1250.0}
    return Scene(worlds, request, {"provenance": "measured", "seed": seed})


def plate(x: Any, world: Any) -> Any:
    """Height of the plate [mm] at x [mm] from the heap's middle."""
    return -np.tan(np.radians(world.base_tilt)) * x


def simulate(world: Any, x: np.ndarray, photo: int) -> np.ndarray:
    """Height of the heap's skin [mm] at x [mm] from its middle; the plate's where there
    is none."""
    faster = world.gate_mm_s / GATE_MM_S
    lower = world.gate_deg * np.log(faster)
    steep = np.tan(np.radians(world.lot_angle_deg + world.angle_off_deg - lower))
    shaken = world.base_vibration * (1 + photo) / PHOTOS
    longer = faster * world.gate_speed + shaken
    rounding = world.round_mm * faster**world.gate_power + longer
    toe = world.toe_mm * faster**world.gate_power + longer
    height = world.half_mm * steep
    line = height - steep * (np.sqrt(x**2 + rounding**2) - 0.3 * rounding)
    up = np.clip(line / height, 0, 1)
    line = line + (world.wall_friction - world.particle_shape) * np.sin(np.pi * up)
    line += world.layered * 2 * np.minimum(up, 1 - up)
    stuck = world.cohesion
    line += stuck * np.exp(-np.abs(x) / (3 * stuck + 2 * world.grain_mm))
    toe = toe / (1 + stuck / world.grain_mm)
    ground = plate(x, world)
    above = np.clip((line - ground) / (toe * steep), -50, 500)
    return ground + toe * steep * np.logaddexp(0, above)


def skin(
    x: np.ndarray,
    height: np.ndarray,
    world: Any,
    rng: np.random.Generator,
) -> np.ndarray:
    """Outline of the grains that lie under `height`, and the plate where there are
    none."""
    ground = plate(x, world)
    radius = world.grain_mm / 2
    centres = np.arange(x[0], x[-1], 0.55 * world.grain_mm)
    centres = centres + rng.uniform(-0.15, 0.15, len(centres)) * world.grain_mm
    top = np.interp(centres, x, height) + rng.normal(
        0, roughness(world) * world.grain_mm, len(centres)
    )
    off = (x[:, None] - centres) / radius
    rise = np.sqrt(np.maximum(1 - off**2, 0))
    arcs = np.where(np.abs(off) < 1, top - radius + radius * rise, -np.inf)
    arcs[:, np.interp(centres, x, height - ground) < 0.35 * world.grain_mm] = -np.inf
    return np.maximum(arcs.max(axis=1), ground)


def photograph(world: Any, photo: int) -> np.ndarray:
    """One photo (h, w) uint8: in all photos of one heap the same grains lie in its
    skin, the camera's noise is each one's own."""
    rng = np.random.default_rng(world.noise_seed)
    camera = np.random.default_rng([world.noise_seed, photo])
    pixel, wide = world.mm_per_px, _width_mm(world, photo)
    steepest = np.tan(np.radians(world.lot_angle_deg + 6))
    tall = world.half_mm * steepest + world.cohesion + 22
    columns, rows = np.arange(-wide, wide, pixel), np.arange(tall, -14, -pixel)
    x, y = np.meshgrid(columns, rows)
    turn = np.radians(world.roll_off_deg + world.camera_roll)
    x, y = (
        x * np.cos(turn) - y * np.sin(turn),
        y * np.cos(turn) + x * np.sin(turn),
    )  # from the picture to the bench
    fine = np.arange(-wide - 15, wide + 15, pixel / 2)
    top = skin(fine, simulate(world, fine, photo), world, rng)
    heap = np.clip((np.interp(x, fine, top) - y) / pixel + 0.5, 0, 1)
    base = np.clip((plate(x, world) - y) / pixel + 0.5, 0, 1)
    speckle = (
        rng.normal(0, 1, (len(rows) // 6 + 2, len(columns) // 6 + 2))
        .repeat(6, 0)
        .repeat(6, 1)[: len(rows), : len(columns)]
    )
    picture = GROUND + heap * (PILE + 12 * speckle - GROUND)
    picture += base * (PLATE - picture)
    picture += GREY_SD * camera.standard_normal(picture.shape)
    return np.clip(np.round(picture), 0, 255).astype(np.uint8)


def _width_mm(world: Any, photo: int) -> float:
    """Half of the picture's: the whole heap is in it."""
    out = np.arange(1.55 * world.half_mm, 10 * world.half_mm)
    sides = [simulate(world, x, photo) - plate(x, world) for x in (out, -out)]
    deep = np.max(sides, axis=0)
    return float(out[np.argmax(deep < 0.35 * world.grain_mm)]) + 20


def visibility(scene: Scene, name: str) -> Visibility:
    """How visible the effect `name` is beside what packings vary and what is not known
    of a material."""
    one = scene.worlds[0]
    rho = float(np.exp(-one.mm_per_px * 2 / one.grain_mm))
    noise = Noise(roughness(one) * one.grain_mm, rho, 0.02, np.inf, 0, 1, 0)
    plumb_sd = known_plumb_deg(scene.request, PLUMB_SD_DEG)
    changes = [_change(world, name, plumb_sd) for world in scene.worlds]
    return Visibility(fitted(changes, noise).snr)


def roughness(world: Any) -> float:
    """sd of the surface, of a grain's diameter."""
    return SKIN + 0.02 * world.particle_shape


def seen(world: Any, x: np.ndarray) -> np.ndarray:
    """(2, n): the skin's height at x, mean of the photos; how it differs between the
    last and the first, in which the same grains lie."""
    turned = np.radians(world.camera_roll) * x
    photos = np.array([simulate(world, x, k) - turned for k in range(PHOTOS)])
    return np.array([photos.mean(axis=0), (photos[-1] - photos[0]) / REGISTERED])


def _change(world: Any, name: str, plumb_sd: float) -> Change:
    """Beside the nearest heap without the effect, and between photos."""
    x = np.arange(-world.half_mm, world.half_mm, world.mm_per_px)
    rows, bare = partial(seen, x=x), world._replace(**{name: 0.0})
    near = _nearest(rows, world, bare)
    tenth = {"round_mm": 0.1 * near.round_mm, "toe_mm": 0.1 * near.toe_mm}
    columns = slopes(rows, near, {"angle_off_deg": 0.1, "half_mm": 0.1, **tenth})
    moved = near.angle_off_deg - bare.angle_off_deg
    change = rows(world) - rows(near) + moved * columns["angle_off_deg"]
    steeper = columns["angle_off_deg"][0]
    crest, toe = (columns[end][0] for end in tenth)
    crest, toe = (end / max(float(np.abs(end).max()), 1e-12) for end in (crest, toe))
    middle = rows(near)[0]
    shifted = np.gradient(middle, x)
    height = near.half_mm * np.tan(np.radians(near.lot_angle_deg + near.angle_off_deg))
    bow = np.sin(np.pi * np.clip(middle / height, 0, 1))
    faster, size = np.log(world.gate_mm_s / GATE_MM_S), np.log(world.half_mm / HALF_MM)
    shape = {
        "level": (np.ones_like(x), np.inf),
        "shift": (shifted, np.inf),
        "turn": (np.radians(x), plumb_sd),
        "angle": (steeper, 20.0),
        "angle, by size": (size * steeper, SIZE_DEG),
        "angle, by gate": (faster * steeper, GATE_DEG),
        "crest, by gate": (height * faster * crest, KNOWN_GATE),
        "toe, by gate": (height * faster * toe, KNOWN_GATE),
    }
    for part, column, sds in (
        ("crest", crest, KNOWN_ENDS),
        ("toe", toe, KNOWN_ENDS),
        ("bow", bow, KNOWN_BOW),
    ):
        shape[f"{part}, of the height"] = (height * column, sds[0])
        shape[f"{part}, of a grain"] = (world.grain_mm * column, sds[1])
    later = {
        "later level": (np.ones_like(x), np.inf),
        "later shift": (shifted, np.inf),
        "later turn": (x, np.inf),
        "settling": (steeper, SETTLING_DEG),
        "settling crest": (crest, SETTLING_MM),
        "settling toe": (toe, SETTLING_MM),
    }
    nil = np.zeros_like(x)
    columns |= {k: np.array([column, nil]) for k, (column, _) in shape.items()}
    columns |= {k: np.array([nil, c / REGISTERED]) for k, (c, _) in later.items()}
    shared = {k: sd for k, (_, sd) in (shape | later).items()}
    free = ("level", "shift", "later level", "later shift", "later turn")
    own = {k: shared.pop(k) for k in free} | {
        "half_mm": np.inf,
        "angle_off_deg": PACKING_DEG,
        "round_mm": PACKING_LOG_SD * near.round_mm,
        "toe_mm": PACKING_LOG_SD * near.toe_mm,
    }
    return Change(change, columns, own, shared)


def _nearest(rows: Any, world: Any, bare: Any) -> Any:
    """The heap without the effect, of whatever angle and size comes nearest to what is
    seen: neither is known."""

    def made(values: np.ndarray) -> Any:
        return bare._replace(angle_off_deg=values[0], half_mm=values[1])

    start, wanted = [bare.angle_off_deg, bare.half_mm], rows(world)[0]
    scale = [1.0, bare.half_mm / 20]
    found = least_squares(lambda v: rows(made(v))[0] - wanted, start, x_scale=scale)
    return made(found.x)


def record(scene: Scene, world: Any, name: str) -> Recording:
    """The photos of one heap."""
    cylinder = [round(0.9 * world.half_mm, 1), 200.0]
    toml = {
        "session": "day-1",
        "camera": camera_keys(world.mm_per_px, scene.scale_sd),
        "pile": {"cylinder_mm": cylinder, "gate_speed_mm_s": world.gate_mm_s},
    }
    photos = {f"photo-{k + 1}.png": photograph(world, k) for k in range(PHOTOS)}
    return Recording(name, toml, pictures=photos)


CASES = Cases(
    rig="pile",
    share=0.1,
    colour="#b3261e",
    effects=EFFECTS,
    draw=draw,
    visibility=visibility,
    record=record,
    design=("half_mm", "gate_mm_s"),
    singles=("cohesion", "gate-speed", "base-vibration", "base-tilt"),
    need_separation=("cohesion", "gate-speed"),
    confounded=("gate-speed", "wall-friction", "particle-shape", "camera-roll"),
    separable=("cohesion", "gate-speed"),
)
