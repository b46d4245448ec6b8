"""Slides made by other means than the solver's: polar coordinates about the hinge,
fixed small steps, sticking and slipping.

A camera with a scale, lens and trapezoid of its own, a tilt sensor with noise, offset
and clock, noise that is drawn frame by frame. Shares no formula with diagnose."""

import math
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

G = 9.80665


SEED = {"length_mm": 8.72, "width_mm": 6.84, "thickness_mm": 5.98, "mass_g": 0.234}


@dataclass(frozen=True)
class Bench:
    """What is true, and what is stated. friction(v [m/s], x [m]) is added to μ; static:
    excess at rest; pull [N] on the block."""

    mu: float = 0.40
    mu_sd: float = 0.003
    rates: tuple = (2.0,)  # deg/s, taken in turn
    counts: tuple = (4,)  # seeds taped together, taken in turn
    travel_mm: float = 80.0
    fps: float = 250.0
    rest_s: float = 1.5  # of rest before the onset in the film
    static: float = 0.0
    friction: object = None
    pull: float = 0.0
    inertia: float = 0.0
    shake: tuple = (0.0, 0.0)  # m/s², Hz
    step_deg: float = 0.0  # the plate goes up in steps
    rounded_deg: float = 0.0  # the column is rounded up
    offset_deg: float = 0.0
    clock_s: float = 0.0
    offset_sd_deg: float = 0.05
    hinge_mm: float = 150.0
    hinge_stated: bool = True
    turns: bool = (
        True  # the plate; False: the weight turns about a plate that stands still
    )
    scale_sd: float = 8e-4
    air: float = 0.05  # 1/m, of a block of four: C_d of 0.7 among themselves
    stated_air: float = 1.2
    noise_mm: float = 0.05
    rho: float = 0.8
    white: float = 0.3
    mm_per_px: float = 0.1
    lock_px: float = (
        0.0  # a place is read so much too far towards the middle of its pixel
    )
    tilt_noise_deg: float = 0.03
    tilt_column: bool = True
    # where there is no column: that the plate was level at t = 0; False: the film
    # begins just before
    start_stated: bool = True
    lost: float = 0.02
    stray: float = 0.0  # share of rows that lie anywhere within 20 mm
    sign: float = 1.0
    more: dict = field(default_factory=dict)


LIGHT = Bench(fps=120.0, rest_s=1.0)
AIRLESS = replace(
    LIGHT, air=0.0, stated_air=0.0
)  # what beside a plate is not known of air hides a little viscous friction


def slide(bench: Bench, mu: float, rate: float, mass: float, rng):
    """t since the plate was level, x [m], true tilt [rad] a frame, from rest_s before
    the onset until travel_mm."""
    omega, dt, r0 = math.radians(rate), 2.5e-4, 1e-3 * bench.hinge_mm
    amplitude, hertz = bench.shake
    wave = rng.uniform(0, 2 * math.pi)
    step = math.radians(bench.step_deg)

    def plate(t):
        return (
            (math.floor(omega * t / step) * step, 0.0)
            if step
            else (omega * t, omega * bench.turns)
        )

    def pulls(t, r, speed):
        """Pull down the plate and normal force, over mass, of a block at r from the
        hinge that moves down at `speed`."""
        angle, turn = plate(t)
        along = (
            G * math.sin(angle)
            - turn * turn * r
            + amplitude * math.sin(2 * math.pi * hertz * t + wave)
        )
        return along, G * math.cos(angle) - 2 * turn * speed + bench.pull / mass

    def rise(t, r, speed):
        along, normal = pulls(t, r, speed)
        grip = mu + (bench.friction(speed, r0 - r) if bench.friction else 0.0)
        a = (along - grip * normal - bench.air * speed * speed) / (1 + bench.inertia)
        return a

    t = max((math.atan(mu) - 0.15) / omega - 4 * amplitude / G / omega, 0.0)
    rest = mu + bench.static + (bench.friction(0.0, 0.0) if bench.friction else 0.0)
    times, places, r, speed, moving, begun = [], [], r0, 0.0, False, None
    while r0 - r < 1e-3 * bench.travel_mm and t < 2.2 / omega:
        if not moving:
            along, normal = pulls(t, r, 0.0)
            moving = along > rest * normal
            begun = t if moving and begun is None else begun
        if moving:
            k1 = rise(t, r, speed)
            k2 = rise(t + dt / 2, r - dt / 2 * speed, speed + dt / 2 * k1)
            k3 = rise(
                t + dt / 2, r - dt / 2 * speed - dt * dt / 4 * k1, speed + dt / 2 * k2
            )
            k4 = rise(t + dt, r - dt * speed - dt * dt / 2 * k2, speed + dt * k3)
            r -= dt * speed + dt * dt / 6 * (k1 + k2 + k3)
            speed += dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            if speed < 0:
                speed, moving = 0.0, False
        t += dt
        times.append(t)
        places.append(r0 - r)
    frames = np.arange(
        begun - bench.rest_s + rng.uniform(0, 1 / bench.fps), t, 1 / bench.fps
    )
    x = np.interp(frames, times, places, left=0.0)
    return frames, x, np.array([plate(max(s - bench.clock_s, 0.0))[0] for s in frames])


