"""Slides: a block of taped seeds on a plate that tilts up, filmed beside a tilt sensor;
or only the angles that were read.

By the midpoint rule. Effects, fields of a world by their names: kinetic_friction:
μ_s − μ_k. stribeck: μ at rest less μ at high speed. viscous_sliding: dμ/dv. adhesion:
pull towards the plate [mN], whatever the load. reading_delay: the angle is read after
so much travel [mm]. clock_offset: a tilt of true time T is stamped T + offset.
angle_offset: recorded less true tilt. plate_vibration: amplitude along the plate
[m/s²]. partial_rolling: added inertia over mass. stepped_tilt: height of the stairs in
which the plate climbs [deg]. worn_track: dμ/dx [1/m]. follows, order_drift: change of μ
over half the range of a condition, of the order."""

import math
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numba import njit

from benchtwin.prove.cases.air import G_M_S2, blown, drag_scale
from benchtwin.prove.cases.bench import Recording, Request, Scene
from benchtwin.prove.cases.noise import draw_noise, tracked
from benchtwin.prove.cases.record import Cases, Effect, world_with
from benchtwin.prove.cases.snr import (
    WHITE,
    Change,
    Visibility,
    fitted,
    matched,
    slopes,
)
from benchtwin.prove.cases.stated import (
    AIRY_SHARE,
    GRID_SHARES,
    GRIDS_DEG,
    LIFT_SHARES,
    LIFTS,
    bench_keys,
    camera_keys,
    draw_distance_mm,
    draw_scale_sd,
    known_scale,
    mean_sd_deg,
    on_grid,
    stated_distance_mm,
)

STEP_S, FINEST_STEP_S = 2e-4, 1e-9
JOG = 0.2  # of a stair's time is spent climbing it
TILT_SD_DEG, RUN_SD, READING_SD_DEG = 0.05, 0.003, 0.02
RATE_SD = 0.01  # of a plate's rate of tilting about the stated one, relative
# of a tilt that nobody recorded, at the film's first moment
START_SD_DEG = 0.2
UNSTATED_START_SD_DEG = 10.0
# [deg] on which a recorded tilt lies
COLUMN_GRIDS = (0.0, 0.1, 0.5)
COLUMN_SHARES = (0.65, 0.23, 0.12)
# of a lone seed's drag; as sd, its size and mass known or not
DRAG_NEAR_PLATE = (0.4, 1.6)
DRAG_NEAR_PLATE_SD = (0.35, 1.0)
SHADE, SHADE_SD = (0.0, 0.5), 0.15  # among n seeds each is blown at by n^−shade as much
EFFECTS = {
    "kinetic-friction": Effect(("onset", "sliding"), "1", 0.0003, 0.2),
    "stribeck": Effect(("sliding", "onset"), "1", 0.0005, 0.2),
    "viscous-sliding": Effect(("sliding",), "s/m", 0.0005, 1.0),
    "adhesion": Effect(("onset", "sliding"), "mN", 0.002, 6.0),
    "reading-delay": Effect(("measurement", "onset"), "mm", 0.2, 25.0),
    "clock-offset": Effect(("measurement", "onset"), "s", 0.01, 1.0, 0, either=True),
    "angle-offset": Effect(("measurement", "onset"), "deg", 0.1, 6.0, 0, either=True),
    "plate-vibration": Effect(("onset", "sliding"), "m/s^2", 0.05, 2.0),
    "partial-rolling": Effect(("sliding",), "1", 0.003, 0.4),
    "stepped-tilt": Effect(("measurement", "onset", "sliding"), "deg", 0.05, 2.0),
    "worn-track": Effect(("sliding",), None, 0.004, 4.0, listed=False),
    "order-drift": Effect(("onset", "sliding"), None, 0.0005, 0.06, 0, listed=False),
    "follows": Effect(("onset", "sliding"), None, 0.0005, 0.06, 0),
}


