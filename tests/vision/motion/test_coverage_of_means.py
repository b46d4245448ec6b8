"""Benches of repeats: the interval of their mean holds the bench's own friction,
whatever all of its recordings share."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.stats import binom
from scipy.stats import t as student

from benchtwin.bench.keys import Air, Camera, Seed
from benchtwin.bench.priors import stated_sd, unstated_sd
from benchtwin.rigs.roll.keys import Roll
from benchtwin.rigs.roll.measure import measure_roll
from benchtwin.rigs.slide.measure import measure_slide
from benchtwin.vision.motion.track import Track, make_track
from benchtwin.vision.recording import Recording

pytestmark = pytest.mark.slow

G = 9.80665
BENCHES, REPEATS, SCALE_SD = 80, 5, 0.002
LEAST = (
    binom.ppf(0.02, BENCHES, 0.95) / BENCHES
)  # 0.90: fewer inside come by chance once in fifty such studies


def filmed(
    rng: np.random.Generator, time: np.ndarray, x_mm: np.ndarray, scale: float, **more
) -> Track:
    """What a tracker makes of it: half of the noise comes and goes within some ten
    frames."""
    slow = (
        np.convolve(
            rng.standard_normal(len(time) + 40),
            np.exp(-np.arange(41) / 8.0),
            mode="valid",
        )
        / 2.0
    )
    return make_track(
        time,
        x_mm * scale + 0.06 * rng.standard_normal(len(time)) + 0.06 * slow,
        0 * time,
        **more,
    )


def draw_slides(
    rng: np.random.Generator,
) -> tuple[list[tuple[Track, Recording]], dict[str, float]]:
    """Frictions of the lot, each run's own beside them; the sensor's zero and the scale
    are off in all runs alike."""
    static = rng.uniform(0.2, 0.7)
    kinetic = static * rng.uniform(0.75, 0.97)
    zero, scale = (
        rng.normal(0, unstated_sd("tilt-sensor-zero")),
        1 + rng.normal(0, SCALE_SD),
    )
    rate, fps, grain = (
        rng.uniform(0.7, 5.0),
        float(rng.choice([60.0, 120.0, 240.0])),
        rng.uniform(0.002, 0.008),
    )
    tracks = []
    for _ in range(REPEATS):
        own = rng.normal(0, grain)
        onset, friction = math.atan(static + own), kinetic + own

        def motion(s, y, onset=onset, friction=friction):
            angle, turn = onset + math.radians(rate) * s, 2 * math.radians(rate) * y[1]
            return [y[1], G * math.sin(angle) - friction * (G * math.cos(angle) - turn)]

        def gone(s, y):
            return y[0] - 0.08

        gone.terminal = True
        slide = solve_ivp(
            motion,
            (0, 20),
            [0.0, 0.0],
            events=gone,
            rtol=1e-8,
            atol=1e-10,
            dense_output=True,
            max_step=0.1,
        )
        before = rng.uniform(0.5, 1.5)
        time = np.arange(0, before + slide.t[-1], 1 / fps)
        late = np.clip(time - before, 0, None)
        tilt = (
            np.degrees(onset)
            + rate * (time - before)
            + zero
            + 0.03 * rng.standard_normal(len(time))
        )
        tracks.append(
            filmed(rng, time, 1000 * slide.sol(late)[0], scale, tilt_deg=tilt)
        )
    known = Recording(
        "s",
        Path("s"),
        "slide",
        "track.csv",
        (),
        camera=Camera(mm_per_px=0.25, mm_per_px_sd=0.25 * SCALE_SD),
    )
    return [(track, known) for track in tracks], {
        "static_friction": static,
        "kinetic_friction": kinetic,
    }


def draw_rolls(
    rng: np.random.Generator,
) -> tuple[list[tuple[Track, Recording]], dict[str, float]]:
    """Balls down an incline, over a corner that takes some of their speed, along a
    level through air; every other one back."""
    size, dense, lot = (
        rng.uniform(4e-3, 1.2e-2),
        rng.uniform(700, 2500),
        rng.uniform(0.012, 0.05),
    )
    beta, length = (
        float(rng.choice([10.0, 15.0, 20.0])),
        float(rng.choice([15.0, 30.0, 50.0])),
    )
    truly, scale = (
        math.radians(beta + rng.normal(0, stated_sd("incline"))),
        1 + rng.normal(0, SCALE_SD),
    )
    rise, drag = (
        math.radians(rng.normal(0, unstated_sd("level-plate"))),
        max(1 + stated_sd("drag-beside-plate") * rng.standard_normal(), 0.2),
    )
    loss, fps, both = (
        rng.uniform(0, 0.1),
        float(rng.choice([60.0, 120.0, 240.0])),
        rng.uniform() < 0.5,
    )
    mass = dense * math.pi * size**3 / 6
    tracks = []
    for k in range(REPEATS):
        friction, way = (
            lot * (1 + 0.03 * rng.standard_normal()),
            (length + stated_sd("way-on-incline") * rng.standard_normal()) / 1000,
        )
        slope = -rise if both and k % 2 else rise

        def motion(s, y, down, friction=friction):
            reynolds = max(1.2 * abs(y[1]) * size / 1.81e-5, 1e-6)
            pull = (
                (24 / reynolds + 6 / (1 + math.sqrt(reynolds)) + 0.4)
                * 1.2
                * math.pi
                * size**2
                / 8
                * y[1] ** 2
                / mass
            )
            return [
                y[1],
                (G * math.sin(down) - friction * G * math.cos(down) - drag * pull)
                / 1.4,
            ]

        def corner(s, y, down, way=way):
            return y[0] - way

        def rest(s, y, down):
            return y[1]

        corner.terminal = rest.terminal = True
        exact = {"rtol": 1e-8, "atol": 1e-11, "dense_output": True, "max_step": 0.1}
        first = solve_ivp(
            motion, (0, 5), [0.0, 0.0], events=corner, args=(truly,), **exact
        )
        second = solve_ivp(
            motion,
            (0, 30),
            [way, (1 - loss) * first.y[1, -1]],
            events=rest,
            args=(-slope,),
            **exact,
        )
        wait = rng.uniform(0.1, 0.3)
        time = np.arange(0, wait + first.t[-1] + second.t[-1] + 0.3, 1 / fps)
        s = np.clip(time - wait, 0, None)
        late = np.clip(s - first.t[-1], 0, second.t[-1])
        x = np.where(
            s < first.t[-1],
            first.sol(np.minimum(s, first.t[-1]))[0],
            second.sol(late)[0],
        )
        track = filmed(rng, time, 1000 * x, scale)
        tracks.append(
            track.take(track.x < 350.0) if rng.uniform() < 0.3 else track
        )  # some leave the picture
    mm = 1000 * size
    known = Recording(
        "r",
        Path("r"),
        "roll",
        "track.csv",
        (),
        camera=Camera(mm_per_px=0.25, mm_per_px_sd=0.25 * SCALE_SD),
        air=Air(),
        seed=Seed(length_mm=mm, width_mm=mm, thickness_mm=mm, density_kg_m3=dense),
        roll=Roll(incline_deg=beta, incline_length_mm=length),
    )
    ways = [("+x", "-x")[k % 2] if both else None for k in range(REPEATS)]
    told = [
        replace(known, roll=known.roll.model_copy(update={"direction": way}))
        for way in ways
    ]
    return list(zip(tracks, told, strict=True)), {
        "rolling_resistance": lot,
        "rolling_friction": lot,
    }


def study(draw, measure, seed: int) -> dict[str, np.ndarray]:
    """Of each quantity (BENCHES, 4): error of the mean, half of its 95 % interval by
    the scatter, and by what is common, truth."""
    found: dict[str, list] = {}
    for bench in range(BENCHES):
        recordings, truth = draw(np.random.default_rng([seed, bench]))
        results = [
            {q.name: q for q in measure(track, known).quantities}
            for track, known in recordings
        ]
        for name, true in truth.items():
            measured = [r[name] for r in results if r[name].quality != "failed"]
            if (n := len(measured)) < 3:
                continue
            values = np.array([q.value for q in measured])
            spread = student.ppf(0.975, n - 1) * values.std(ddof=1) / math.sqrt(n)
            row = (
                values.mean() - true,
                spread,
                1.96 * float(np.mean([q.sd_common for q in measured])),
                true,
            )
            found.setdefault(name, []).append(row)
    return {name: np.array(rows) for name, rows in found.items()}


def inside(rows: np.ndarray, common: bool = True) -> float:
    return float(
        np.mean(np.abs(rows[:, 0]) < np.hypot(rows[:, 1], rows[:, 2] * common))
    )


def test_means_of_slides_hold_their_frictions():
    found = study(draw_slides, measure_slide, 1)
    for name in ("static_friction", "kinetic_friction"):
        rows = found[name]
        assert len(rows) == BENCHES and inside(rows) >= LEAST, name
        assert (
            abs(np.mean(rows[:, 0] / rows[:, 3])) < 2e-3
        )  # no bias: 0.6e-3 is the mean's own sd


def test_means_of_rolls_hold_their_resistance():
    rows = study(draw_rolls, measure_roll, 2)
    resistance, eq_3 = rows["rolling_resistance"], rows["rolling_friction"]
    assert len(resistance) == BENCHES and inside(resistance) >= LEAST
    assert abs(np.mean(resistance[:, 0] / resistance[:, 3])) < 1.5e-2
    assert inside(resistance, common=False) < inside(
        resistance
    )  # control: levels and scales are off in all runs alike
    assert (
        np.mean(eq_3[:, 0] / eq_3[:, 3]) > 0.03
    )  # the paper's formula counts air and corner as friction
