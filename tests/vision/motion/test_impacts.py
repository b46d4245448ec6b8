"""Drops that were heard: times of impacts alone."""

import numpy as np
import pytest
from drops import drop
from synthetic.motion import draw_drop

from benchtwin.rigs.drop.heard import measure_impacts


def test_impact_times_give_speeds_and_restitution():
    truth = draw_drop(restitution=0.6, max_bounces=6).truth
    times = np.array([b["t_s"] for b in truth["bounces"]])
    quantities, table, _ = measure_impacts(times, None, drop())
    found = {q.name: q for q in quantities}
    for name in (
        "rebound_height",
        "restitution",
        "impact_speed",
        "rebound_speed",
        "restitution_normal",
    ):
        assert abs(found[name].value - truth[name]) < 2 * found[name].sd + 1e-6, name
    assert np.allclose(table.restitution, 0.6, atol=1e-3)


def test_impact_intervals_are_honest_and_a_missed_impact_is_said():
    inside = []
    times = np.array(
        [b["t_s"] for b in draw_drop(restitution=0.7, max_bounces=5).truth["bounces"]]
    )
    for seed in range(300):
        heard = times + 2e-4 * np.random.default_rng(seed).standard_normal(len(times))
        table = measure_impacts(heard, None, drop())[1]
        inside += list(
            np.abs(table.restitution[1:4] - 0.7) < 1.96 * table.restitution_sd[1:4]
        )
    assert 0.92 < np.mean(inside) < 0.98
    missed = measure_impacts(np.delete(times, 1), None, drop())
    assert (
        any("missed" in note for note in missed[2])
        or missed[0][0].quality == "doubtful"
    )
    later = measure_impacts(np.delete(times, 2), None, drop())
    assert any("missing" in note for note in later[2])


def test_a_missing_impact_and_a_wrong_unit():
    times = np.array([b["t_s"] for b in draw_drop(max_bounces=5).truth["bounces"]])

    def measured(times, known=None):
        return {q.name: q for q in measure_impacts(times, None, known or drop())[0]}

    assert {q.quality for q in measured(times).values()} == {"good"}  # control
    gone = measured(np.delete(times, 1))  # restitutions .75, .167, .50
    for name in (
        "rebound_height",
        "rebound_speed",
        "restitution",
        "restitution_normal",
    ):
        assert (
            gone[name].quality == "doubtful"
            and "an impact seems to be missing" in gone[name].reason
        )
    assert gone["impact_speed"].quality == "good"
    late = measure_impacts(np.delete(times, 3), None, drop())
    assert {q.quality for q in late[0]} == {"good"} and any(
        "impact seems to be missing" in note for note in late[2]
    )
    without = measured(np.delete(times, 1), drop(height=None))
    assert (
        without["restitution_normal"].quality == "doubtful"
        and "missing" in without["restitution_normal"].reason
    )
    slow = measured(1000 * times).values()
    assert all(q.quality == "failed" and "milliseconds" in q.reason for q in slow)


def test_a_height_that_cannot_be_leaves_the_bounces_their_own():
    """31 mm stated of a drop from 310, e 0.5: what hangs on the height fails, the rest
    is as without it, and the likely height is named."""
    times = np.array([b["t_s"] for b in draw_drop(max_bounces=5).truth["bounces"]])
    low, bounces, notes = measure_impacts(times, None, drop(height=31))
    found = {q.name: q for q in low}
    assert {found[n].quality for n in ("restitution", "impact_speed")} == {"failed"}
    for name in ("rebound_height", "rebound_speed", "restitution_normal"):
        assert found[name].quality == "doubtful"
        assert "The bounces behind make 310 mm likely" in found[name].reason
    assert abs(found["rebound_height"].value - 77.5) < 2 * found["rebound_height"].sd
    assert bounces.restitution[1:].to_numpy() == pytest.approx(0.5, abs=0.01)
    assert any("no sd_s is stated" in note for note in notes)


def test_impact_times_without_a_height_ask_for_it():
    times = np.array([0.25, 0.5, 0.625])
    found = {q.name: q for q in measure_impacts(times, None, drop(height=None))[0]}
    assert (
        found["restitution"].quality == "failed"
        and "height_mm" in found["restitution"].reason
    )
    assert (
        found["restitution_normal"].value == pytest.approx(0.5)
        and found["restitution_normal"].quality == "doubtful"
    )