class Slide(NamedTuple):
    """One slide, as it is without effects."""

    mu: float  # at rest
    rate_deg_s: float
    stated_deg_s: float  # the same as it is stated
    start_deg: float  # the tilt at the film's first moment
    seeds: int  # in the block
    hinge_m: float
    noise_seed: int
    mass: float  # of a seed [kg]
    lone_drag: float  # of a seed in free flight: ρ A / 2m [1/m]
    re_per_speed: float
    air: float  # beside the plate, of free flight's; 0: none
    shade: float
    lot_mu: float  # of all slides
    tilt_off_deg: float  # of the recorded tilt, in all slides
    scale_off: float
    travel_mm: float
    fps: float
    shake_hz: float
    stribeck_m_s: float
    distance_mm: float
    column_grid_deg: float
    readings: int  # how many the recording holds; 0: it is filmed
    reading_grid_deg: float
    reading_lift: float


World = world_with(EFFECTS, Slide)


@njit(cache=True)
def tilted(steady, rate, stair):
    """(tilt, rate): `steady`, or stairs climbed s²(3 − 2s) in the last JOG of their
    time."""
    if stair <= 0.0:
        return steady, rate
    below = math.floor(steady / stair)
    s = max(0.0, (steady / stair - below - 1 + JOG) / JOG)
    return stair * (below + s * s * (3 - 2 * s)), rate * 6 * s * (1 - s) / JOG


@njit(cache=True)
def static(world):
    """Coefficient of friction at rest [1]."""
    return world.mu + world.followed * (world.follows + world.order_drift)


@njit(cache=True)
def drive(t, x, v, world):
    """(downhill push, normal force) over mass [m/s²] in the plate's frame: weight, film
    pull, turning plate, shaking plate."""
    rate = math.radians(world.rate_deg_s)
    steady = math.radians(world.start_deg) + rate * t
    tilt, rate = tilted(steady, rate, math.radians(world.stepped_tilt))
    push = G_M_S2 * math.sin(tilt) - (world.hinge_m - x) * rate * rate
    push += world.plate_vibration * math.sin(2 * math.pi * world.shake_hz * t)
    pull = world.adhesion * 1e-3 / (world.seeds * world.mass)
    return push, max(G_M_S2 * math.cos(tilt) + pull - 2 * rate * v, 0.0)


@njit(cache=True)
def holds(t, x, world):
    """What friction at rest could hold beyond the push, over mass [m/s²]."""
    push, normal = drive(t, x, 0.0, world)
    return static(world) * normal - push


@njit(cache=True)
def pulled(t, x, v, world):
    """Acceleration along the plate [m/s²] at time t [s], travel x [m], speed v
    [m/s]."""
    push, normal = drive(t, x, v, world)
    mu = static(world) - world.kinetic_friction
    mu -= world.stribeck * (1 - math.exp(-v / world.stribeck_m_s))
    mu += world.viscous_sliding * v + world.worn_track * x
    air = world.lone_drag * world.air * world.seeds**-world.shade
    held = mu * normal + blown(v, air, world.re_per_speed)
    return (push - held) / (1 + world.partial_rolling)


@njit(cache=True)
def simulate(world, times):
    """Travel [mm] at `times` [s] (n,), and the number of times up to the travel's
    end."""
    x, v, now, out = 0.0, 0.0, times[0], np.zeros(times.size)
    for k in range(times.size):
        while now < times[k]:
            h = min(STEP_S, times[k] - now)
            if v <= 0.0:
                v = 0.0
                held = holds(now, x, world)
                if held >= 0.0:
                    later = holds(now + h, x, world)
                    # a step ends where it lets go
                    h *= held / (held - later) if later < 0.0 else 1.0
                    now = now + max(h, FINEST_STEP_S)
                    continue
            a = pulled(now, x, v, world)
            half = max(v + h / 2 * a, 0.0)
            middle = pulled(now + h / 2, x + h / 2 * v, half, world)
            x += h * (v + h / 2 * a)
            v += h * middle
            now += h
        out[k] = 1e3 * x
        if out[k] > world.travel_mm:
            return out, k + 1
    return out, times.size


