"""Slides: a block of taped seeds on a plate that tilts up, filmed beside a tilt sensor;
or only the angles that were read.

Signs. kinetic-friction: μ_s − μ_k. stribeck: μ at rest less μ at high speed.
viscous-sliding: dμ/dv. adhesion: pull towards the plate [mN], whatever the load.
reading-delay: the angle is read after so much travel [mm]. clock-offset: a tilt of true
time T is stamped T + offset. angle-offset: recorded less true tilt. plate-vibration:
amplitude along the plate [m/s²]. partial-rolling: added inertia over mass.
stepped-tilt: height of the stairs in which the plate climbs [deg]. worn-track: dμ/dx
[1/m]. follows, order-drift: change of μ over half the range of a condition, of the
order."""

import math
from dataclasses import dataclass

import numpy as np
import pandas as pd

from benchtwin.prove.cases import ground_motion as ground
from benchtwin.prove.cases.bench import Bench, Recording, Request
from benchtwin.prove.cases.noise import Noise, draw_noise, kept, noisy
from benchtwin.prove.cases.record import Cases, Effect
from benchtwin.prove.cases.snr import (
    Channel,
    RecordingChange,
    Visibility,
    fitted,
    scatter_snr,
)
from benchtwin.prove.cases.stated import (
    AIR_DENSITY,
    AIRY_SHARE,
    Reading,
    camera_keys,
    drag_scale,
    draw_distance_mm,
    draw_reading,
    draw_scale_sd,
    known_scale,
    stated_distance_mm,
)

TILT_SD_DEG, RUN_SD, READING_SD_DEG = 0.05, 0.003, 0.02
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
READ = ("reading-delay",)
FOLLOWS = ("follows", "order-drift")
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


@dataclass(frozen=True)
class Run:
    """One slide: how its plate is tilted, and how it differs from the others."""

    rate_deg_s: float
    start_deg: float  # the tilt at the film's first moment
    count: int
    mu_off: float
    hinge_m: float
    noise_seed: int
    follows: float = 0.0


@dataclass(frozen=True)
class Scene:
    """All that a case of slides has beside its effects."""

    runs: tuple[Run, ...]
    mu: float
    mass: float  # of a seed [kg]
    axes_mm: tuple[float, float, float]
    tilt_off_deg: float  # this session's own, as the next
    scale_off: float
    scale_sd: float
    travel_mm: float
    fps: float
    noise: Noise
    shake_hz: float
    stribeck_m_s: float
    air: float  # beside the plate, of free flight's; 0: none
    shade: float  # by how little it blows among others
    readings: int  # how many a recording holds; 0: it is filmed
    reading: Reading
    column_grid_deg: float
    distance_mm: float
    request: Request


