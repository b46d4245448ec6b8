"""Drops of which only the times of impacts are known: what drag does to restitution as
read from them."""

import numpy as np
import pytest

from benchtwin.bench.air import air_of, drag_at, hop_s
from benchtwin.bench.constants import G_M_S2
from benchtwin.rigs.drop.diagnose import diagnose_drop
from benchtwin.rigs.drop.effects.hooks import Hits, slowed
from benchtwin.rigs.drop.read import SeenTrack

BALL = {"length_mm": 40.0, "width_mm": 40.0, "thickness_mm": 40.0, "mass_g": 2.7}
E, TIME_SD_S = 0.95, 5e-5


def hops(drag: float, e: np.ndarray, height_m: float) -> np.ndarray:
    """Times [s] between the impacts of a ball that falls from `height_m`, a = −g −
    `drag` v |v|."""
    out, rise = [], height_m
    for own in e:
        arrives = np.sqrt(G_M_S2 / drag * -np.expm1(-2 * drag * rise))
        rise = np.log1p(drag * (own * arrives) ** 2 / G_M_S2) / (2 * drag)
        out.append(float(hop_s(rise, drag)))
    return np.array(out)


def drops(stated: float, true: float) -> list[SeenTrack]:
    """Balls heard 8 times each; density of the air as stated, and over what a sphere's
    drag is, in truth."""
    rng, seen = np.random.default_rng(1), []
    drag = true * drag_at(air_of({"seed": BALL}), 1.5)
    for k in range(12):
        height = (0.1, 0.2, 0.3, 0.5)[k % 4]
        e = E + 0.003 * rng.standard_normal(8)
        times = np.concatenate([[0.0], np.cumsum(hops(drag, e, height))])
        about = {"seed": BALL, "air": {"density_kg_m3": stated}}
        about |= {"camera": {}, "drop": {"height_mm": 1e3 * height}}
        heard = times + TIME_SD_S * rng.standard_normal(len(times))
        sds = {"contacts_sd_s": np.full(len(times), TIME_SD_S), "description": about}
        seen.append(SeenTrack(f"ball-{k}", "", contacts_s=heard, **sds))
    return seen


def test_restitution_by_times_is_less_by_what_drag_does():
    """To second order in drag: a thousandth of e."""
    share, speed = 0.03, np.array([0.5, 1.0, 2.0])
    k = share * G_M_S2 / 4
    before = speed / np.sqrt(1 - k * speed**2 / G_M_S2)  # of the hop that ended so fast
    rise = [np.log1p(k * v**2 / G_M_S2) / (2 * k) for v in (before, E * speed)]
    read = hop_s(rise[1], k) / hop_s(rise[0], k)
    hits = Hits(speed, *4 * [np.zeros(3)], np.ones(3))
    assert slowed(hits, np.full(3, E), share) == pytest.approx(read, abs=1e-3)


def test_air_that_is_withheld_is_missed_in_times_of_impacts():
    found = diagnose_drop(drops(0.0, 1.0), np.random.default_rng(0))
    assert found.alarm and dict(found.effects)["drag"].probability > 0.1


def test_a_drag_a_little_beside_a_spheres_raises_no_alarm():
    assert not diagnose_drop(drops(1.2, 1.12), np.random.default_rng(0)).alarm
