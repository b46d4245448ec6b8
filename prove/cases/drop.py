"""Drops: ellipsoids of one lot fall on one plate, filmed in one or two sessions."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from benchtwin.prove.cases import ellipsoid as body
from benchtwin.prove.cases.bench import Request, log_uniform
from benchtwin.prove.cases.camera import Camera, true_times
from benchtwin.prove.cases.drop_effects import (
    FOLLOWS,
    IN_CAMERA,
    Air,
    flight_changes,
    impact_changes,
)
from benchtwin.prove.cases.flight_laws import drag_number, impact_array, law_array
from benchtwin.prove.cases.noise import Noise, draw_noise
from benchtwin.prove.cases.stated import (
    AIR_DENSITY,
    AIR_VISCOSITY,
    UNSTATED_PLUMB_SD_DEG,
    drag_scale,
    draw_distance_mm,
    draw_scale_sd,
    stated_distance_mm,
)

CONTACT_S = 1e-4  # half a swing of seed on plate; Hertz at 1 GPa: 0.07 ms
LEAST_IMPACT_M_S = 0.22
RUN_SD = 0.003  # of one seed's restitution about the lot's
PUSH_SD_M_S, DEPTH_SD_MM = 0.01, 0.5  # of a release: sideways and to the camera
SHAPES = (
    ((0.985, 0.985), (0.998, 0.998)),
    ((0.94, 0.94), (0.985, 0.985)),
    ((0.78, 0.68), (0.9, 0.78)),
)
TURNING = {
    "magnus",
    "silhouette-wobble",
    "shape-conversion",
}  # without the seed's turning there is nothing to tell them by
HEIGHTS_MM = (
    (310.0,),
    (310.0, 100.0, 30.0),
    (310.0, 150.0),
    (250.0, 60.0),
    (200.0,),
    (310.0,),
)


@dataclass(frozen=True)
class Run:
    """One drop: height of the lowest point [mm] as it was, as stated; the seed's half
    axes [m], orientation, spin [rad/s]."""

    height_mm: float
    stated_mm: float
    axes: tuple[float, float, float]
    turned: tuple[float, float, float, float]
    spin: tuple[float, float, float]
    pull: float  # this seed's drag over the lot's
    e_off: float  # its restitution
    # and its release, sideways and away from the camera [m/s]
    push: tuple[float, float]
    depth_mm: float  # so far behind the plane that the scale is stated for
    held_s: float  # in view before the release; negative: the recording begins after it
    session: int
    noise_seed: int
    follows: float = 0.0


@dataclass(frozen=True)
class Scene:
    """All that a case has beside its effects. stated_axes_mm: length, width, thickness
    of the lot, full."""

    runs: tuple[Run, ...]
    stated_axes_mm: tuple[float, float, float]
    density: float
    e: float
    friction: float
    air: Air
    cameras: tuple[Camera, ...]
    scale_sd: float
    plumb_sd_deg: float
    noise: Noise
    angle_sd_deg: float | None
    fps: float
    mm_per_px: float
    most_bounces: int
    field_m: float
    one_session: bool  # a camera's effect is in the first session only
    stated_distance_mm: tuple[float, ...]
    request: Request


@dataclass(frozen=True, eq=False)
class SimulatedDrop:
    """A drop as it was: frames' stated times (from the first), true times, states (n,
    13), impacts, and its world."""

    run: Run
    stated_s: np.ndarray
    true_s: np.ndarray
    rows: np.ndarray
    log: np.ndarray
    law: np.ndarray
    impact: np.ndarray
    camera: Camera


def draw(request: Request, rng: np.random.Generator) -> Scene:
    """A bench with everything that is always open drawn as a good bench leaves it."""
    length = rng.uniform(6.0, 10.0)
    flat = rng.uniform(*SHAPES[rng.integers(len(SHAPES))])  # mustard, pea, bean
    axes_mm = (length, length * max(flat), length * min(flat))
    density, fps = rng.uniform(1050, 1350), float(rng.choice([1000.0, 2000.0, 5200.0]))
    if request.rendered:
        fps = float(rng.choice([400.0, 500.0]))
    airy = bool({"draught", "magnus", "updraught"} & set(request.effects)) or (
        "drag" not in request.effects
        and ("air" in request.absent or rng.random() < 0.6)
    )
    heights = (
        (310.0, 100.0, 30.0)
        if request.separated
        else (310.0,)
        if request.separated is False
        else HEIGHTS_MM[rng.integers(6)]
    )
    sessions = (
        2
        if request.separated
        or (not set(IN_CAMERA) & set(request.effects) and rng.random() < 0.25)
        else 1
    )
    count = 3 if request.rendered else int(rng.integers(6, 10))
    if request.rendered:
        heights = (110.0, 60.0) if len(heights) > 1 else (110.0,)
    pixel = 0.3 if request.rendered else float(rng.uniform(0.15, 0.3))
    scale_sd, plumb_sd = draw_scale_sd(request, rng), _draw_plumb_sd(request, rng)
    noise = draw_noise(rng, sd=(0.02, 0.09), pixel=pixel)
    if request.rendered:
        noise = Noise(0.03 * pixel, 0.0, 1.0, np.inf, 0.0, pixel, 0.0)
    size, re_per_speed = drag_scale(axes_mm, density)
    # over weight at 2 m/s
    plain = size * drag_number(re_per_speed * 2) * 4 / body.G_M_S2
    lot = (1 + rng.normal(0, 0.14)) * plain
    runs = tuple(
        _run(heights[i % len(heights)], axes_mm, sessions, i, count, fps, rng)
        for i in range(count)
    )
    cameras = tuple(
        _camera(request, max(heights) / 2, scale_sd, plumb_sd, rng)
        for _ in range(sessions)
    )
    return Scene(
        runs,
        axes_mm,
        density,
        rng.uniform(0.42, 0.66),
        rng.uniform(0.15, 0.45),
        Air(
            lot if airy else 0.0,
            _magnus_unit(axes_mm, density),
            AIR_DENSITY if airy else 0.0,
        ),
        cameras,
        scale_sd,
        plumb_sd,
        noise,
        _angle_sd(request, flat, rng),
        fps,
        pixel,
        4 if request.rendered else 6,
        float(rng.choice([-1, 1]) * rng.uniform(0.05, 0.2)),
        bool(request.separated),
        tuple(stated_distance_mm(camera.distance_mm, rng) for camera in cameras),
        request,
    )


def _angle_sd(request: Request, flat, rng: np.random.Generator) -> float | None:
    """How well the silhouette's angle is read [deg], the worse the rounder; None:
    nobody looked."""
    looked = rng.random() < 0.8 or bool(TURNING & set(request.effects))
    return 0.4 / (1.02 - min(flat)) * rng.uniform(0.3, 1.0) if looked else None


def _magnus_unit(axes_mm, density) -> float:
    r = np.prod(axes_mm) ** (1 / 3) * 5e-4
    return AIR_DENSITY * np.pi * r**3 / (2 * density * 4 / 3 * np.pi * r**3)


def _run(stated_mm, axes_mm, sessions, i, count, fps, rng) -> Run:
    turned = rng.normal(size=4)
    turned = turned / np.linalg.norm(turned)
    axes = np.array(axes_mm) * 5e-4 * (1 + rng.normal(0, 0.012, 3))
    spin = rng.normal(0, rng.choice([2.0, 15.0]), 3)
    return Run(
        float(stated_mm + np.clip(rng.normal(0, 1), -2.5, 2.5)),
        stated_mm,
        tuple(axes),
        tuple(turned),
        tuple(spin),
        float(1 + rng.normal(0, 0.01)),
        float(rng.normal(0, RUN_SD)),
        tuple(rng.normal(0, PUSH_SD_M_S, 2).tolist()),
        float(rng.normal(0, DEPTH_SD_MM)),
        float(rng.uniform(-0.02, 0.02)),
        int(i * sessions >= count) if sessions > 1 else 0,
        int(rng.integers(2**62)),
    )


def _draw_plumb_sd(request: Request, rng: np.random.Generator) -> float:
    """sd [deg] of the plumb that is stated, or of a camera that was set up by eye."""
    if "camera.plumb_deg" in request.absent:
        return UNSTATED_PLUMB_SD_DEG
    if "camera.plumb_sd_deg" in request.absent:
        return log_uniform(0.05, UNSTATED_PLUMB_SD_DEG, rng)
    return log_uniform(0.02, 0.1, rng)


def _camera(request: Request, middle_mm, scale_sd, plumb_sd, rng) -> Camera:
    if "camera.plumb_deg" in request.absent or rng.random() < 0.6:
        plumb_deg = 0.0
    else:
        plumb_deg = float(rng.uniform(-2, 2))
    return Camera(
        (float(rng.uniform(-5, 5)), middle_mm),
        middle_mm + 20,
        plumb_deg=plumb_deg,
        scale_error=rng.normal(0, scale_sd),
        roll_deg=rng.normal(0, plumb_sd),
        perspective=rng.normal(0, 1e-3),
        distortion=rng.normal(0, 2e-4),
        distance_mm=draw_distance_mm(rng),
    )


def fly_all(scene: Scene, sizes: dict[str, float]) -> list[SimulatedDrop]:
    """Every drop of the scene with these effects."""
    return [_fly(scene, run, tuple(sorted(sizes.items()))) for run in scene.runs]


@lru_cache(maxsize=64)
def _fly(scene: Scene, run: Run, items: tuple) -> SimulatedDrop:
    sizes = dict(items)
    axes = np.array(run.axes)
    if "shape-conversion" in sizes:
        axes = axes * (1 + sizes["shape-conversion"] * np.array([1.0, 0.0, -1.0]))
    mass = 4 / 3 * np.pi * axes.prod() * scene.density
    inertia = mass / 5 * (np.sum(axes**2) - axes**2)
    law, impact, camera = world(scene, run, sizes)
    tilt = np.radians(sizes.get("plate-tilt", 0.0))
    normal = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    film = 0.5 * mass * sizes.get("film-adhesion", 0.0) ** 2
    plate = np.array(
        [*normal, scene.friction, mass * (np.pi / CONTACT_S) ** 2, film, mass]
    )
    state = np.zeros(13)
    state[3:5], state[6:10], state[10:13] = run.push, run.turned, run.spin
    state[1] = run.depth_mm * 1e-3
    state[2] = (
        run.height_mm * 1e-3
        + body.lowest(body.rotation(state[6:10]), axes, np.array([0.0, 0.0, 1.0]))[0]
    )
    longest = 5.0 * np.sqrt(2 * run.height_mm * 1e-3 / body.G_M_S2)
    stated = np.arange(int(longest * scene.fps)) / scene.fps
    true = true_times(camera, stated) - run.held_s  # the release is at zero
    flying = true >= 0
    rows = np.tile(state, (len(true), 1))
    flown, log, reached = body.fly(
        state,
        np.r_[0.0, true[flying]],
        axes,
        inertia,
        plate,
        law,
        impact,
        scene.most_bounces,
        LEAST_IMPACT_M_S,
    )
    first = len(true) - flying.sum()
    rows[first : first + reached - 1] = flown[1:reached]
    rows = rows[: first + reached - 1]
    n = len(rows)
    return SimulatedDrop(run, stated[:n], true[:n], rows, log, law, impact, camera)


def world(
    scene: Scene, run: Run, sizes: dict[str, float]
) -> tuple[np.ndarray, np.ndarray, Camera]:
    """Flight law, impact law and camera of one drop with these effects."""
    size = np.prod(run.axes) ** (1 / 3) * 2
    changes = flight_changes(sizes, scene.air)
    changes["drag"] *= run.pull
    law = law_array(
        gravity=body.G_M_S2,
        re_per_speed=AIR_DENSITY * size / AIR_VISCOSITY,
        field_centre=scene.field_m,
        **changes,
    )
    camera = scene.cameras[run.session]
    for name, key in IN_CAMERA.items():
        if name in sizes and not (scene.one_session and run.session):
            camera = replace(camera, **{key: getattr(camera, key) + sizes[name]})
    followed = sum(sizes.get(name, 0.0) for name in FOLLOWS)
    e = scene.e + run.e_off + run.follows * followed
    return law, impact_array(**impact_changes(sizes, e)), camera
