"""Which keys a bench states, which it leaves out, and how people round the angles that
they read."""

from dataclasses import replace

import numpy as np

from benchtwin.prove.cases.air import AIR_DENSITY
from benchtwin.prove.cases.bench import Bench, Request, log_uniform

# of benches that leave a key out; "seed.sizes": all three, "track.…": a column
SHARES = {
    "camera.distance_mm": 0.5,
    "camera.mm_per_px_sd": 0.25,
    "camera.plumb_deg": 0.15,
    "camera.plumb_sd_deg": 0.25,
    "camera.exposure_s": 0.5,
    "seed.sizes": 0.12,
    "seed.mass_g": 0.12,
    "air": 0.3,
    "session": 0.3,
    "drop.height_mm": 0.25,
    "slide.travel_mm": 0.3,
    "slide.start_mm": 0.6,
    "slide.start_deg": 0.4,
    "slide.tilt_rate_deg_s": 0.3,
    "roll.direction": 0.3,
    "pile.gate_speed_mm_s": 0.25,
    "track.sd_mm": 0.3,
    "track.tilt_deg": 0.2,
    "reading.resolution_deg": 0.6,
}
PLUMB = ("camera.plumb_deg", "camera.plumb_sd_deg")
SEED = ("seed.sizes", "seed.mass_g")
ANGLE = ("track.tilt_deg",)
RATE = ("slide.tilt_rate_deg_s",)
NEEDED = {  # keys without which an effect is not defined, or confounded with another
    "drag": ("air",),
    "magnus": SEED,
    "draught": PLUMB,
    "camera-roll": PLUMB,
    "base-tilt": PLUMB,
    "plate-tilt": PLUMB,
    "field": PLUMB,
    "scale-error": ("camera.mm_per_px_sd",),
    "clock-error": ("camera.mm_per_px_sd",),
    "shape-conversion": SEED,
    "adhesion": (*SEED, *ANGLE),
    "clock-offset": ANGLE,
    "stepped-tilt": ANGLE,
    "follows": ANGLE,
    "order-drift": ANGLE,
    "stribeck": ANGLE,
    "worn-track": ANGLE,
    "reading-delay": RATE,
    "shape-barrier": SEED,
    "slope": ("roll.direction",),
    "gate-speed": ("pile.gate_speed_mm_s",),
}
DISTINGUISHING = ("session", "roll.direction", "pile.gate_speed_mm_s")
# to what benches know them that do not say
UNSTATED_SCALE = 0.01
UNSTATED_PLUMB_DEG = 1.0
UNSTATED_PLUMB_SD_DEG = 0.5
# camera to motion; how well that is measured, where it is
DISTANCE_M = (0.3, 20.0)
TAPE = 0.01
GRIDS_DEG, GRID_SHARES = (0.1, 0.2, 0.25, 0.5, 1.0), (0.3, 0.1, 0.1, 0.4, 0.1)
# added before it is cut to the line below: to the nearest, down, up; share of readers
LIFTS, LIFT_SHARES = (0.5, 0.0, 1.0), (0.7, 0.15, 0.15)
AIRY_SHARE = 0.7  # of benches that stand in air; the others say that they do not


def on_grid(values: np.ndarray, grid: float, lift: float = 0.5) -> np.ndarray:
    """Values as they are read to lines `grid` apart, to the nearest or by another
    lift."""
    return (np.floor(values / grid + lift) * grid).round(4)


def mean_sd_deg(grid_deg: float, sd_deg: float, count: int) -> float:
    """sd of the mean of `count` readings on a grid that scatter by sd_deg.

    What a grid leaves of a small scatter does not average out: a sine of amplitude
    (g/π) exp(−2π² sd²/g²) over a line's distance.
    """
    stays = grid_deg / np.pi * np.exp(-2 * (np.pi * sd_deg / grid_deg) ** 2)
    return float(np.sqrt((sd_deg**2 + grid_deg**2 / 12) / count + stays**2 / 2))


