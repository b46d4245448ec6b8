"""Rolls: round seeds run down an incline and out along a level plate, one way or both.

By the midpoint rule. Effects, fields of a world by their names: viscous_rolling:
dμ_r/dv [s/m]. slope: the run-out falls towards +x [deg], so that a run in direction −x
climbs it. initial_slip: v − ωr at the incline's foot [m/s]. corner_loss: lost share of
the speed there. shape_barrier: highest less lowest centre in a turn [mm]. drag: force
over weight at 0.5 m/s. sticky_patch: more μ_r on a stretch of the level. follows,
order_drift: change of μ_r over half the range of a condition, of the order."""

import math
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from scipy.optimize import brentq

from benchtwin.prove.cases.air import G_M_S2, blown, drag_scale
from benchtwin.prove.cases.bench import Recording, Request, Scene, log_uniform
from benchtwin.prove.cases.camera import magnification
from benchtwin.prove.cases.noise import draw_noise, tracked
from benchtwin.prove.cases.record import Cases, Effect, world_with
from benchtwin.prove.cases.snr import Change, Visibility, fitted, matched, slopes
from benchtwin.prove.cases.stated import (
    AIRY_SHARE,
    bench_keys,
    camera_keys,
    draw_distance_mm,
    draw_scale_sd,
    known_scale,
    stated_distance_mm,
)

STEP_S, FINEST_STEP_S = 2e-4, 1e-9
ROLLS, DRAG_SPEED_M_S = 5 / 7, 0.5
RUN_SD, INCLINE_SD_DEG, LEVEL_SD_DEG, START_SD_MM = 0.03, 0.1, 0.003, 0.2
# of a sphere's drag in free air, in all runs; size and mass known or not
DRAG_NEAR_PLATE = (0.7, 2.0)
DRAG_NEAR_PLATE_SD = (0.4, 1.0)
SEED_SD = 0.04  # each seed's own
ASTRAY_SD = 0.009  # tangent of the angle in which a seed runs away from the camera
# what a corner might take by itself besides: shares of 5/7 (1 − cos β) of the speed: a
# sharp corner takes that, a rounded one nothing
CORNER = (0.0, 0.5, 1.0)
CORNER_SD = 0.25
EFFECTS = {
    "viscous-rolling": Effect(("run-out",), "s/m", 0.002, 0.2),
    "slope": Effect(("run-out",), "deg", 0.006, 1.0, 0),
    "initial-slip": Effect(("onset", "run-out"), "m/s", 0.005, 0.18),
    "corner-loss": Effect(("onset", "run-out"), "1", 0.003, 0.3),
    "shape-barrier": Effect(("run-out",), "mm", 0.001, 0.15),
    "drag": Effect(("run-out",), "1", 0.0005, 0.1),
    "sticky-patch": Effect(("run-out",), None, 0.0005, 0.03, listed=False),
    "order-drift": Effect(("run-out",), None, 0.0001, 0.012, 0, listed=False),
    "follows": Effect(("run-out",), None, 0.0001, 0.012, 0),
}


class Roll(NamedTuple):
    """One roll, as it is without effects."""

    sign: float  # of its direction along x
    mu_factor: float
    start_off_mm: float
    phase: float
    late_s: float
    air: float  # beside a sphere's in free flight; 0: none
    astray: float
    noise_seed: int
    lot_mu: float
    diameter_mm: float
    way_mm: float
    incline_off_deg: float  # what the bench left open, as the next two
    level_off_deg: float
    scale_off: float
    fps: float
    patch_from: float  # share of the run-out in the direction +x
    patch_to: float
    distance_mm: float
    lone_drag: float  # of a sphere in free flight: ρ A / 2m [1/m]
    re_per_speed: float
    grip: float  # friction of a seed that slips from the start; 0: it rolls


World = world_with(EFFECTS, Roll)
INCLINE_DEG = 15.0


@njit(cache=True)
def rolling(world):
    """Rolling friction [1] of this roll at rest."""
    mu = world.lot_mu * world.mu_factor
    return mu + world.followed * (world.follows + world.order_drift)


