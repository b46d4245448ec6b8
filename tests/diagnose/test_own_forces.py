"""Flights that differ by a force of their own, drawn: its size, no alarm for it, and
what all flights have in common found beside it."""

from dataclasses import replace

import numpy as np
import pytest
from falling import Bench, tracks

from benchtwin.bench.priors import FARTHEST_M
from benchtwin.diagnose.words import verdict_in_words
from benchtwin.infer import own_scatter
from benchtwin.rigs.drop import joint_problem, reduction
from benchtwin.rigs.drop.diagnose import diagnose_drop
from benchtwin.rigs.drop.joint_problem import (
    fit_flights,
    prepare_sessions,
    with_own_forces,
)
from benchtwin.rigs.drop.nuisances import APPROACH
from benchtwin.rigs.drop.read import SeenTrack

G, FPS, NOISE_MM = 9.80665, 150.0, 0.02
CAMERA = {"scale_sd": 0.002, "plumb_sd_deg": 0.05, "distance_mm": 20000.0}


def flights(seed, own=0.0, common=(0.0, 0.0), count=9):
    """Tosses of 15 rows, each with a force N(0, own²) [m/s²] of its own each way."""
    rng, out = np.random.default_rng(seed), []
    for k in range(count):
        t = np.arange(15) / FPS
        start, force = rng.uniform((0.5, -0.5), (1.5, 0.5)), rng.normal(0, 1, 2) * own
        pull = np.array([0.0, -G]) + common + force
        places = 1e3 * (np.outer(t, start) + np.outer(t**2 / 2, pull))
        x, y = (places + NOISE_MM * rng.standard_normal(places.shape)).T
        about = {"camera": CAMERA, "air": {"density_kg_m3": 0.0}}
        out.append(
            SeenTrack(
                f"toss-{k}",
                "",
                np.arange(15),
                t,
                x,
                y,
                np.full(15, np.nan),
                np.ones(15),
                flight=np.zeros(15, dtype=int),
                description=about,
            )
        )
    return out


def own_force(seen):
    sessions, _ = prepare_sessions(seen)
    found = with_own_forces(sessions, fit_flights(sessions))
    return found[0].problem.model.own_force


def test_the_size_of_own_forces_is_found_and_what_is_common_is_none_of_it():
    """Over eight benches of nine flights, a steady force of .1 alone: a root of the
    mean square over three orders of time of .1/√3, and of noise what it can hide
    (NOISE_MM over 5 ms² of t²/2: .004 m/s², an order of time .01 to .02)."""
    found = np.array([own_force(flights(seed, 0.1)) for seed in range(8)])
    assert 0.045 < np.exp(np.log(found).mean()) < 0.09
    for common in ((0.0, 0.0), (0.3, 0.3)):
        none = np.array([own_force(flights(seed, 0, common)) for seed in range(8)])
        assert np.exp(np.log(none).mean()) < 0.025


@pytest.mark.parametrize("linearised", [False, True])
def test_a_distance_that_nobody_states_is_found(linearised, monkeypatch):
    """1 m, within a factor of 3 of each of three benches of five drops: motion towards
    the camera is believed as fast as that across, no better; as a control, of
    likelihoods that are linearised where the camera is far away."""
    real, far = joint_problem.fit_flights, []

    def as_from_far(sessions, near=None):
        if near is None:
            far.append(real(sessions))
            return far[-1]
        moved, at = joint_problem.joint_flights(sessions), far[-1]
        reduced = moved.reduce(at.starts, at.values)[0]
        return replace(at, problem=moved, reduced=reduced)

    if linearised:
        monkeypatch.setattr(joint_problem, "fit_flights", as_from_far)
    near = Bench(away=1.0, noise_mm=0.03, rho=0.0, tip_deg=20.0)
    found = []
    for seed in (1, 2, 3):
        seen = tracks(near, 5, np.random.default_rng(seed))
        session = prepare_sessions(seen, FARTHEST_M)[0][0]
        model = joint_problem.with_distance(session).problem.model
        found.append(model.session.away[0])
    assert (max(found) < 3.0) != linearised
    assert min(found) > 1 / 3


def test_one_flight_that_is_far_off_makes_no_other_wide(monkeypatch):
    """71 m/s² of one of nine, a thousand times what the others differ by; as a control
    more than twice theirs where odd flights differ by ten times."""
    seen = flights(3, 0.05)
    thrown = replace(seen[4], y_mm=seen[4].y_mm + 1e3 * 71 * seen[4].time_s ** 2 / 2)
    odd, usual = [*seen[:4], thrown, *seen[5:]], own_force(seen).min()
    wide = own_force(odd).min()
    monkeypatch.setattr(own_scatter, "ODD", (10.0,))
    assert own_force(odd).min() > 2 * wide > usual