def draw_absent_keys(
    effects: tuple[str, ...], rng: np.random.Generator
) -> frozenset[str]:
    """Keys that a bench with these effects does not state, each by itself."""
    needed = {key for name in effects for key in NEEDED.get(name, ())}
    absent = {
        key
        for key, share in SHARES.items()
        if rng.random() < share and key not in needed
    }
    if "camera.plumb_deg" in absent:
        absent.add("camera.plumb_sd_deg")
    if "track.tilt_deg" in absent:
        # one of the two tells how the plate turns
        absent.discard("slide.tilt_rate_deg_s")
    return frozenset(absent)


def draw_scale_sd(request: Request, rng: np.random.Generator) -> float:
    """sd of mm per pixel, relative; who does not say it knows it less well."""
    if "camera.mm_per_px_sd" in request.absent:
        return log_uniform(1e-3, UNSTATED_SCALE, rng)
    return log_uniform(3e-4, 2e-3, rng)


def draw_distance_mm(rng: np.random.Generator) -> float:
    """A camera distance [mm], log-uniform over DISTANCE_M."""
    return 1e3 * log_uniform(*DISTANCE_M, rng)


def stated_distance_mm(distance_mm: float, rng: np.random.Generator) -> float:
    """The distance [mm] as a tape measure reads it."""
    return float(f"{distance_mm * (1 + TAPE * rng.standard_normal()):.3g}")


def camera_keys(
    mm_per_px: float,
    scale_sd: float,
    plumb_deg: float = 0.0,
    plumb_sd_deg: float = 0.05,
    **more: object,
) -> dict:
    """[camera]; scale_sd is relative."""
    scale = {
        "mm_per_px": mm_per_px,
        "mm_per_px_sd": float(f"{scale_sd * mm_per_px:.3g}"),
    }
    return scale | {"plumb_deg": plumb_deg, "plumb_sd_deg": plumb_sd_deg} | more


def known_scale(request: Request, scale_sd: float) -> float:
    """How well the scale is known, relative (sd): as stated, or as one that is not
    stated."""
    return request.known("camera.mm_per_px_sd", scale_sd, UNSTATED_SCALE)


def known_plumb_deg(request: Request, plumb_sd_deg: float) -> float:
    """How well the vertical is known [deg] (sd): as stated, or as one that is not
    stated."""
    stated = request.known("camera.plumb_sd_deg", plumb_sd_deg, UNSTATED_PLUMB_SD_DEG)
    return request.known("camera.plumb_deg", stated, UNSTATED_PLUMB_DEG)


def without_absent_keys(bench: Bench, absent: frozenset[str]) -> Bench:
    """The bench without what it does not state; what tells recordings apart is
    stated."""
    values_of = {
        key: {_value(made.toml, key) for made in bench.recordings}
        for key in DISTINGUISHING
    }
    absent = absent - {key for key, values in values_of.items() if len(values) > 1}
    columns = {key.removeprefix("track.") for key in absent if "track." in key}
    recordings = []
    for made in bench.recordings:
        track = made.track
        if track is not None:
            track = track.drop(columns=[c for c in track.columns if c in columns])
        recordings.append(replace(made, toml=_without(made.toml, absent), track=track))
    return Bench(_without(bench.toml, absent), tuple(recordings))


def _value(toml: dict, key: str) -> str:
    section, _, name = key.partition(".")
    return str(toml[section].get(name) if name and section in toml else toml.get(key))


def _without(toml: dict, absent: frozenset[str]) -> dict:
    gone, out = set(absent), {}
    if "seed.sizes" in absent:
        gone |= {"seed.length_mm", "seed.width_mm", "seed.thickness_mm"}
    for key, value in toml.items():
        if isinstance(value, dict):
            value = {k: v for k, v in value.items() if f"{key}.{k}" not in gone}
        if key not in gone and value != {}:
            out[key] = value
    return out


def bench_keys(axes_mm: np.ndarray, density: float, airy: bool) -> dict:
    """bench.toml of seeds with these full axes (3,) and density [kg/m³]."""
    names = ("length_mm", "width_mm", "thickness_mm")
    sizes = {name: round(float(axis), 2) for name, axis in zip(names, axes_mm)}
    mass_g = float(f"{np.pi / 6 * np.prod(axes_mm) * density * 1e-6:.4g}")
    air = {"density_kg_m3": AIR_DENSITY if airy else 0.0}
    seed = sizes | {"mass_g": mass_g}
    return {"provenance": "measured", "seed": seed, "air": air}