def noise(n, sd, rho, white, rng):
    """White plus first-order correlated noise, frame by frame."""
    slow, out = rng.normal(), np.empty(n)
    for i in range(n):
        slow = rho * slow + math.sqrt(1 - rho**2) * rng.normal() if i else slow
        out[i] = slow
    return sd * (math.sqrt(1 - white) * out + math.sqrt(white) * rng.normal(size=n))


def slides(bench: Bench, count: int, rng):
    """`count` recordings as twin.slides gives them."""
    from benchtwin.bench.keys import Air, Camera, Seed
    from benchtwin.rigs.slide.keys import Slide
    from benchtwin.rigs.slide.read import slide_of
    from benchtwin.vision.motion.track import make_track
    from benchtwin.vision.recording import Recording

    out = []
    offset = bench.offset_deg + rng.normal(0, bench.offset_sd_deg)
    scale, lens, keystone = (
        rng.normal(0, bench.scale_sd),
        rng.normal(0, 2e-4),
        rng.normal(0, 1e-3),
    )
    for i in range(count):
        rate, seeds = (
            bench.rates[i % len(bench.rates)],
            bench.counts[i % len(bench.counts)],
        )
        t, x, tilt = slide(
            bench, bench.mu + rng.normal(0, bench.mu_sd), rate, 0.234e-3 * seeds, rng
        )
        x = 1e3 * x
        half = bench.travel_mm / 2
        off = x - half
        x = (
            half
            + off * (1 - scale) * (1 + lens * (off / half) ** 2 + keystone * off / 1000)
            + rng.normal(0, 20)
        )
        ripple = (
            bench.lock_px * bench.mm_per_px * np.sin(2 * math.pi * x / bench.mm_per_px)
        )
        x = bench.sign * (
            x + ripple + noise(len(x), bench.noise_mm, bench.rho, bench.white, rng)
        )
        seen = np.degrees(tilt)
        if bench.rounded_deg:
            seen = np.ceil(seen / bench.rounded_deg) * bench.rounded_deg
        seen = seen + offset + noise(len(x), bench.tilt_noise_deg, 0.5, 0.5, rng)
        if bench.stray:
            odd = np.random.default_rng(i).random(len(x)) < bench.stray
            x = x + odd * np.random.default_rng(i).uniform(-20, 20, len(x))
        keep = rng.random(len(t)) >= bench.lost
        column = {"tilt_deg": seen[keep]} if bench.tilt_column else {}
        begun = 0.0 if bench.start_stated else t[keep][0]
        track = make_track(
            t[keep] - begun,
            x[keep],
            0 * x[keep],
            frame=np.arange(len(t))[keep],
            **column,
        )
        told = Recording(
            f"slide-{i:02d}",
            Path(),
            "slide",
            "track.csv",
            (),
            seed=Seed(**SEED, count=seeds),
            air=Air(density_kg_m3=bench.stated_air),
            camera=Camera(
                fps=bench.fps,
                mm_per_px=bench.mm_per_px,
                mm_per_px_sd=bench.mm_per_px * bench.scale_sd,
            ),
            slide=Slide(
                tilt_rate_deg_s=rate,
                travel_mm=bench.travel_mm,
                start_mm=bench.hinge_mm if bench.hinge_stated else None,
                start_deg=None if bench.tilt_column or not bench.start_stated else 0.0,
            ),
        )
        out.append(slide_of(track, told))
    return out


def readings(angles_of, rates, counts, repeats: int, rng, *, masses: bool = True):
    """One recording a (rate, count): `repeats` angles [deg] by angles_of(rate, count,
    rng)."""
    from benchtwin.rigs.slide.read import SeenSlide

    none, out = np.zeros(0), []
    for i, (rate, count) in enumerate(zip(rates, counts, strict=True)):
        angles = np.array([angles_of(rate, count, rng) for _ in range(repeats)])
        seed = {"mass_g": 0.234, "count": count} if masses else {}
        told = {
            "seed": seed,
            "camera": {"scale_sd": 0.01},
            "air": {"density_kg_m3": 1.2},
            "slide": {"tilt_rate_deg_s": rate},
        }
        out.append(
            SeenSlide(f"slide-{i:02d}", "", none, none, none, none, None, angles, told)
        )
    return out


def found(bench: Bench, seed: int, count: int = 3):
    """The finding on `count` slides of this bench."""
    from benchtwin.rigs.slide.diagnose import diagnose_slide

    return diagnose_slide(
        slides(bench, count, np.random.default_rng(seed)), np.random.default_rng(0)
    )
