"""Drops: ellipsoids of one lot fall on one plate, filmed in one or two sessions.

Effects, fields of a world by their names: drag: force over weight at 2 m/s, ≥ 0.
magnus: C in a = C (ρ A r / 2m) ω × v, vectors in space. draught: wind towards +x. The
laws of restitution: e(0.5 m/s) − e(2 m/s), > 0 when it falls. film_adhesion: √(2W/m).
impact_damage: e × (1 + η) with every impact, η < 0 when the seed loses. plate_tilt: the
plate falls towards +x. shape_conversion: length so much longer, thickness shorter. The
camera's: see camera.py. Outside: updraught [1/s] of rising air per metre of height;
field [1/s²] away from a place beside the rig; oriented_restitution: relative, upright
landing minus flat. follows, order_drift: change of e over half the range of a
condition, of the order."""

from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from benchtwin.prove.cases import ellipsoid as body
from benchtwin.prove.cases.air import AIR_DENSITY, G_M_S2, drag_number, drag_scale
from benchtwin.prove.cases.bench import Recording, Request, Scene, log_uniform
from benchtwin.prove.cases.camera import Camera, magnification, project, true_times
from benchtwin.prove.cases.flight_laws import SPEED_M_S, fading
from benchtwin.prove.cases.noise import Noise, draw_noise, tracked
from benchtwin.prove.cases.picture import film
from benchtwin.prove.cases.record import Effect, field_of, world_with
from benchtwin.prove.cases.stated import (
    UNSTATED_PLUMB_SD_DEG,
    bench_keys,
    camera_keys,
    draw_distance_mm,
    draw_scale_sd,
    stated_distance_mm,
)

CONTACT_S = 1e-4  # half a swing of seed on plate; Hertz at 1 GPa: 0.07 ms
RUN_SD = 0.003  # of one seed's restitution about the lot's
PUSH_SD_M_S, DEPTH_SD_MM = 0.01, 0.5  # of a release: sideways and to the camera
SHAPES = (
    ((0.985, 0.985), (0.998, 0.998)),
    ((0.94, 0.94), (0.985, 0.985)),
    ((0.78, 0.68), (0.9, 0.78)),
)
# without the seed's turning there is nothing to tell them by
TURNING = {"magnus", "silhouette-wobble", "shape-conversion"}
HEIGHTS_MM = (
    (310.0,),
    (310.0, 100.0, 30.0),
    (310.0, 150.0),
    (250.0, 60.0),
    (200.0,),
    (310.0,),
)
WIDE = 16 / 9  # a picture's width over its height
ORIGIN_MM = (40.0, 12.0)  # where the plate lies: the picture's corner is the origin
MIDDLE_M_S = 1.2  # restitution laws agree with the constant one here
STRENGTHS = {  # of a law: field of a world, the most that is believable
    "viscoelastic_restitution": ("viscous", 3.0),
    "plastic_restitution": ("yielding", 1.0),
    "plate_compliance": ("zener", 0.7),
}
IN_CAMERA = {  # effect → field of a camera
    "scale_error": "scale_error",
    "clock_error": "clock_error",
    "camera_roll": "roll_deg",
    "perspective": "perspective",
    "silhouette_wobble": "wobble_mm",
    "clock_drift": "clock_drift",
}
IN_FLIGHT = ("drag", "magnus", "draught", "updraught", "field")
EFFECTS = {
    "drag": Effect(("flight",), "1", 0.001, 0.15),
    "magnus": Effect(("flight",), "1", 0.1, 8.0, 0, either=True),
    "draught": Effect(("flight",), "m/s", 0.02, 2.5, 0, either=True),
    "restitution-falls-with-speed": Effect(("impact",), "1"),
    "viscoelastic-restitution": Effect(("impact",), "1", 0.01, 0.12),
    "plastic-restitution": Effect(("impact",), "1", 0.01, 0.12),
    "film-adhesion": Effect(("impact",), "m/s", 0.02, 0.3),
    "impact-damage": Effect(("impact",), "1", 0.005, 0.2, -1),
    "plate-tilt": Effect(("impact",), "deg", 0.03, 4.0, 0),
    "plate-compliance": Effect(("impact",), "1", 0.01, 0.12),
    "shape-conversion": Effect(("impact",), None, 0.03, 0.22),
    "scale-error": Effect(("measurement",), "1", 0.002, 0.06, 0),
    "clock-error": Effect(("measurement",), "1", 0.001, 0.06, 0),
    "camera-roll": Effect(("measurement",), "deg", 0.1, 5.0, 0),
    "perspective": Effect(("measurement",), "1/m", 0.004, 0.3, 0, either=True),
    "silhouette-wobble": Effect(("measurement",), "mm", 0.01, 0.6, 0, either=True),
    "updraught": Effect(("flight",), None, 0.02, 20.0, 0, listed=False),
    "field": Effect(("flight",), None, 0.01, 8.0, 0, listed=False),
    "oriented-restitution": Effect(("impact",), None, 0.03, 0.5, 0, listed=False),
    "clock-drift": Effect(("measurement",), None, 0.001, 0.2, 0, listed=False),
    "order-drift": Effect(("impact",), None, 0.001, 0.12, 0, listed=False),
    "follows": Effect(("impact",), None, 0.001, 0.12, 0),
}