@njit(cache=True)
def fall(x, world):
    """How steeply the way falls at x from the junction [m], in rad."""
    if x < 0:
        return math.radians(INCLINE_DEG + world.incline_off_deg)
    return -world.sign * math.radians(world.level_off_deg - world.slope)


@njit(cache=True)
def driven(x, world):
    """Downhill push over weight [1] at x from the junction [m]: slope and shape."""
    radius = world.diameter_mm * 5e-4
    held = world.shape_barrier * 1e-3 / radius
    return math.sin(fall(x, world)) - held * math.sin(2 * x / radius + world.phase)


@njit(cache=True)
def resisted(x, v, world):
    """What is against the motion, over weight [1]."""
    resist = rolling(world) + world.viscous_rolling * abs(v)
    place = 1e3 * x / reach_mm(world)
    if world.sign < 0:
        place = 1 - place
    if world.patch_from < place < world.patch_to:
        resist += world.sticky_patch
    air = abs(blown(v, world.lone_drag * world.air, world.re_per_speed)) / G_M_S2
    drag = world.drag * (v / DRAG_SPEED_M_S) ** 2
    return resist * math.cos(fall(x, world)) + drag + air


@njit(cache=True)
def reach_mm(world):
    """How far a seed of the baseline runs out: μ_r = S sin β / (S cos β + L)."""
    beta, mu = math.radians(INCLINE_DEG), world.lot_mu
    return world.way_mm * (math.sin(beta) - mu * math.cos(beta)) / mu


@njit(cache=True)
def rolled(x, v, way, world):
    """Acceleration [m/s²] of pure rolling in the direction `way` (±1)."""
    return ROLLS * G_M_S2 * (driven(x, world) - way * resisted(x, v, world))


@njit(cache=True)
def simulate(world, times):
    """Travel [mm] at `times` after the release (n,), and speed [mm/s]."""
    length = (world.way_mm + world.start_off_mm) * 1e-3
    x, v, slip, now, way = -length, 0.0, 0.0, 0.0, 1.0
    out, speed = np.zeros(times.size), np.zeros(times.size)
    slips = world.grip > 0.0
    for k in range(times.size):
        while now < times[k]:
            h = min(STEP_S, times[k] - now)
            if x < 0.0 < x + 2 * h * v:  # a step ends where the incline does
                h = min(h, max(-x / v, FINEST_STEP_S))
            before = x
            # the foot slides: friction drives the turning, v − ωr is the slip
            if slips:
                tilt = fall(x, world)
                grip = world.grip * math.cos(tilt)
                a = G_M_S2 * (math.sin(tilt) - grip)
                turning = 2.5 * rolling(world) * math.cos(tilt)
                slip += h * G_M_S2 * (math.sin(tilt) - 3.5 * grip + turning)
                x += h * (v + h / 2 * a)
                v += h * a
                slips = slip >= 0.0
            elif way != 0.0:
                a = rolled(x, v, way, world)
                middle = rolled(x + h / 2 * v, v + h / 2 * a, way, world)
                x += h * (v + h / 2 * a)
                v += h * middle
                if v * way <= 0.0:  # it turns back, or stays
                    v, push = 0.0, driven(x, world)
                    stays = abs(push) <= resisted(x, 0.0, world)
                    way = 0.0 if stays else math.copysign(1.0, push)
            if before < 0.0 <= x:
                v *= 1 - world.corner_loss
            now = now + h if h < times[k] - now else times[k]
        out[k], speed[k] = 1e3 * (x + length), 1e3 * v
    return out, speed


def with_grip(world: Any) -> Any:
    """The world with the friction with which a seed that slips from the start slips by
    `initial_slip` [m/s] at the foot of the incline."""
    beta, mu_r = fall(-1.0, world), rolling(world)
    steep, level = G_M_S2 * np.sin(beta), G_M_S2 * np.cos(beta)

    def off(mu: float) -> float:
        pushed = (steep - (3.5 * mu - 2.5 * mu_r) * level) / np.sqrt(steep - mu * level)
        return pushed * np.sqrt(2e-3 * world.way_mm) - world.initial_slip

    if world.initial_slip <= 0 or off(0.0) <= 0:
        return world._replace(grip=0.0)
    return world._replace(grip=brentq(off, 0.0, (np.tan(beta) + 2.5 * mu_r) / 3.5))


