"""Rolls made by other means than the solver's: one force after the other, small fixed
steps.

A wheel of given inertia on a path with a corner, forces summed at every tenth of a
millisecond; the track is scaled and made noisy frame by frame. Shares no code with
diagnose."""

import math
from dataclasses import dataclass, field, replace
from pathlib import Path

import numba
import numpy as np
from scipy.signal import lfilter

G = 9.80665
STATED = {
    "length_mm": 8.72,
    "width_mm": 6.84,
    "thickness_mm": 5.98,
    "density_kg_m3": 1250.0,
}
BALL = {"length_mm": 7.0, "width_mm": 7.0, "thickness_mm": 7.0, "density_kg_m3": 1250.0}


@dataclass(frozen=True)
class Bench:
    """What is true, and what is stated."""

    mu: float = 0.02
    mu_scatter: float = 0.03
    incline_deg: float = 15.0
    incline_sd: float = 0.1
    common_incline: bool = False
    level_sd: float = 0.003
    length_mm: float = 30.0
    radius_mm: float = 3.2
    added: float = 0.4  # I/(m r²)
    stated: dict = field(default_factory=lambda: STATED)
    viscous: float = 0.0  # s/m
    slope_deg: float = 0.0  # falling towards +x
    slip: float = 0.0  # m/s where the incline ends
    slip_s: float = 0.025
    slip_on_incline: bool = True
    corner: float = 0.0
    rise_mm: float = 0.0
    drag: float = 0.0  # over weight at 0.5 m/s, growing as the square
    reynolds: float = 0.0  # at 1 m/s; 0: as far as drag's growth is concerned, great
    # of seeds of one lot, relative: drag over weight goes as 1/d; each one's own size
    # is stated
    size_sd: float = 0.0
    drag_sd: float = 0.0  # of one seed's drag beside that, relative
    patch: tuple[float, float, float] = (
        0.0,
        0.0,
        0.0,
    )  # mm behind the corner from, to; added resistance
    by_travel: float = 0.0  # added resistance per metre behind the corner
    # added resistance at a speed [m/s], and as which power of it
    steep: tuple[float, float, float] = (0.0, 1.0, 1.0)
    stated_air: float = 0.0
    scale: float = 0.0
    fps: float = 500.0
    before_s: float = 0.1
    after_s: float = 0.3
    noise_mm: float = 0.05
    rho: float = 0.8
    white: float = 0.3
    lost: float = 0.0
    angle: bool = False
    state_scale: float | None = 0.0002


def motion(b: Bench, sign: float, rng) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """t, path [m], turn [rad] at the frames."""
    beta = math.radians(
        b.incline_deg + (0 if b.common_incline else b.incline_sd * rng.normal())
    )
    mu = b.mu * (1 + b.mu_scatter * rng.normal())
    theta = math.radians(-b.slope_deg + b.level_sd * rng.normal()) * sign
    psi = rng.uniform(0, 2 * math.pi)
    gain = 1.0
    # friction that spins the seed up is only what turning by (1 − s) of its travel
    # needs
    if b.slip and b.slip_on_incline:
        top = math.sqrt(2 * G * math.sin(beta) * b.length_mm / 1000 / (1 + b.added))
        gain = (1 + b.added) / (1 + b.added * (1 - min(b.slip / top, 1.0)))
    frames = np.empty(40_000)
    count = march(
        frames,
        b.fps,
        beta,
        mu,
        theta,
        b.length_mm / 1000,
        b.radius_mm / 1000,
        b.added,
        b.viscous,
        b.slip,
        b.slip_s,
        gain,
        b.corner,
        b.rise_mm / 1000,
        psi,
        b.drag,
        b.reynolds,
        *b.patch,
        b.by_travel,
        *b.steep,
        b.after_s,
    )
    path = np.concatenate([np.zeros(int(b.before_s * b.fps)), frames[:count]])
    return np.arange(len(path)) / b.fps, path, -path / (b.radius_mm / 1000) - psi / 2


@numba.njit(cache=True)
def sphere(re):
    """C_d of a sphere, Brown & Lawler (2003); 1 at Re 0."""
    return (
        24 / re * (1 + 0.150 * re**0.681) + 0.407 / (1 + 8710 / re) if re > 0 else 1.0
    )