class Drop(NamedTuple):
    """One drop, as it is without effects."""

    height_mm: float  # of the lowest point
    stated_mm: float
    axes: tuple[float, float, float]  # half axes [m]
    turned: tuple[float, float, float, float]  # quaternion
    spin: tuple[float, float, float]  # [rad/s]
    push: tuple[float, float]  # at the release, sideways and away from the camera [m/s]
    depth_mm: float  # so far behind the plane that the scale is stated for
    held_s: float  # in view before the release; negative: recorded after it
    session: int
    noise_seed: int
    pull: float  # this seed's drag over the lot's
    e: float
    air: float  # the lot's drag over weight at 2 m/s
    re_per_speed: float
    magnus_unit: float
    field_m: float
    density: float
    friction: float
    lot_axes_mm: tuple[float, float, float]  # full
    camera: Camera
    in_camera: float  # 1: what is wrong with a camera is, in this session; 0: is not
    stated_distance_mm: float
    angle_sd_deg: float  # inf: nobody looked
    fps: float
    most_bounces: int
    contact_s: float
    viscous: float
    yielding: float
    zener: float


World = world_with(EFFECTS, Drop)


class Path(NamedTuple):
    """A drop as it was: frames' stated times (from the first), true times, states (n,
    13), impacts, and its world with the strengths of its laws."""

    stated_s: np.ndarray
    true_s: np.ndarray
    rows: np.ndarray
    log: np.ndarray
    world: Any


def draw(request: Request, rng: np.random.Generator) -> Scene:
    """A bench with everything that is always open drawn as a good bench leaves it."""
    effects, rendered = set(request.effects), request.rendered
    length = rng.uniform(6.0, 10.0)
    flat = rng.uniform(*SHAPES[rng.integers(len(SHAPES))])  # mustard, pea, bean
    lot = np.array([length, length * max(flat), length * min(flat)])
    density, fps = rng.uniform(1050, 1350), float(rng.choice([1000.0, 2000.0, 5200.0]))
    if rendered:
        fps = float(rng.choice([400.0, 500.0]))
    airy = bool({"draught", "magnus", "updraught"} & effects) or (
        "drag" not in effects and ("air" in request.absent or rng.random() < 0.6)
    )
    if request.separated is None:
        heights = HEIGHTS_MM[rng.integers(6)]
    else:
        heights = HEIGHTS_MM[1] if request.separated else HEIGHTS_MM[0]
    filmed_wrongly = any(field_of(name) in IN_CAMERA for name in effects)
    two = request.separated or (not filmed_wrongly and rng.random() < 0.25)
    count = 3 if rendered else int(rng.integers(6, 10))
    if rendered:
        heights = (110.0, 60.0) if len(heights) > 1 else (110.0,)
    pixel = 0.3 if rendered else float(rng.uniform(0.15, 0.3))
    scale_sd, plumb_sd = draw_scale_sd(request, rng), _draw_plumb_sd(request, rng)
    noise = draw_noise(rng, sd=(0.02, 0.09), pixel=pixel)
    if rendered:
        noise = Noise(0.03 * pixel, 0.0, 1.0, np.inf, 0.0, pixel, 0.0)
    size, re_per_speed = drag_scale(lot, density)
    over_weight = size * drag_number(re_per_speed * SPEED_M_S) * SPEED_M_S**2 / G_M_S2
    air = (1 + rng.normal(0, 0.14)) * over_weight * airy
    runs = [_run(heights[i % len(heights)], lot, rng) for i in range(count)]
    middle = max(heights) / 2
    cameras = [
        _camera(request, middle, scale_sd, plumb_sd, rng) for _ in range(1 + bool(two))
    ]
    e, friction = rng.uniform(0.42, 0.66), rng.uniform(0.15, 0.45)
    looked = rng.random() < 0.8 or bool(TURNING & effects)
    rounder = 0.4 / (1.02 - min(flat))  # the worse its angle is read
    angle_sd_deg = rounder * rng.uniform(0.3, 1.0) if looked else np.inf
    field_m = float(rng.choice([-1, 1]) * rng.uniform(0.05, 0.2))
    stated = [stated_distance_mm(camera.distance_mm, rng) for camera in cameras]
    worlds = []
    for i, run in enumerate(runs):
        session = int(i * 2 >= count) if two else 0
        own = {
            "session": session,
            "camera": cameras[session],
            "stated_distance_mm": stated[session],
            "in_camera": float(not (request.separated and session)),
            "e": e + run.pop("e_off"),
            "re_per_speed": drag_scale(2e3 * np.array(run["axes"]), density)[1],
        }
        worlds.append(
            World(
                **run,
                **own,
                air=air,
                magnus_unit=AIR_DENSITY * 3 / 8 / density,
                field_m=field_m,
                density=density,
                friction=friction,
                lot_axes_mm=tuple(lot),
                angle_sd_deg=angle_sd_deg,
                fps=fps,
                most_bounces=4 if rendered else 6,
                contact_s=CONTACT_S,
                viscous=0.0,
                yielding=0.0,
                zener=0.0,
            )
        )
    toml = bench_keys(lot, density, airy)
    return Scene(tuple(worlds), request, toml, noise, scale_sd, plumb_sd)