def draw(request: Request, rng: np.random.Generator) -> Scene:
    """Rolls as requested: their camera, and what is stated of them."""
    both = request.separated or (request.separated is None and rng.random() < 0.5)
    pixel, scale_sd = float(rng.uniform(0.1, 0.3)), draw_scale_sd(request, rng)
    runs = [
        {
            "sign": -1.0 if both and i % 2 else 1.0,
            "mu_factor": float(1 + rng.normal(0, RUN_SD)),
            "start_off_mm": float(rng.normal(0, START_SD_MM)),
            "phase": float(rng.uniform(0, 2 * np.pi)),
            "late_s": float(rng.uniform(-0.05, 0.01)),
            "air": float(1 + rng.normal(0, SEED_SD)),
            "astray": float(rng.normal(0, ASTRAY_SD)),
            "noise_seed": int(rng.integers(2**62)),
        }
        for i in range(int(rng.integers(6, 10)))
    ]
    mu, way = log_uniform(0.02, 0.06, rng), float(rng.choice([10.0, 20.0, 40.0]))
    diameter, density = round(float(rng.uniform(5, 8)), 2), rng.uniform(1050, 1350)
    shared = {
        "incline_off_deg": rng.normal(0, INCLINE_SD_DEG),
        "level_off_deg": rng.normal(0, LEVEL_SD_DEG),
        "scale_off": rng.normal(0, scale_sd),
        "fps": float(rng.choice([240.0, 500.0, 1000.0])),
    }
    noise = draw_noise(rng, sd=(0.015, 0.08), pixel=pixel)
    air = float(rng.uniform(*DRAG_NEAR_PLATE)) * (
        "drag" not in request.effects
        and ("air" in request.absent or rng.random() < AIRY_SHARE)
    )
    patch = np.sort(rng.uniform(0.15, 0.8, 2)) + np.array([0.0, 0.08])
    shared |= dict(zip(("patch_from", "patch_to"), patch.tolist()))
    shared |= {"distance_mm": draw_distance_mm(rng), "lot_mu": mu, "way_mm": way}
    axes = np.full(3, diameter)
    scale = dict(zip(("lone_drag", "re_per_speed"), drag_scale(axes, density)))
    shared |= {"diameter_mm": diameter, "grip": 0.0, **scale}
    worlds = tuple(World(**run | shared | {"air": air * run["air"]}) for run in runs)
    toml = bench_keys(axes, density, airy=air > 0)
    return Scene(worlds, request, toml, noise, scale_sd)


def travel(world: Any) -> tuple[np.ndarray, np.ndarray]:
    """(times [s] from the film's start, travel [mm]); 0.15 s of rest at the end."""
    way_mm = world.way_mm + reach_mm(world)
    longest = 4 * np.sqrt(2 * way_mm * 1e-3 / (G_M_S2 * world.lot_mu * 0.7)) + 1
    t = np.arange(int(longest * world.fps)) / world.fps
    x, v = simulate(with_grip(world), np.maximum(t + world.late_s, 0.0))
    moving = np.flatnonzero(np.abs(v) > 0)
    n = min(len(t), int(moving[-1] + 0.15 * world.fps)) if len(moving) else len(t)
    return t[:n], x[:n]


def seen(world: Any, t: np.ndarray) -> np.ndarray:
    """Travel (1, n) [mm] at times t as the camera sees it, above the middle of the way:
    who runs away from it looks slower."""
    x = simulate(with_grip(world), np.maximum(t + world.late_s, 0.0))[0]
    middle = (world.way_mm + reach_mm(world)) / 2
    larger = magnification(world.distance_mm, world.astray * x)
    return (middle + (x - middle) * larger)[None]