def times(world: Any) -> np.ndarray:
    """Frame times from the film's beginning."""
    span = np.degrees(np.arctan(world.lot_mu)) - world.start_deg + 14
    return np.arange(int(span / world.rate_deg_s * world.fps)) / world.fps


def draw(request: Request, rng: np.random.Generator) -> Scene:
    """Slides as requested: their camera, and what is stated of them."""
    effects = set(request.effects)
    read = "reading-delay" in effects or (not effects and rng.random() < 0.2)
    count = int(rng.integers(3, 5)) if read else int(rng.integers(5, 9))
    several = (
        request.separated or read or (request.separated is None and rng.random() < 0.5)
    )
    if read:
        rates = [0.5, 2.0, 5.0]
    else:
        rates = [1.0, 5.0] if several else [float(rng.choice([1.0, 2.0, 4.0]))]
    loads = [4]
    if "adhesion" in effects or (several and rng.random() < 0.4):
        loads = [2, 8]
    length = rng.uniform(6, 10)
    shares = np.array([1.0, rng.uniform(0.75, 0.95), rng.uniform(0.65, 0.74)])
    axes = (length * shares).round(2)
    pixel = float(rng.uniform(0.08, 0.3))
    scale_sd = draw_scale_sd(request, rng)
    mu = rng.uniform(0.25, 0.5)
    # it may let go so much sooner
    following = {"follows", "order-drift"} & effects
    ahead = 3.5 if following or rng.random() < 0.2 else 0.0
    runs = []
    for i in range(count):
        rate = rates[i % len(rates)]
        # a film begins so long [deg] before the block may let go
        margin = min(4.0, max(1.2, 0.8 * rate)) + ahead + rng.uniform(0, 0.5)
        run = {
            "start_deg": float(np.degrees(np.arctan(mu)) - margin),
            "mu": mu + float(rng.normal(0, RUN_SD)),
            "hinge_m": round(float(rng.uniform(0.12, 0.25)), 3),
            "noise_seed": int(rng.integers(2**62)),
        }
        run["rate_deg_s"] = rate * (1 + float(rng.normal(0, RATE_SD)))
        runs.append(run | {"stated_deg_s": rate, "seeds": loads[i // 2 % len(loads)]})
    noise = draw_noise(rng, sd=(0.015, 0.06), pixel=pixel)
    slow = request.separated is False
    stribeck_m_s = rng.uniform(0.004, 0.01) if slow else rng.uniform(0.08, 0.16)
    airy = "air" in request.absent or rng.random() < AIRY_SHARE
    air = rng.uniform(*DRAG_NEAR_PLATE) if airy else 0.0
    density = rng.uniform(1050, 1350)
    lone_drag, re_per_speed = drag_scale(axes, density)
    shared = {
        "tilt_off_deg": rng.normal(0, TILT_SD_DEG),
        "scale_off": rng.normal(0, scale_sd),
        "travel_mm": float(round(rng.uniform(50, 90))),
        "fps": float(rng.choice([120.0, 240.0, 500.0])),
        "shake_hz": rng.uniform(15, 40),
        "shade": rng.uniform(*SHADE),
        "readings": int(rng.integers(10, 16)) if read else 0,
        "reading_grid_deg": float(rng.choice(GRIDS_DEG, p=GRID_SHARES)),
        "reading_lift": float(rng.choice(LIFTS, p=LIFT_SHARES)),
        "column_grid_deg": float(rng.choice(COLUMN_GRIDS, p=COLUMN_SHARES)),
        "distance_mm": draw_distance_mm(rng),
        "lot_mu": mu,
        "mass": np.pi / 6 * np.prod(axes) * 1e-9 * density,
        "lone_drag": lone_drag,
        "re_per_speed": re_per_speed,
        "air": air,
        "stribeck_m_s": stribeck_m_s,
    }
    worlds = tuple(World(**run, **shared) for run in runs)
    toml = bench_keys(axes, density, airy)
    return Scene(worlds, request, toml, noise, scale_sd)


def visibility(scene: Scene, name: str) -> Visibility:
    """How visible the effect `name` is beside the others."""
    if scene.worlds[0].readings:
        return _visible_in_readings(scene)
    stated = scene.request.known
    rate_sd = stated("slide.tilt_rate_deg_s", RATE_SD, np.inf)
    if recorded := "track.tilt_deg" not in scene.request.absent:
        tilt_sd = max(scene.worlds[0].column_grid_deg / 8, 1e-4)
    else:
        tilt_sd = stated("slide.start_deg", START_SD_DEG, UNSTATED_START_SD_DEG)
    own = {"offset": np.inf, "mu": RUN_SD, "start_deg": tilt_sd}
    shared = {
        "mu": np.inf,
        "start_deg": TILT_SD_DEG,
        "scale": known_scale(scene.request, scene.scale_sd),
    }
    steps = {"mu": 1e-6, "start_deg": 1e-4, "rate_deg_s": 1e-5}
    if scene.worlds[0].air > 0:
        shared["air"] = DRAG_NEAR_PLATE_SD[not scene.request.sizes_known()]
        shared["shade"] = SHADE_SD
        steps |= {"air": 0.5, "shade": 0.05}
    changes = []
    for world in scene.worlds:
        here, bare = _as_recorded(world), _as_recorded(world._replace(**{name: 0.0}))
        t = times(world)
        onset = partial(_onset_s, t=t)
        near = matched(onset, onset(here), bare, mu=(0.0, 2 * here.mu + 0.5))
        rows = partial(_travel, t=t[: simulate(here, t)[1]])
        columns = slopes(rows, here, steps)
        change = rows(here) - rows(near) + (near.mu - bare.mu) * columns["mu"]
        columns |= {"offset": np.ones_like(change), "scale": rows(here)}
        rate = rate_sd * here.rate_deg_s
        if recorded:  # a straight line through it tells level and rate, in the middle
            rate = min(rate, math.sqrt(12) * tilt_sd / t[-1])
            columns["rate_deg_s"] -= columns["start_deg"] * t[-1] / 2
        changes.append(Change(change, columns, own | {"rate_deg_s": rate}, shared))
    fit = fitted(changes, scene.noise)
    # at which value of a condition friction is to be compared nobody says
    comparable = name not in ("follows", "order_drift")
    return Visibility(fit.snr, fit.shared_in_sds["mu"] if comparable else None)


def _travel(world: Any, t: np.ndarray) -> np.ndarray:
    """Travel (1, n) [mm] at times t, on a plate that is long enough."""
    return simulate(world._replace(travel_mm=np.inf), t)[0][None]


def _as_recorded(world: Any) -> Any:
    """In the recorded tilt's own terms an offset is a plate that was elsewhere."""
    off_deg = world.clock_offset * world.rate_deg_s - world.angle_offset
    return world._replace(start_deg=world.start_deg + off_deg)


def _onset_s(world: Any, t: np.ndarray) -> float:
    """When the block has gone 0.3 mm."""
    x, n = simulate(world, t)
    return float(np.interp(0.3, x[:n], t[:n]))


def _visible_in_readings(scene: Scene) -> Visibility:
    """Of a reading's delay: what it adds to the angles, beside a friction of any
    size."""
    one = scene.worlds[0]
    scatter = np.degrees(RUN_SD * np.cos(np.arctan(one.lot_mu)) ** 2)
    scatter = float(np.hypot(scatter, READING_SD_DEG))
    sd = mean_sd_deg(one.reading_grid_deg, scatter, one.readings)
    shift = [overshoot_deg(world) for world in scene.worlds]
    per_sd = {"friction": np.array([[1 / sd]])}
    free = {"friction": np.inf}
    changes = [Change(np.array([[s / sd]]), per_sd, {}, free) for s in shift]
    moved = np.mean(shift) / np.hypot(sd / np.sqrt(len(shift)), TILT_SD_DEG)
    return Visibility(fitted(changes, WHITE).snr, float(moved))


def overshoot_deg(world: Any) -> float:
    """By how much the plate has tilted on when the block has gone the reading's delay:
    x = g Ω (cos θ + μ sin θ) t³ / 6."""
    theta, rate = np.arctan(world.lot_mu), np.radians(world.rate_deg_s)
    grows = np.cos(theta) + world.lot_mu * np.sin(theta)
    t = (6 * world.reading_delay * 1e-3 / (G_M_S2 * rate * grows)) ** (1 / 3)
    return float(world.rate_deg_s * t)


def record(scene: Scene, world: Any, name: str) -> Recording:
    """What is filmed, or read, of one slide."""
    rng = np.random.default_rng(world.noise_seed)
    slide = {"tilt_rate_deg_s": world.stated_deg_s, "travel_mm": int(world.travel_mm)}
    toml = {"session": "day-1", "seed": {"count": world.seeds}, "slide": slide}
    if world.readings:
        toml["reading"] = {"resolution_deg": world.reading_grid_deg}
        read = pd.DataFrame({"slide_angle_deg": _read(world, rng)})
        return Recording(name, toml, readings=read)
    away = stated_distance_mm(world.distance_mm, rng)
    pixel = scene.noise.pixel
    toml["camera"] = camera_keys(pixel, scene.scale_sd, fps=world.fps, distance_mm=away)
    slide["start_mm"] = 1e3 * world.hinge_m
    if "track.tilt_deg" in scene.request.absent:
        start = world.start_deg + rng.normal(0, START_SD_DEG)
        slide["start_deg"] = round(float(start), 1)
    x, n = simulate(world, times(world))
    t, x = times(world)[:n], x[:n] / (1 + world.scale_off)
    tilt = partial(recorded_tilt, world, t)
    place = (t.round(6), x, np.zeros(n), scene.noise)
    return Recording(name, toml, track=tracked(*place, rng, tilt_deg=tilt))


def _read(world: Any, rng: np.random.Generator) -> np.ndarray:
    """Angles that somebody read [deg], each of a slide of its own."""
    mu = world.lot_mu + rng.normal(0, RUN_SD, world.readings)
    scatter = rng.normal(0, READING_SD_DEG, world.readings)
    angle = np.degrees(np.arctan(mu)) + world.tilt_off_deg + scatter
    angle += overshoot_deg(world)
    return on_grid(angle, world.reading_grid_deg, world.reading_lift)


def recorded_tilt(world: Any, t: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The tilt that is recorded at times t [deg]."""
    steady = np.radians(world.start_deg + world.rate_deg_s * (t - world.clock_offset))
    stair = np.radians(world.stepped_tilt)
    tilt = np.degrees([tilted(angle, 0.0, stair)[0] for angle in steady])
    tilt += world.tilt_off_deg + world.angle_offset + rng.normal(0, 0.005, len(t))
    if world.column_grid_deg:
        return on_grid(tilt, world.column_grid_deg)
    return tilt.round(4)


CASES = Cases(
    rig="slide",
    share=0.18,
    colour="#d9730d",
    effects=EFFECTS,
    draw=draw,
    visibility=visibility,
    record=record,
    design=("stated_deg_s", "seeds"),
    follows="static_friction",
    singles=(
        "kinetic-friction",
        "viscous-sliding",
        "adhesion",
        "reading-delay",
        "clock-offset",
        "plate-vibration",
        "partial-rolling",
        "stepped-tilt",
    ),
    need_separation=("adhesion", "clock-offset"),
    confounded=("stribeck",),
    separable=("clock-offset", "adhesion", "stribeck"),
    pairs=(
        ("kinetic-friction", "viscous-sliding"),
        ("clock-offset", "kinetic-friction"),
        ("adhesion", "viscous-sliding"),
    ),
)