def test_a_flight_that_was_pushed_is_named_and_widens_no_other(monkeypatch):
    """One of nine falls at 9.09 m/s²: it is said by name, and the others' own forces
    stay within a half of what they are without it; as a control they more than double
    where no flight may be odd. No name where none was."""
    seen = flights(3, 0.05)
    pushed = replace(seen[4], y_mm=seen[4].y_mm + 1e3 * 0.71 * seen[4].time_s ** 2 / 2)
    odd = [*seen[:4], pushed, *seen[5:]]
    found = diagnose_drop(odd, np.random.default_rng(0))
    assert not found.alarm
    assert any(note.startswith("toss-4: something") for note in found.notes)
    clean = diagnose_drop(seen, np.random.default_rng(0))
    assert not any("toss-" in note for note in clean.notes)
    usual = own_force(seen).min()
    assert own_force(odd).min() < 1.5 * usual
    monkeypatch.setattr(joint_problem, "ODD_FLIGHTS", 0.0)
    assert own_force(odd).min() > 2 * usual


def test_own_forces_that_no_flight_shows_are_not_said():
    """Of eight benches without any: in at most one, as chance has it (1.92 of ln L)."""
    told = [
        any(
            "of its own" in n
            for n in diagnose_drop(flights(s), np.random.default_rng(0)).notes
        )
        for s in range(8)
    ]
    assert sum(told) <= 1
    shown = diagnose_drop(flights(5, 0.1), np.random.default_rng(0))
    assert any("of its own" in note for note in shown.notes)


def test_own_forces_raise_no_alarm_and_a_force_in_common_is_found(monkeypatch):
    """.25 m/s² upwards beside .08 of each flight's own: 8 of its sds; as a control the
    same flights without a force of their own in the baseline."""

    def finding(common):
        seen = flights(5, 0.08, common)
        return diagnose_drop(seen, np.random.default_rng(0))

    assert not finding((0.0, 0.0)).alarm
    assert finding((0.0, 0.25)).alarm
    monkeypatch.setattr(joint_problem, "with_own_forces", lambda seen, fit: seen)
    assert finding((0.0, 0.0)).alarm


def test_flights_that_differ_by_a_sizeable_share_of_the_weight_are_a_finding():
    """1.8 m/s² from flight to flight, as hard spin gives balls: said with its size."""
    found = diagnose_drop(flights(2, 1.8), np.random.default_rng(0))
    assert found.alarm and found.verdict == "unknown" and not found.names
    assert found.sectors[0].name == "flight"
    said = verdict_in_words(found)
    assert "each flight is pushed by" in said and "spin" in said
    assert not any("of its own" in note for note in found.notes)  # once


@pytest.mark.slow
@pytest.mark.parametrize(
    ("own", "count", "least", "most"), [(1.8, 10, 9, 10), (0.1, 20, 0, 0)]
)
def test_only_flights_that_differ_by_much_alarm(own, count, least, most):
    seen = [flights(100 + k, own) for k in range(count)]
    found = [diagnose_drop(s, np.random.default_rng(0)) for s in seen]
    assert least <= sum(f.alarm for f in found) <= most
    assert all(f.verdict in ("none", "unknown") for f in found)


@pytest.mark.slow
def test_p_of_benches_with_own_forces_holds_its_level():
    seen = [flights(seed, 0.1, count=7) for seed in range(60)]
    p = np.array([diagnose_drop(s, np.random.default_rng(1)).p_global for s in seen])
    assert (p < 0.05).sum() <= 7  # of 3 expected


@pytest.mark.parametrize("common", [True, False])
def test_seeds_that_all_come_nearer_raise_no_alarm(common, monkeypatch):
    """12 mm in half a second, 8 m away, which nobody stated; as a control, without
    what approaches have in common."""
    if not common:
        monkeypatch.setitem(reduction.PRIORS, APPROACH, 1e-6)
    rng, seen = np.random.default_rng(4), flights(4, count=10)
    camera = {k: v for k, v in CAMERA.items() if k != "distance_mm"}
    for k, one in enumerate(seen):
        t = np.arange(250) / 500
        nearer = 1 / (1 - t * rng.uniform(0.02, 0.03) / 8.0)
        fallen = 1e3 * (0.6 - G * t**2 / 2) * nearer
        across = 2.0 * rng.standard_normal() * t
        x, y = np.array([across, fallen]) + 0.01 * rng.standard_normal((2, len(t)))
        seen[k] = replace(
            one,
            frame=np.arange(len(t)),
            time_s=t,
            x_mm=x,
            y_mm=y,
            sd_mm=np.full(len(t), np.nan),
            weight=np.ones(len(t)),
            flight=np.zeros(len(t), dtype=int),
            description=one.description | {"camera": camera},
        )
    found = diagnose_drop(seen, np.random.default_rng(0))
    assert found.alarm != common
