"""Rolls: round seeds run down an incline and out along a level plate, one way or both.

Signs. viscous-rolling: dμ_r/dv [s/m]. slope: the run-out falls towards +x [deg], so
that a run in direction −x climbs it. initial-slip: v − ωr at the incline's foot [m/s].
corner-loss: lost share of the speed there. shape-barrier: highest less lowest centre in
a turn [mm]. drag: force over weight at 0.5 m/s. sticky-patch: more μ_r on a stretch of
the level. follows, order-drift: change of μ_r over half the range of a condition, of
the order."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from scipy.optimize import brentq

from benchtwin.prove.cases import ground_motion as ground
from benchtwin.prove.cases.bench import Bench, Recording, Request, log_uniform
from benchtwin.prove.cases.camera import Camera, magnification
from benchtwin.prove.cases.noise import Noise, draw_noise, kept, noisy
from benchtwin.prove.cases.record import Cases, Effect
from benchtwin.prove.cases.snr import Channel, RecordingChange, Visibility, fitted
from benchtwin.prove.cases.stated import (
    AIR_DENSITY,
    AIRY_SHARE,
    camera_keys,
    drag_scale,
    draw_distance_mm,
    draw_scale_sd,
    known_scale,
    stated_distance_mm,
)

RUN_SD, INCLINE_SD_DEG, LEVEL_SD_DEG, START_SD_MM = 0.03, 0.1, 0.003, 0.2
# of a sphere's drag in free air, in all runs; size and mass known or not
DRAG_NEAR_PLATE = (0.7, 2.0)
DRAG_NEAR_PLATE_SD = (0.4, 1.0)
SEED_SD = 0.04  # each seed's own
ASTRAY_SD = 0.009  # tangent of the angle in which a seed runs away from the camera
FOLLOWS = ("follows", "order-drift")
AT_CORNER = (
    "corner-loss",
    "initial-slip",
)  # what a corner might take by itself besides
# of 5/7 (1 − cos β) of the speed: a sharp corner takes that, a rounded one nothing
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


@dataclass(frozen=True)
class Run:
    """One roll: its direction, and how it differs from the others."""

    forwards: bool
    mu_factor: float
    start_off_mm: float
    phase: float
    late_s: float
    pull: float  # its drag over the lot's
    astray: float
    noise_seed: int
    follows: float = 0.0


@dataclass(frozen=True)
class Scene:
    """All that a case of rolls has beside its effects."""

    runs: tuple[Run, ...]
    mu: float
    diameter_mm: float
    density: float
    way_mm: float
    incline_deg: float
    incline_off_deg: float  # what the bench left open, as the next two
    level_deg: float
    scale_off: float
    scale_sd: float
    fps: float
    noise: Noise
    air: float  # beside a sphere's in free flight; 0: none, or none stated
    patch: tuple[float, float]  # of the run-out
    distance_mm: float
    request: Request


def draw(request: Request, rng: np.random.Generator) -> Scene:
    """A scene of the requested effects: rolls, their camera, and what is stated of
    them."""
    both = request.separated or (request.separated is None and rng.random() < 0.5)
    pixel, scale_sd = float(rng.uniform(0.1, 0.3)), draw_scale_sd(request, rng)
    runs = tuple(
        Run(
            not (both and i % 2),
            float(1 + rng.normal(0, RUN_SD)),
            float(rng.normal(0, START_SD_MM)),
            float(rng.uniform(0, 2 * np.pi)),
            float(rng.uniform(-0.05, 0.01)),
            float(1 + rng.normal(0, SEED_SD)),
            float(rng.normal(0, ASTRAY_SD)),
            int(rng.integers(2**62)),
        )
        for i in range(int(rng.integers(6, 10)))
    )
    mu, way = log_uniform(0.02, 0.06, rng), float(rng.choice([10.0, 20.0, 40.0]))
    return Scene(
        runs,
        mu,
        round(float(rng.uniform(5, 8)), 2),
        rng.uniform(1050, 1350),
        way,
        15.0,
        rng.normal(0, INCLINE_SD_DEG),
        rng.normal(0, LEVEL_SD_DEG),
        rng.normal(0, scale_sd),
        scale_sd,
        float(rng.choice([240.0, 500.0, 1000.0])),
        draw_noise(rng, sd=(0.015, 0.08), pixel=pixel),
        float(rng.uniform(*DRAG_NEAR_PLATE))
        * bool(
            "drag" not in request.effects
            and ("air" in request.absent or rng.random() < AIRY_SHARE)
        ),
        tuple(np.sort(rng.uniform(0.15, 0.8, 2)) + np.array([0.0, 0.08])),
        draw_distance_mm(rng),
        request,
    )


def seed(
    scene: Scene,
    run: Run,
    sizes: dict[str, float],
    mu_factor: float = 1.0,
    level_more: float = 0.0,
    air_more: float = 0.0,
) -> np.ndarray:
    """The seed and the plate as ground_motion.roll takes them."""
    sign = 1.0 if run.forwards else -1.0
    out = np.zeros(ground.SEED)
    mu = scene.mu * run.mu_factor + run.follows * sum(
        sizes.get(name, 0.0) for name in FOLLOWS
    )
    out[ground.ROLLING] = mu * mu_factor
    out[ground.GROWING] = sizes.get("viscous-rolling", 0.0)
    out[ground.LEVEL] = sign * np.radians(
        scene.level_deg + level_more - sizes.get("slope", 0.0)
    )
    out[ground.BARRIER] = sizes.get("shape-barrier", 0.0) * 1e-3
    out[ground.RADIUS] = scene.diameter_mm * 5e-4
    out[ground.PHASE], out[ground.DRAG] = run.phase, sizes.get("drag", 0.0)
    if sizes.get("initial-slip", 0.0) > 0:
        out[ground.SLIPS] = 1.0
        incline = np.radians(scene.incline_deg + scene.incline_off_deg)
        out[ground.SLIP_FRICTION] = slip_friction(
            incline, scene.way_mm, sizes["initial-slip"], out[ground.ROLLING]
        )
    out[ground.LOST] = sizes.get("corner-loss", 0.0)
    out[ground.PATCH] = sizes.get("sticky-patch", 0.0)
    lone, out[ground.RE] = drag_scale((scene.diameter_mm,) * 3, scene.density)
    out[ground.BLOWN] = lone * (scene.air * run.pull + air_more)
    ends = np.array(scene.patch) if run.forwards else 1 - np.array(scene.patch[::-1])
    out[[ground.PATCH_FROM, ground.PATCH_TO]] = ends * reach_mm(scene) * 1e-3
    return out


def slip_friction(incline: float, way_mm: float, slip: float, rolling: float) -> float:
    """Friction with which a seed that slips from the start slips by `slip` [m/s] at the
    foot of the incline."""
    steep, level = ground.G_M_S2 * np.sin(incline), ground.G_M_S2 * np.cos(incline)

    def off(mu: float) -> float:
        return (steep - (3.5 * mu - 2.5 * rolling) * level) * np.sqrt(
            2e-3 * way_mm / (steep - mu * level)
        ) - slip

    if off(0.0) > 0:
        return brentq(off, 0.0, (np.tan(incline) + 2.5 * rolling) / 3.5)
    return 0.0


def reach_mm(scene: Scene) -> float:
    """How far a seed of the baseline runs out: μ_r = S sin β / (S cos β + L)."""
    beta = np.radians(scene.incline_deg)
    return scene.way_mm * (np.sin(beta) - scene.mu * np.cos(beta)) / scene.mu


def travel(
    scene: Scene,
    run: Run,
    sizes: dict[str, float],
    *,
    mu_factor: float = 1.0,
    incline_more: float = 0.0,
    level_more: float = 0.0,
    air_more: float = 0.0,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(times [s] from the film's start, travel [mm], speed [mm/s]); 0.15 s of rest at
    the end."""
    incline = np.radians(scene.incline_deg + scene.incline_off_deg + incline_more)
    way_mm = scene.way_mm + reach_mm(scene)
    longest = 4 * np.sqrt(2 * way_mm * 1e-3 / (ground.G_M_S2 * scene.mu * 0.7)) + 1
    t = np.arange(int(longest * scene.fps)) / scene.fps
    rolling = np.maximum(t + run.late_s, 0.0)
    start = (scene.way_mm + run.start_off_mm) * 1e-3
    args = (start, incline, seed(scene, run, sizes, mu_factor, level_more, air_more))
    x, v = ground.roll(np.r_[0.0, rolling], *args)
    x, v = x[1:], v[1:]
    moving = np.flatnonzero(np.abs(v) > 0)
    n = min(len(t), int(moving[-1] + 0.15 * scene.fps)) if len(moving) else len(t)
    return t[:n], 1e3 * x[:n], 1e3 * v[:n]


