"""Blocks that slide to rest on a level plate: friction of each differs, and changes
along its way. Drawn by small steps of its own."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kstest

from benchtwin.rigs.slide.diagnose import diagnose_slide
from benchtwin.rigs.slide.read import SeenSlide

G, STEP_S = 9.80665, 1e-4
SEED = {"length_mm": 100.0, "width_mm": 100.0, "thickness_mm": 100.0, "mass_g": 370.0}


def slides_to_rest(
    rng, count=8, mu=0.22, along=0.015, viscous=0.0, turned=False, landing=0.0, ln_v=0.0
):
    """Blocks of 0.4 to 0.8 m/s, filmed at 150/s to 0.05 mm; along: sd of friction,
    which a random walk through a tenth of the way takes to another value; landing: sd
    of friction in the first 10 ms and, with the other sign, in the next 20; ln_v: how
    friction rises with the logarithm of speed."""
    out = []
    for k in range(count):
        own = mu + 0.003 * rng.standard_normal()
        spots = along * rng.standard_normal(20)
        v, x, places = rng.uniform(0.4, 0.8), 0.0, []
        hit = landing and landing * rng.standard_normal()
        while v > 0:
            here = own + np.interp(x / 0.01, np.arange(20), spots) + viscous * v
            here += ln_v * np.log(max(v, 0.01) / 0.2)
            since = len(places) * STEP_S
            here += hit if since < 0.01 else -hit / 2 if since < 0.03 else 0.0
            v -= G * here * STEP_S
            x += max(v, 0.0) * STEP_S
            places.append(1e3 * x)
        t = np.arange(int(len(places) * STEP_S * 150) + 6) / 150
        at = np.minimum((t / STEP_S).astype(int), len(places) - 1)
        seen = np.array(places)[at] + 0.05 * rng.standard_normal(len(t))
        tilt = np.zeros(len(t)) if turned else None
        camera = {"scale_sd": 1e-3, "plumb_sd_deg": 0.5}
        told = {"slide": {"start_deg": 0.0}, "camera": camera, "seed": SEED, "air": {}}
        frame, no_sd = np.arange(len(t)), np.full(len(t), np.nan)
        out.append(
            SeenSlide(f"s{k}", "", frame, t, seen, no_sd, tilt, description=told)
        )
    return out


@pytest.mark.parametrize("rng", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_friction_that_changes_along_each_way_is_no_finding(rng):
    """All alike it would be one: see below. Friction itself is still known."""
    rng = np.random.default_rng(rng)
    found = diagnose_slide(slides_to_rest(rng), rng)
    assert not found.alarm and found.verdict == "none"
    friction = found.contact["kinetic_friction"].nothing_missing
    # eight blocks, of 0.015 each over a few places on its way: 0.0025
    sd = (friction.high95 - friction.low95) / 3.92
    assert abs(friction.value - 0.22) < 3 * sd < 0.012


def test_nor_are_landings_and_friction_that_grows_a_little_with_speed():
    """As in contact-nets' tosses of a cube."""
    rng = np.random.default_rng(3)
    drawn = slides_to_rest(rng, along=0.02, landing=0.4, ln_v=0.008)
    assert not diagnose_slide(drawn, rng).alarm


def test_what_something_pushes_is_taken_from_its_greatest_speed_on():
    rng = np.random.default_rng(4)
    slides = slides_to_rest(rng, 4, along=0.002)
    time, gained = np.arange(30) / 150, 0.3  # by a push of 0.2 s [m/s]
    first = [round(float(np.diff(s.x_mm)[:6].mean()) * 0.15, 3) for s in slides]
    pushed = []
    for s, v in zip(slides, first, strict=True):
        way = 1e3 * ((v - gained) * time + gained * time**2 / 0.4)
        x = np.append(way, s.x_mm + 1e3 * (v - gained / 2) * 0.2)
        frame = np.arange(len(x))
        no_sd = np.full(len(x), np.nan)
        pushed.append(replace(s, x_mm=x, time_s=frame / 150, frame=frame, sd_mm=no_sd))
    found = diagnose_slide(pushed, rng)
    assert not found.alarm
    assert sum("pushed, are left out" in note for note in found.notes) == 4
    friction = found.contact["kinetic_friction"].nothing_missing
    assert friction.value == pytest.approx(0.22, abs=0.006)


@pytest.mark.slow
def test_it_would_be_one_if_friction_were_taken_for_steady(monkeypatch):
    module = sys.modules["benchtwin.rigs.slide.diagnose"]
    monkeypatch.setattr(module, "with_scatter", lambda prepared, problem: prepared)
    rng = np.random.default_rng(1)
    assert diagnose_slide(slides_to_rest(rng), rng).p_global < 1e-4


@pytest.mark.slow
def test_alarms_where_nothing_is_missing():
    """24 benches, none alarms at 0.005: the chance of two or more is 1 in 150."""
    ps = []
    for seed in range(10, 34):
        rng = np.random.default_rng(seed)
        ps.append(diagnose_slide(slides_to_rest(rng), rng).p_global)
    assert sum(p < 0.005 for p in ps) < 2
    assert kstest(ps, "uniform").pvalue > 0.01


@pytest.mark.slow
def test_friction_that_grows_with_speed_in_all_is_found():
    rng = np.random.default_rng(1)
    found = diagnose_slide(slides_to_rest(rng, along=0.002, viscous=0.15), rng)
    assert found.alarm and "viscous-sliding" in found.names


def test_a_tilt_column_of_a_plate_that_stands_does_as_well():
    rng = np.random.default_rng(5)
    found = diagnose_slide(slides_to_rest(rng, 4, along=0.0, turned=True), rng)
    assert not found.alarm