def visibility(scene: Scene, name: str) -> Visibility:
    """How visible the effect `name` is beside the others, and beside the corner that
    hides it best."""
    sharp = 5 / 7 * (1 - np.cos(np.radians(INCLINE_DEG)))
    at_corner = name in ("corner_loss", "initial_slip")
    seen = min(
        (
            _visible_beside(scene, name, share * sharp, CORNER_SD * sharp)
            for share in (CORNER if at_corner else CORNER[:1])
        ),
        key=lambda one: one.snr,
    )
    # at which value of a condition friction is to be compared nobody says
    comparable = name not in ("follows", "order_drift")
    return seen if comparable else Visibility(seen.snr)


def _visible_beside(
    scene: Scene, name: str, taken: float, corner_sd: float
) -> Visibility:
    """How visible it is where the corner by itself takes a share `taken` of the speed,
    known to corner_sd."""
    own = {
        "offset": np.inf,
        "late_s": np.inf,
        "mu_factor": RUN_SD,
        "start_off_mm": START_SD_MM,
        "astray": ASTRAY_SD,
    }
    shared = {
        "mu_factor": np.inf,
        "incline_off_deg": INCLINE_SD_DEG,
        "level_off_deg": LEVEL_SD_DEG,
        "corner_loss": corner_sd,
        "scale": known_scale(scene.request, scene.scale_sd),
    }
    steps = {
        **{"late_s": 1e-3, "mu_factor": 2e-3, "start_off_mm": 0.01, "astray": 1e-4},
        **{"incline_off_deg": 0.01, "level_off_deg": 1e-3, "corner_loss": 1e-3},
    }
    if scene.worlds[0].air > 0:
        steps["air"], own["air"] = 0.1, SEED_SD
        shared["air"] = DRAG_NEAR_PLATE_SD[not scene.request.sizes_known()]
    changes = []
    for world in scene.worlds:
        bare = world._replace(**{name: 0.0})
        bare = bare._replace(corner_loss=max(bare.corner_loss, taken))
        t, x = travel(world)
        near = matched(lambda w: travel(w)[1][-1], x[-1], bare, mu_factor=(0.3, 2.3))
        rows = partial(seen, t=t)
        columns = slopes(rows, world, steps)
        moved = near.mu_factor - bare.mu_factor
        change = rows(world) - rows(near) + moved * columns["mu_factor"]
        columns |= {"offset": np.ones_like(change), "scale": rows(world)}
        changes.append(Change(change, columns, own, shared))
    fit = fitted(changes, scene.noise)
    return Visibility(fit.snr, fit.shared_in_sds["mu_factor"])


def record(scene: Scene, world: Any, name: str) -> Recording:
    """What is filmed of one roll."""
    rng = np.random.default_rng(world.noise_seed)
    away = stated_distance_mm(world.distance_mm, rng)
    pixel = scene.noise.pixel
    way = {
        "incline_deg": INCLINE_DEG,
        "incline_length_mm": world.way_mm,
        "direction": "+x" if world.sign > 0 else "-x",
    }
    camera = camera_keys(pixel, scene.scale_sd, fps=world.fps, distance_mm=away)
    toml = {"session": "day-1", "roll": way, "camera": camera}
    t, _ = travel(world)
    x = seen(world, t)[0] / (1 + world.scale_off)
    track = tracked(t.round(6), x, np.zeros(len(t)), scene.noise, rng)
    return Recording(name, toml, track=track)


CASES = Cases(
    rig="roll",
    share=0.17,
    colour="#2e7d4f",
    effects=EFFECTS,
    draw=draw,
    visibility=visibility,
    record=record,
    design=("sign",),
    follows="rolling_friction",
    singles=("slope", "initial-slip", "corner-loss", "shape-barrier"),
    need_separation=("slope",),
    confounded=("viscous-rolling", "drag"),
    separable=("slope",),
    pairs=(
        ("slope", "corner-loss"),
        ("slope", "shape-barrier"),
        ("corner-loss", "shape-barrier"),
    ),
)