@numba.njit(cache=True)
def march(
    out,
    fps,
    beta,
    mu,
    theta,
    length,
    r,
    added,
    viscous,
    slip,
    slip_s,
    gain,
    corner,
    rise,
    psi,
    drag,
    reynolds,
    patch_from,
    patch_to,
    patch,
    by_travel,
    steep,
    steep_speed,
    steep_power,
    after_s,
):
    """Semi-implicit steps of at most 0.1 ms; friction against the motion, or as much as
    holds a seed at rest."""
    n = max(10, math.ceil(1 / fps / 1e-4))
    dt = 1 / fps / n
    x, v, t, behind, stopped, rest = 0.0, 0.0, 0.0, -1.0, False, 0.0
    out[0] = 0.0
    for i in range(1, len(out)):
        for _ in range(n):
            t += dt
            if stopped:
                continue
            on, past = behind < 0, 1e3 * (x - length)
            normal = math.cos(beta) if on else 1.0
            climb = (
                rise / r * math.sin(2 * x / r + psi)
            )  # slope of rise/2 (1 − cos(2x/r + ψ))
            pull = G * (math.sin(beta) if on else -math.sin(theta)) - G * climb * normal
            resist = (
                mu
                + viscous * abs(v)
                + drag
                * (v / 0.5) ** 2
                * sphere(reynolds * abs(v))
                / sphere(reynolds * 0.5)
            )
            if steep != 0.0:
                resist += steep * (abs(v) / steep_speed) ** steep_power
            if not on:
                resist += (
                    patch if patch_from < past < patch_to else 0.0
                ) + by_travel * max(past, 0.0) / 1e3
            limit = (
                G * resist * normal if gain == 1.0 or not on else 0.0
            )  # of a seed that slips it acts on the spin alone
            if v == 0.0 and abs(pull) <= limit:
                stopped = not on
                continue
            a = (
                (pull - math.copysign(limit, v if v != 0.0 else pull))
                / (1 + added)
                * (gain if on else 1.0)
            )
            if not on and slip and t - behind < slip_s:
                a -= slip * added / (1 + added) / slip_s
            new = v + a * dt
            if new * v < 0:
                new = 0.0
            x += dt * (v + new) / 2
            v = new
            if on and x >= length:
                behind = t
                v *= 1 - corner
        out[i] = x
        rest = rest + 1 / fps if stopped else 0.0
        if rest > after_s or x < -0.05 or x > 3:
            return i + 1
    return len(out)


def noise(n, b: Bench, rng):
    """White plus first-order correlated noise [mm], frame by frame."""
    out = lfilter([math.sqrt(1 - b.rho**2)], [1, -b.rho], rng.normal(size=n + 200))[
        200:
    ]
    return b.noise_mm * (
        math.sqrt(1 - b.white) * out + math.sqrt(b.white) * rng.normal(size=n)
    )


def table(b: Bench, sign: float, rng) -> dict:
    """Columns of a track.csv."""
    t, path, angle = motion(b, sign, rng)
    x = 1e3 * path / (1 + b.scale) + noise(len(t), b, rng) + rng.normal(0, 0.3)
    keep = rng.random(len(t)) >= b.lost
    rows = {"t_s": t[keep], "x_mm": x[keep], "y_mm": noise(len(t), b, rng)[keep]}
    if b.angle:
        rows["angle_deg"] = np.degrees(angle[keep]) + rng.normal(0, 1, keep.sum())
    return rows


def usual(b: Bench, rng) -> Bench:
    """The bench as its stated uncertainties leave it."""
    scale = (b.state_scale / 0.25 if b.state_scale else 0.01) * rng.normal()
    more = (
        {"incline_deg": b.incline_deg + b.incline_sd * rng.normal()}
        if b.common_incline
        else {}
    )
    return replace(b, scale=b.scale + scale, **more)


def one_of_the_lot(b: Bench, rng) -> Bench:
    """With a seed of its own size, which is stated, and drag."""
    if not b.size_sd and not b.drag_sd:
        return b
    size = 1 + b.size_sd * rng.normal()
    stated = {
        n: round(v * size, 2) if n.endswith("_mm") else v for n, v in b.stated.items()
    }
    return replace(
        b, stated=stated, drag=b.drag / size * (1 + b.drag_sd * rng.normal())
    )


def rolls(
    bench: Bench, count: int, rng, *, directions=("+x", "-x"), lengths=None
) -> list:
    """`count` recordings as twin.roll_tracks gives them."""
    from benchtwin.bench.keys import Air, Camera, Seed
    from benchtwin.rigs.roll.keys import Roll
    from benchtwin.rigs.roll.read import roll_of
    from benchtwin.vision.motion.track import make_track
    from benchtwin.vision.recording import Recording

    bench, out = usual(bench, rng), []
    for i in range(count):
        here = replace(bench, length_mm=lengths[i % len(lengths)]) if lengths else bench
        here, way = one_of_the_lot(here, rng), directions[i % len(directions)]
        rows = table(here, 1.0 if way == "+x" else -1.0, rng)
        camera = Camera(
            fps=here.fps, mm_per_px=0.25, mm_per_px_sd=bench.state_scale or None
        )
        told = Recording(
            f"roll-{i:02d}",
            Path(),
            "roll",
            "track.csv",
            (),
            seed=Seed(**here.stated),
            camera=camera,
            air=Air(density_kg_m3=bench.stated_air),
            roll=Roll(
                incline_deg=15.0, incline_length_mm=here.length_mm, direction=way
            ),
        )
        frame = np.round(rows["t_s"] * here.fps).astype(int)
        angle = {"angle_deg": rows["angle_deg"]} if "angle_deg" in rows else {}
        out.append(
            roll_of(
                make_track(
                    rows["t_s"], rows["x_mm"], rows["y_mm"], frame=frame, **angle
                ),
                told,
            )
        )
    return out