def draw(request: Request, rng: np.random.Generator) -> Scene:
    """A scene of the requested effects: slides, their camera, and what is stated of
    them."""
    read = bool(set(READ) & set(request.effects)) or (
        not request.effects and rng.random() < 0.2
    )
    count = int(rng.integers(3, 5)) if read else int(rng.integers(5, 9))
    several = (
        request.separated or read or (request.separated is None and rng.random() < 0.5)
    )
    rates = (
        (0.5, 2.0, 5.0)
        if read
        else (1.0, 5.0)
        if several
        else (float(rng.choice([1.0, 2.0, 4.0])),)
    )
    loads = [4]
    if "adhesion" in request.effects or (several and rng.random() < 0.4):
        loads = [2, 8]
    length = rng.uniform(6, 10)
    axes = (
        round(length, 2),
        round(length * rng.uniform(0.75, 0.95), 2),
        round(length * rng.uniform(0.65, 0.74), 2),
    )
    pixel = float(rng.uniform(0.08, 0.3))
    scale_sd = draw_scale_sd(request, rng)
    mu = rng.uniform(0.25, 0.5)
    # it may let go so much sooner
    ahead = 3.5 if set(FOLLOWS) & set(request.effects) or rng.random() < 0.2 else 0.0
    runs = tuple(
        Run(
            rate,
            float(
                np.degrees(np.arctan(mu)) - _margin(rate) - ahead - rng.uniform(0, 0.5)
            ),
            loads[i // 2 % len(loads)],
            float(rng.normal(0, RUN_SD)),
            round(float(rng.uniform(0.12, 0.25)), 3),
            int(rng.integers(2**62)),
        )
        for i, rate in enumerate((rates * count)[:count])
    )
    filmed = draw_noise(rng, sd=(0.015, 0.06), pixel=pixel)
    if request.separated is False:
        stribeck = rng.uniform(0.004, 0.01)
    else:
        stribeck = rng.uniform(0.08, 0.16)
    if "air" in request.absent or rng.random() < AIRY_SHARE:
        air = rng.uniform(*DRAG_NEAR_PLATE)
    else:
        air = 0.0
    return Scene(
        runs=runs,
        mu=mu,
        mass=np.pi / 6 * math.prod(axes) * 1e-9 * rng.uniform(1050, 1350),
        axes_mm=axes,
        tilt_off_deg=rng.normal(0, TILT_SD_DEG),
        scale_off=rng.normal(0, scale_sd),
        scale_sd=scale_sd,
        travel_mm=round(float(rng.uniform(50, 90))),
        fps=float(rng.choice([120.0, 240.0, 500.0])),
        noise=filmed,
        shake_hz=rng.uniform(15, 40),
        stribeck_m_s=stribeck,
        air=air,
        shade=rng.uniform(*SHADE),
        readings=int(rng.integers(10, 16)) if read else 0,
        reading=draw_reading(rng),
        column_grid_deg=float(rng.choice(COLUMN_GRIDS, p=COLUMN_SHARES)),
        distance_mm=draw_distance_mm(rng),
        request=request,
    )


def block(
    scene: Scene,
    run: Run,
    sizes: dict[str, float],
    mu_more: float = 0.0,
    air_more: float = 0.0,
) -> np.ndarray:
    """The block as ground_motion.slide takes it. air_more: of free flight's, on each
    seed."""
    followed = sum(sizes.get(name, 0.0) for name in FOLLOWS)
    mu = scene.mu + run.mu_off + mu_more + run.follows * followed
    out = np.zeros(ground.BLOCK)
    out[[ground.STATIC, ground.KINETIC]] = mu
    out[ground.KINETIC] -= sizes.get("kinetic-friction", 0.0) + sizes.get(
        "stribeck", 0.0
    )
    out[ground.FALLING] = sizes.get("stribeck", 0.0)
    out[ground.STRIBECK_SPEED] = scene.stribeck_m_s
    out[ground.VISCOUS] = sizes.get("viscous-sliding", 0.0)
    out[ground.WORN] = sizes.get("worn-track", 0.0)
    out[ground.PULL] = sizes.get("adhesion", 0.0) * 1e-3 / (run.count * scene.mass)
    out[ground.SHAKE] = sizes.get("plate-vibration", 0.0)
    out[ground.SHAKE_HZ] = scene.shake_hz
    out[ground.ADDED] = sizes.get("partial-rolling", 0.0)
    out[ground.HINGE] = run.hinge_m
    out[ground.STAIR] = np.radians(sizes.get("stepped-tilt", 0.0))
    lone, out[ground.REYNOLDS] = drag_scale(
        scene.axes_mm, scene.mass / (np.pi / 6 * math.prod(scene.axes_mm) * 1e-9)
    )
    out[ground.AIR] = lone * (scene.air * run.count**-scene.shade + air_more)
    return out


def _margin(rate_deg_s: float) -> float:
    """A film begins so long [deg] before the block may let go."""
    return min(4.0, max(1.2, 0.8 * rate_deg_s))


def times(scene: Scene, run: Run) -> np.ndarray:
    """Frame times from the film's beginning."""
    span = np.degrees(np.arctan(scene.mu)) - run.start_deg + 14
    return np.arange(int(span / run.rate_deg_s * scene.fps)) / scene.fps


def travel(
    scene: Scene,
    run: Run,
    sizes: dict[str, float],
    mu_more: float = 0.0,
    tilt_more: float = 0.0,
    air_more: float = 0.0,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(times, travel [mm], speed [mm/s]) up to the travel's end."""
    t = times(scene, run)
    args = (
        np.radians(run.start_deg + tilt_more),
        np.radians(run.rate_deg_s),
        block(scene, run, sizes, mu_more, air_more),
    )
    x, v, n = ground.slide(t, *args, scene.travel_mm * 1e-3)
    return t[:n], 1e3 * x[:n], 1e3 * v[:n]


def visibility(scene: Scene, sizes: dict[str, float], name: str) -> Visibility:
    """How visible `name` is in the world of all `sizes`."""
    if scene.readings:
        return _visible_in_readings(scene, sizes, name)
    recordings, without = [], {k: v for k, v in sizes.items() if k != name}
    like = [_same_onset(scene, run, sizes, without) for run in scene.runs]
    mean = float(np.mean(like))
    for run, more in zip(scene.runs, like, strict=True):
        with_tilt, other_tilt = _tilt_off(sizes, run), _tilt_off(without, run)
        base = travel(scene, run, sizes, tilt_more=with_tilt)[1]
        n = len(base)
        shifted = travel(scene, run, without, mu_more=more, tilt_more=other_tilt)[1]
        moved = [_padded(shifted, n)]
        moved += [
            _padded(travel(scene, run, sizes, mu_more=1e-4, tilt_more=with_tilt)[1], n),
            _padded(travel(scene, run, sizes, tilt_more=with_tilt + 2e-3)[1], n),
            _padded(travel(scene, run, sizes, tilt_more=with_tilt, air_more=0.5)[1], n),
        ]
        mu, tilt = (moved[1] - base) / 1e-4, (moved[2] - base) / 2e-3
        own = np.column_stack([np.ones(n), mu, tilt])
        air = (moved[3] - base) / 0.5 * bool(scene.air)
        lone = run.count**-scene.shade
        shade = scene.air * math.log(run.count) * run.count**-scene.shade
        shared = np.column_stack([mu, tilt, base, lone * air, shade * air])
        track = Channel(base - moved[0], own, shared)
        # its friction is the pair's within RUN_SD: that it was moved to let go at the
        # same moment is paid for by one more row
        unit = scene.noise.sd / RUN_SD
        change = np.array([(mean - more) * unit])
        friction = Channel(change, np.array([[0.0, unit, 0.0]]), np.zeros((1, 5)))
        own_sd = np.array([np.inf, np.inf, _own_tilt_sd(scene)])
        recordings.append(RecordingChange((track, friction), own_sd))
    beside = DRAG_NEAR_PLATE_SD[not scene.request.sizes_known()]
    scale_sd = known_scale(scene.request, scene.scale_sd)
    known = np.array([np.inf, TILT_SD_DEG, scale_sd, beside, SHADE_SD])
    fit = fitted(recordings, known, scene.noise)
    # at which value of a condition friction is to be compared nobody says
    comparable = name not in FOLLOWS
    return Visibility(
        fit.snr,
        (mean + float(fit.shared[0])) / float(fit.shared_sd[0]) if comparable else None,
    )


def _own_tilt_sd(scene: Scene) -> float:
    """How well each recording's tilt is known beside the others' [deg]: by its column,
    else by the start that is stated."""
    if "track.tilt_deg" in scene.request.absent:
        return scene.request.known(
            "slide.start_deg", START_SD_DEG, UNSTATED_START_SD_DEG
        )
    return max(scene.column_grid_deg / 8, 1e-4)


def _tilt_off(sizes: dict[str, float], run: Run) -> float:
    """In the recorded tilt's own terms an offset is a plate that was elsewhere, by so
    much [deg]."""
    return sizes.get("clock-offset", 0.0) * run.rate_deg_s - sizes.get(
        "angle-offset", 0.0
    )


def _same_onset(
    scene: Scene, run: Run, sizes: dict[str, float], without: dict[str, float]
) -> float:
    """More friction with which the block without the effect lets go as with it."""

    def onset(effects, more: float) -> float:
        t, x, _ = travel(
            scene, run, effects, mu_more=more, tilt_more=_tilt_off(effects, run)
        )
        return run.start_deg + run.rate_deg_s * float(np.interp(0.3, x, t))

    wanted, more = np.tan(np.radians(onset(sizes, 0.0))), 0.0
    for _ in range(3):
        more += wanted - np.tan(np.radians(onset(without, more)))
    return float(more)


def _padded(x: np.ndarray, n: int) -> np.ndarray:
    """The first n values; one that ended sooner goes on at its last speed."""
    if len(x) >= n:
        return x[:n]
    return np.r_[x, x[-1] + (x[-1] - x[-2]) * np.arange(1, n - len(x) + 1)]


def _visible_in_readings(
    scene: Scene, sizes: dict[str, float], name: str
) -> Visibility:
    """Of a reading's delay: what it adds to the angles, beside a friction of any
    size."""
    shift = np.array(
        [overshoot_deg(scene.mu, run.rate_deg_s, sizes[name]) for run in scene.runs]
    )
    scatter = np.hypot(
        np.degrees(RUN_SD * np.cos(np.arctan(scene.mu)) ** 2), READING_SD_DEG
    )
    sd = scene.reading.mean_sd_deg(float(scatter), scene.readings)
    snr = scatter_snr(shift, np.full(len(shift), sd), np.ones((len(shift), 1)))
    moved = float(shift.mean()) / float(np.hypot(sd / np.sqrt(len(shift)), TILT_SD_DEG))
    return Visibility(snr, moved)


def overshoot_deg(mu: float, rate_deg_s: float, delay_mm: float) -> float:
    """By how much the plate has tilted on when the block has gone `delay_mm`: x = g Ω
    (cos θ + μ sin θ) t³ / 6."""
    theta, rate = np.arctan(mu), np.radians(rate_deg_s)
    grows = np.cos(theta) + mu * np.sin(theta)
    t = (6 * delay_mm * 1e-3 / (ground.G_M_S2 * rate * (grows))) ** (1 / 3)
    return float(rate_deg_s * t)


def bench(scene: Scene, sizes: dict[str, float]) -> Bench:
    """The bench folder of a scene with these effects."""
    seed = dict(zip(("length_mm", "width_mm", "thickness_mm"), scene.axes_mm)) | {
        "mass_g": float(f"{scene.mass * 1e3:.4g}")
    }
    air = {"density_kg_m3": AIR_DENSITY if scene.air > 0 else 0.0}
    toml = {"provenance": "measured", "seed": seed, "air": air}
    return Bench(
        toml, tuple(_recording(scene, sizes, i) for i in range(len(scene.runs)))
    )


def _recording(scene: Scene, sizes: dict[str, float], i: int) -> Recording:
    run, rng = scene.runs[i], np.random.default_rng(scene.runs[i].noise_seed)
    name = f"slide-{i + 1:02d}"
    toml: dict = {
        "rig": "slide",
        "id": name,
        "session": "day-1",
        "seed": {"count": run.count},
        "slide": {"tilt_rate_deg_s": run.rate_deg_s, "travel_mm": scene.travel_mm},
    }
    if scene.readings:
        toml["reading"] = {"resolution_deg": scene.reading.grid_deg}
        return Recording(
            name,
            toml,
            readings=pd.DataFrame({"slide_angle_deg": _read(scene, run, sizes, rng)}),
        )
    away = stated_distance_mm(scene.distance_mm, rng)
    toml["camera"] = camera_keys(
        scene.noise.pixel, scene.scale_sd, fps=scene.fps, distance_mm=away
    )
    toml["slide"]["start_mm"] = 1e3 * run.hinge_m
    if "track.tilt_deg" in scene.request.absent:
        toml["slide"]["start_deg"] = round(
            float(run.start_deg + rng.normal(0, START_SD_DEG)), 1
        )
    t, x, _ = travel(scene, run, sizes)
    table = {
        "t_s": t.round(6),
        "x_mm": noisy(x / (1 + scene.scale_off), scene.noise, rng).round(5),
        "y_mm": noisy(np.zeros(len(t)), scene.noise, rng).round(5),
        "sd_mm": float(f"{scene.noise.sd:.3g}"),
        "tilt_deg": _column(scene, run, sizes, t, rng),
    }
    return Recording(
        name, toml, track=pd.DataFrame(table)[kept(len(t), scene.noise, rng)]
    )


def _read(scene: Scene, run: Run, sizes: dict[str, float], rng) -> np.ndarray:
    """Angles that somebody read [deg], each of a slide of its own."""
    mu = scene.mu + rng.normal(0, RUN_SD, scene.readings)
    angle = (
        np.degrees(np.arctan(mu))
        + scene.tilt_off_deg
        + rng.normal(0, READING_SD_DEG, scene.readings)
    )
    angle += overshoot_deg(scene.mu, run.rate_deg_s, sizes.get("reading-delay", 0.0))
    return scene.reading.of(angle)


def _column(
    scene: Scene, run: Run, sizes: dict[str, float], t: np.ndarray, rng
) -> np.ndarray:
    """The tilt that is recorded at times t [deg]."""
    steady = np.radians(
        run.start_deg + run.rate_deg_s * (t - sizes.get("clock-offset", 0.0))
    )
    plate, rate = block(scene, run, sizes), np.radians(run.rate_deg_s)
    tilt = np.degrees([ground.tilted(angle, rate, plate)[0] for angle in steady])
    tilt += (
        scene.tilt_off_deg
        + sizes.get("angle-offset", 0.0)
        + rng.normal(0, 0.005, len(t))
    )
    if scene.column_grid_deg:
        return Reading(scene.column_grid_deg, "nearest").of(tilt)
    return tilt.round(4)


CASES = Cases(
    rig="slide",
    share=0.18,
    colour="#d9730d",
    effects=EFFECTS,
    draw=draw,
    visibility=visibility,
    bench=bench,
    design=("rate_deg_s", "count"),
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