def visibility(scene: Scene, sizes: dict[str, float], name: str) -> Visibility:
    """How visible `name` is in the world of all `sizes`, beside the corner that hides
    it best."""
    others = {k: v for k, v in sizes.items() if k != name}
    sharp = 5 / 7 * (1 - np.cos(np.radians(scene.incline_deg)))
    corners = [share * sharp for share in CORNER] if name in AT_CORNER else [0.0]
    worlds = [
        others | {"corner-loss": max(others.get("corner-loss", 0.0), taken)}
        for taken in corners
    ]
    seen = min(
        (_visible_beside(scene, sizes, without, sharp) for without in worlds),
        key=lambda one: one.snr,
    )
    return replace(seen, moved=None) if name in FOLLOWS else seen


def _visible_beside(
    scene: Scene, sizes: dict[str, float], without: dict[str, float], sharp: float
) -> Visibility:
    """How visible it is what the world of `sizes` has beyond the one `without`."""
    recordings = []
    unit = scene.noise.sd / RUN_SD
    for run in scene.runs:
        t, x, v = travel(scene, run, sizes)
        n = len(t)
        like = _same_reach(scene, run, x[-1], without)
        later = replace(run, start_off_mm=run.start_off_mm + 0.01)
        other = _padded(travel(scene, run, without, mu_factor=like)[1], n)
        mu = (_padded(travel(scene, run, sizes, mu_factor=1.002)[1], n) - x) / 0.002
        start = (_padded(travel(scene, later, sizes)[1], n) - x) / 0.01
        incline = (
            _padded(travel(scene, run, sizes, incline_more=0.01)[1], n) - x
        ) / 0.01
        level = (_padded(travel(scene, run, sizes, level_more=1e-3)[1], n) - x) / 1e-3
        struck = sizes | {"corner-loss": sizes.get("corner-loss", 0.0) + 1e-3}
        lost = (_padded(travel(scene, run, struck)[1], n) - x) / 1e-3
        blown = _padded(travel(scene, run, sizes, air_more=0.1)[1], n)
        air = (blown - x) / 0.1 * bool(scene.air)
        astray = (
            _seen(scene, replace(run, astray=run.astray + 1e-4), x)
            - _seen(scene, run, x)
        ) / 1e-4
        own = np.column_stack([np.ones(n), v, mu, start, air, astray])
        shared = np.column_stack([np.zeros(n), incline, level, x, lost, air])
        # its friction is the pair's within RUN_SD: that it was moved to run as far is
        # paid for by one more row
        paid = Channel(
            np.array([(like - 1) * unit]), -unit * np.eye(6)[2:3], unit * np.eye(6)[:1]
        )
        own_sd = np.array([np.inf, np.inf, np.inf, START_SD_MM, SEED_SD, ASTRAY_SD])
        recordings.append(
            RecordingChange((Channel(x - other, own, shared), paid), own_sd)
        )
    scale_sd = known_scale(scene.request, scene.scale_sd)
    beside = DRAG_NEAR_PLATE_SD[not scene.request.sizes_known()]
    known = np.array(
        [np.inf, INCLINE_SD_DEG, LEVEL_SD_DEG, scale_sd, CORNER_SD * sharp, beside]
    )
    fit = fitted(recordings, known, scene.noise)
    return Visibility(fit.snr, float(fit.shared[0] / fit.shared_sd[0]))