def _run(stated_mm: float, lot_mm: np.ndarray, rng: np.random.Generator) -> dict:
    turned = rng.normal(size=4)
    axes = lot_mm * 5e-4 * (1 + rng.normal(0, 0.012, 3))
    spin = rng.normal(0, rng.choice([2.0, 15.0]), 3)
    return {
        "stated_mm": stated_mm,
        "height_mm": float(stated_mm + np.clip(rng.normal(0, 1), -2.5, 2.5)),
        "axes": tuple(axes),
        "turned": tuple(turned / np.linalg.norm(turned)),
        "spin": tuple(spin),
        "pull": float(1 + rng.normal(0, 0.01)),
        "e_off": float(rng.normal(0, RUN_SD)),
        "push": tuple(rng.normal(0, PUSH_SD_M_S, 2).tolist()),
        "depth_mm": float(rng.normal(0, DEPTH_SD_MM)),
        "held_s": float(rng.uniform(-0.02, 0.02)),
        "noise_seed": int(rng.integers(2**62)),
    }


def _draw_plumb_sd(request: Request, rng: np.random.Generator) -> float:
    """sd [deg] of the plumb that is stated, or of a camera that was set up by eye."""
    if "camera.plumb_deg" in request.absent:
        return UNSTATED_PLUMB_SD_DEG
    if "camera.plumb_sd_deg" in request.absent:
        return log_uniform(0.05, UNSTATED_PLUMB_SD_DEG, rng)
    return log_uniform(0.02, 0.1, rng)


def _camera(
    request: Request, middle_mm: float, scale_sd: float, plumb_sd: float, rng
) -> Camera:
    plumb = "camera.plumb_deg" not in request.absent and rng.random() >= 0.6
    return Camera(
        plumb_deg=float(rng.uniform(-2, 2)) if plumb else 0.0,
        centre_mm=(float(rng.uniform(-5, 5)), middle_mm),
        half_mm=middle_mm + 20,
        scale_error=rng.normal(0, scale_sd),
        roll_deg=rng.normal(0, plumb_sd),
        perspective=rng.normal(0, 1e-3),
        distortion=rng.normal(0, 2e-4),
        distance_mm=draw_distance_mm(rng),
    )


def with_strengths(world: Any) -> Any:
    """The world with the strengths of its laws of restitution, each of which passes
    through e in the middle."""
    e = world.e + world.followed * (world.follows + world.order_drift)
    for law in STRENGTHS:
        world = _with_strength(world, law, e)
    return world._replace(e=e / fading(MIDDLE_M_S, world))


