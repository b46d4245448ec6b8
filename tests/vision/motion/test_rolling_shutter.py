"""Rolling shutter against parabolas read row by row: each place solves y = Y(t +
readout × row / rows)."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchtwin.rigs.drop.keys import Drop
from benchtwin.rigs.drop.measure import measure_drop
from benchtwin.vision.motion.track import make_track
from benchtwin.vision.recording import Air, Camera, Recording

G, E, FPS, HEIGHT, PICTURE = (
    9806.65,
    0.6,
    120.0,
    200.0,
    260.0,
)  # mm, s; the picture is 260 mm high
READOUT = 0.006


def height_at(t):
    fall = np.sqrt(2 * HEIGHT / G)
    first, second = fall, fall + 2 * E * fall
    y = HEIGHT - G * np.clip(t, 0, None) ** 2 / 2
    for start, speed in ((first, E * G * fall), (second, E**2 * G * fall)):
        late = t - start
        y = np.where(late > 0, speed * late - G * late**2 / 2, y)
    return y


@pytest.fixture
def filmed():
    t = np.arange(0.0, 0.62, 1 / FPS)
    y = height_at(t)
    for _ in range(60):  # a contraction: the seed goes slower than the rows are read
        y = height_at(t + READOUT * (1 - y / PICTURE))
    noise = np.random.default_rng(3).normal(0, 0.03, len(t))
    return make_track(t, np.zeros(len(t)), y + noise, sd=0.03), 1 - y / PICTURE


def found(filmed, readout_s, distance_mm=None):
    camera = Camera(
        fps=FPS,
        mm_per_px=0.4,
        mm_per_px_sd=0.0004,
        plumb_deg=0.0,
        plumb_sd_deg=0.05,
        readout_s=readout_s,
        distance_mm=distance_mm,
    )
    known = Recording(
        id="drawn",
        path=Path("drawn"),
        rig="drop",
        evidence="video",
        files=(),
        camera=camera,
        air=Air(density_kg_m3=0),
        drop=Drop(height_mm=HEIGHT),
    )
    track, share = filmed
    rebound = measure_drop(replace(track, late=share), known)
    return (
        next(q for q in rebound.quantities if q.name == "restitution_normal"),
        rebound,
        " ".join(rebound.notes),
    )


def test_a_stated_readout_gives_the_restitution(filmed):
    e, _, note = found(filmed, READOUT)
    assert abs(e.value - E) < 3 * e.sd and e.sd < 0.003
    assert "readout_s" not in note


def test_a_shutter_taken_for_a_global_one_widens_the_interval(filmed):
    """1.9 m/s × 6 ms is 12 mm between top and bottom row: no parabolas under gravity
    pass through that. From a camera whose distance nobody stated a seed may come nearer
    so, and its sd allows for that."""
    e, _, _ = found(filmed, 0.0)
    assert abs(e.value - E) < 3 * e.sd and e.sd > 0.008


def test_an_unknown_readout_is_told_from_down_and_up(filmed):
    e, rebound, note = found(filmed, None)
    assert abs(e.value - E) < 3 * e.sd and e.sd < 0.02
    assert "readout_s is not stated" in note and e.quality == "good", e.reason
    assert np.isclose(rebound.bounces.restitution[0], e.value) and np.isclose(
        rebound.bounces.restitution_sd[0], e.sd
    )