def _seen(scene: Scene, run: Run, x_mm: np.ndarray) -> np.ndarray:
    """Travel as the camera sees it, above the middle of the way [mm]: who runs away
    from it looks slower."""
    middle = (scene.way_mm + reach_mm(scene)) / 2
    camera = Camera((middle, 0.0), middle, distance_mm=scene.distance_mm)
    return middle + (x_mm - middle) * magnification(camera, run.astray * x_mm)


def _same_reach(
    scene: Scene, run: Run, wanted_mm: float, without: dict[str, float]
) -> float:
    """Factor of friction with which the run without the effect goes as far as with
    it."""

    def beyond(factor: float) -> float:
        return travel(scene, run, without, mu_factor=factor)[1][-1] - wanted_mm

    low, high = 0.35, 2.2
    return (
        brentq(beyond, low, high, xtol=1e-5) if beyond(low) > 0 > beyond(high) else 1.0
    )


def _padded(x: np.ndarray, n: int) -> np.ndarray:
    return x[:n] if len(x) >= n else np.r_[x, np.full(n - len(x), x[-1])]


def bench(scene: Scene, sizes: dict[str, float]) -> Bench:
    """The bench folder of a scene with these effects."""
    d = scene.diameter_mm
    size = {
        "length_mm": d,
        "width_mm": d,
        "thickness_mm": d,
        "mass_g": float(f"{np.pi / 6 * d**3 * scene.density * 1e-6:.4g}"),
    }
    air = {"density_kg_m3": AIR_DENSITY if scene.air > 0 else 0.0}
    toml = {"provenance": "measured", "seed": size, "air": air}
    return Bench(
        toml, tuple(_recording(scene, sizes, i) for i in range(len(scene.runs)))
    )


def _recording(scene: Scene, sizes: dict[str, float], i: int) -> Recording:
    run, rng = scene.runs[i], np.random.default_rng(scene.runs[i].noise_seed)
    name = f"roll-{i + 1:02d}"
    way = {
        "incline_deg": scene.incline_deg,
        "incline_length_mm": scene.way_mm,
        "direction": "+x" if run.forwards else "-x",
    }
    toml = {
        "rig": "roll",
        "id": name,
        "session": "day-1",
        "roll": way,
        "camera": camera_keys(
            scene.noise.pixel,
            scene.scale_sd,
            fps=scene.fps,
            distance_mm=stated_distance_mm(scene.distance_mm, rng),
        ),
    }
    t, x, _ = travel(scene, run, sizes)
    table = {
        "t_s": t.round(6),
        "x_mm": noisy(
            _seen(scene, run, x) / (1 + scene.scale_off), scene.noise, rng
        ).round(5),
        "y_mm": noisy(np.zeros(len(t)), scene.noise, rng).round(5),
        "sd_mm": float(f"{scene.noise.sd:.3g}"),
    }
    return Recording(
        name, toml, track=pd.DataFrame(table)[kept(len(t), scene.noise, rng)]
    )


CASES = Cases(
    rig="roll",
    share=0.17,
    colour="#2e7d4f",
    effects=EFFECTS,
    draw=draw,
    visibility=visibility,
    bench=bench,
    design=("forwards",),
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