def _with_strength(world: Any, law: str, e: float) -> Any:
    strength, most = STRENGTHS[law]

    def off(value: float) -> float:
        changed = world._replace(**{strength: value})
        slow, middle, fast = (fading(v, changed) for v in (0.5, MIDDLE_M_S, 2.0))
        return e * (slow - fast) / middle - getattr(world, law)

    if not getattr(world, law):
        return world
    return world._replace(**{strength: brentq(off, 0.0, most)})


def camera_of(world: Any) -> Camera:
    """The camera with its effects."""
    camera = world.camera
    wrong = {
        key: getattr(camera, key) + world.in_camera * getattr(world, name)
        for name, key in IN_CAMERA.items()
    }
    return camera._replace(**wrong)


@lru_cache(maxsize=64)
def simulate(world: Any) -> Path:
    """The seed's way from before its release to its last bounce, or out of the
    picture."""
    world = with_strengths(world)
    state = np.zeros(13)
    state[3:5], state[6:10], state[10:13] = world.push, world.turned, world.spin
    state[1] = world.depth_mm * 1e-3
    upwards = np.array([0.0, 0.0, 1.0])
    below, _ = body.lowest(body.rotation(state[6:10]), body.solid(world)[0], upwards)
    state[2] = world.height_mm * 1e-3 + below
    longest = 5.0 * np.sqrt(2 * world.height_mm * 1e-3 / G_M_S2)
    stated = np.arange(int(longest * world.fps)) / world.fps
    true = true_times(camera_of(world), stated) - world.held_s  # released at zero
    flown, log = body.fly(state, np.r_[0.0, true[true >= 0]], world)
    rows = np.vstack([np.tile(state, ((true < 0).sum(), 1)), flown[1:]])
    count = len(rows)
    whole = Path(stated[:count], true[:count], rows, log, world)
    seen = np.abs(places(whole, camera_of(world)))
    edge = world.camera.half_mm * np.array([[WIDE], [1.0]])
    count = int(np.argmax(np.append((seen > edge).any(axis=0), True)))
    log = log[log["end_s"] < true[count - 1]]
    return Path(stated[:count], true[:count], rows[:count], log, world)


def places(path: Path, camera: Camera) -> np.ndarray:
    """Places (2, n) of the seed in the picture of a camera [mm]."""
    turned = body.angle(body.outlines(path.rows, np.array(path.world.axes)))
    x, y, z = 1e3 * path.rows[:, :3].T
    return project(camera, x, z, turned, y)


def record(scene: Scene, world: Any, name: str) -> Recording:
    """The track of one drop with its noise, or frames."""
    rng, path = np.random.default_rng(world.noise_seed), simulate(world)
    camera, pixel = camera_of(world), scene.noise.pixel
    toml: dict = {
        "session": f"day-{world.session + 1}",
        "camera": camera_keys(
            pixel,
            scene.scale_sd,
            camera.plumb_deg,
            round(scene.plumb_sd_deg, 4),
            fps=world.fps,
            distance_mm=world.stated_distance_mm,
        ),
        "drop": {"height_mm": world.stated_mm, "height_sd_mm": 1.0},
    }
    place = places(path, camera)
    if scene.request.rendered:
        toml["camera"]["exposure_s"] = 1e-4
        shapes = body.outlines(path.rows, np.array(world.axes))
        larger = magnification(camera.distance_mm, 1e3 * path.rows[:, 1])
        outlines = shapes * ((1e3 / pixel * larger) ** 2)[:, None, None]
        frames = film(place.T / pixel, outlines, camera, pixel, rng)
        pictures = {f"frames/{i:06d}.png": frame for i, frame in enumerate(frames)}
        return Recording(name, toml, pictures=pictures)
    x, y = place[0] + ORIGIN_MM[0], place[1] + camera.centre_mm[1] + ORIGIN_MM[1]
    looked = np.isfinite(world.angle_sd_deg)
    read = {"angle_deg": partial(_read_angle, path)} if looked else {}
    t = np.round(path.stated_s, 7)
    return Recording(name, toml, track=tracked(t, x, y, scene.noise, rng, **read))


def _read_angle(path: Path, rng: np.random.Generator) -> np.ndarray:
    """The silhouette's angle [deg] as somebody reads it."""
    turned = body.angle(body.outlines(path.rows, np.array(path.world.axes)))
    misread = path.world.angle_sd_deg * rng.standard_normal(len(turned))
    return (np.degrees(turned) + misread).round(3)
