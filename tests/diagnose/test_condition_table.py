"""Conditions in the table of a rig's own numbers: truth drawn for every shape, and
nothing there."""

import math

import numpy as np
import pytest

from benchtwin.infer.condition_table import (
    Numbers,
    condition_table,
    numbers_of,
)
from benchtwin.infer.conditions import Contact, conditions_of
from benchtwin.infer.linear import Reduced
from benchtwin.infer.problem import Fit, Problem

CONTACT = Contact("restitution", "e", 1.0, "impact")
PLATES = ("steel", "glass", "rubber")
SD = 0.01


def table_of(shift, conditions, rng, scatter=1.0):
    """Numbers with these shifts, of scatter SD, that state these conditions (dict of
    lists)."""
    count = len(shift)
    names = tuple(f"drop-{k:02d}" for k in range(count))
    y = np.asarray(shift, float) + scatter * SD * rng.standard_normal(count)
    told = [
        {"conditions": {n: v[k] for n, v in conditions.items() if v[k] is not None}}
        for k in range(count)
    ]
    found, _ = conditions_of(names, told, [""] * count)
    return condition_table(
        Numbers(names, y, SD**2 * np.eye(count)), CONTACT, found, rng
    )


def of_snr(shape: np.ndarray, snr: float) -> np.ndarray:
    about = shape - shape.mean()
    return snr * SD * about / math.sqrt(float(about @ about))


def drawn(rng, count=16):
    """Two numbers and a word, in an order of their own."""
    x = np.round(rng.permutation(np.linspace(8, 20, count)) + rng.uniform(0, 0.3), 1)
    other = np.round(rng.uniform(980, 1030, count))
    plate = rng.permutation(np.arange(count) % 3)
    u = (x - x.min()) / np.ptp(x)
    stated = {
        "moisture_pct": x.tolist(),
        "pressure_mbar": other.tolist(),
        "plate": [PLATES[k] for k in plate],
    }
    return u, plate, stated


SHAPES = {
    "line": lambda u, plate: u,
    "levelling off": lambda u, plate: 1 - np.exp(-6 * u),
    "steepening": lambda u, plate: np.exp(-6 * (1 - u)),
    "lowest": lambda u, plate: (u - 0.5) ** 2,
    "levels": lambda u, plate: np.array([0.0, 0.3, 1.0])[plate],
}


MORE = ("levelling off", "steepening", "lowest")


@pytest.mark.parametrize(
    "shape",
    ["line", "levels", *(pytest.param(s, marks=pytest.mark.slow) for s in MORE)],
)
def test_each_shape_is_found_and_called_so(shape):
    rng = np.random.default_rng(21)
    named, right, cases = 0, 0, 30
    for _ in range(cases):
        u, plate, stated = drawn(rng)
        table = table_of(of_snr(SHAPES[shape](u, plate), 10.0), stated, rng)
        wanted = "plate" if shape == "levels" else "moisture_pct"
        hits = [f for f in table.found if f.condition == wanted]
        named += bool(hits)
        right += bool(hits) and hits[0].shape == shape
        assert all(wanted in (f.condition, *f.as_well) for f in table.found[:1])
    assert named >= 0.9 * cases and right >= 0.75 * named


@pytest.mark.slow
def test_where_nothing_is_followed_nothing_is_found():
    """p is small no more often than it says, whatever the scatter is."""
    rng = np.random.default_rng(12)
    p, found = [], 0
    for k in range(200):
        _, _, stated = drawn(rng, 6 + k % 12)
        table = table_of(np.zeros(6 + k % 12), stated, rng, scatter=1 + k % 2)
        p.append(table.p)
        found += bool(table.found)
    assert found <= 2
    assert np.mean(np.array(p) < 0.005) <= 0.015
    assert np.mean(np.array(p) < 0.05) <= 0.09  # 5 % and two of its sds


def test_of_two_conditions_that_are_one_either_may_be_it():
    rng = np.random.default_rng(13)
    u, _, stated = drawn(rng)
    stated["warmth_c"] = [20 + m / 2 for m in stated["moisture_pct"]]
    found = table_of(of_snr(u, 12.0), stated, rng).found
    assert len(found) == 1
    assert {found[0].condition, *found[0].as_well} == {"moisture_pct", "warmth_c"}


def test_two_conditions_that_act_are_both_found_and_a_third_is_not():
    rng = np.random.default_rng(14)
    u, plate, stated = drawn(rng, 24)
    both = of_snr(u, 12.0) + of_snr(SHAPES["levels"](u, plate), 12.0)
    found = table_of(both, stated, rng).found
    assert {f.condition for f in found} == {"moisture_pct", "plate"}


def test_half_of_the_recordings_state_it_and_a_drift_has_no_cause():
    rng = np.random.default_rng(15)
    u, _, stated = drawn(rng, 24)
    stated["moisture_pct"] = [
        m if k % 2 else None for k, m in enumerate(stated["moisture_pct"])
    ]
    found = table_of(of_snr(u, 16.0), stated, rng).found
    assert [f.condition for f in found] == ["moisture_pct"]
    assert len(found[0].at) == 12 and found[0].shift["drop-00"] == 0
    drift = table_of(of_snr(np.arange(24.0), 10.0), stated, rng).found
    assert [(f.condition, f.unlisted) for f in drift] == [("order", True)]


def test_a_curve_that_rests_on_one_recording_is_not_tried():
    """A control: the same shift over a condition that several share is found."""
    rng = np.random.default_rng(16)
    stated = {"moisture_pct": [20.0] + [8.0 + 0.01 * k for k in range(11)]}
    shift = np.r_[0.3, np.zeros(11)]
    assert not table_of(shift, stated, rng).found
    stated = {"moisture_pct": [8.0, 20.0] * 6}
    found = table_of(np.array([0.0, 0.3] * 6), stated, rng).found
    assert [f.condition for f in found] == ["moisture_pct"]


def test_one_recording_far_off_hides_nothing():
    """0.5 beside a line of 0.1 over the range; a level of one recording is left out."""
    rng = np.random.default_rng(18)
    u, _, stated = drawn(rng)
    shift = 0.1 * u
    shift[5] -= 0.5
    table = table_of(shift, {"moisture_pct": stated["moisture_pct"]}, rng)
    assert table.far is not None and table.far[0] == "drop-05"
    assert [(f.condition, f.shape) for f in table.found] == [("moisture_pct", "line")]
    plates = ["steel", "glass"] * 8
    plates[5] = "rubber"
    found = table_of(
        0.1 * np.array([p == "glass" for p in plates]), {"plate": plates}, rng
    )
    assert [f.condition for f in found.found] == ["plate"]
    assert len(found.found[0].curve) == 2 and "drop-05" not in found.found[0].at


def test_sizes_are_those_of_the_truth():
    """Slope, curve and left-out values of a line of 0.02 per %, sd 0.01 each."""
    rng = np.random.default_rng(17)
    _, _, stated = drawn(rng)
    x = np.array(stated["moisture_pct"])
    follow = table_of(0.02 * x, stated, rng).found[0]
    assert follow.slope.low95 < 0.02 < follow.slope.high95
    assert follow.slope.value == pytest.approx(0.02, abs=3 * SD / math.sqrt(16) / 3.6)
    ends = follow.curve[-1].size.value - follow.curve[0].size.value
    assert ends == pytest.approx(0.02 * np.ptp(x), rel=0.06)
    left = np.array(list(follow.left_out.values()))
    assert left == pytest.approx(0.02 * (x - x.mean()), abs=0.02)


def test_numbers_are_each_recordings_own_beside_what_is_common():
    """Two rows a recording: e_r, and e_r + s of a scale common to all with sd 1: own
    values are the first rows' where the scale is free, sd 1."""
    true = np.array([0.0, 3.0, -2.0, 5.0])
    a = np.array([[1.0, 0.0], [1.0, 1.0]])
    reduced = tuple(Reduced(a, np.zeros((2, 0)), np.array([v, v + 40.0])) for v in true)
    problem = Problem(
        "drop",
        ("a", "b", "c", "d"),
        {},
        ("e", "scale"),
        {"scale": 1e6},
        np.zeros((4, 0)),
        lambda *args: None,
        8,
        0.0,
        None,
    )
    of = Fit(
        problem,
        np.array([0.0, 1e6]),
        np.zeros(2),
        np.eye(2),
        np.zeros((4, 0)),
        0.0,
        reduced,
    )
    made = numbers_of(of, "e")
    assert made is not None and made.recordings == problem.recordings
    assert made.values - made.values.mean() == pytest.approx(true - true.mean())
    # four second rows share one unknown: own sds between 1/√2 and 1
    contrast = np.array([0.5, 0.5, -0.5, -0.5])
    assert contrast @ made.covariance @ contrast == pytest.approx(0.5, rel=1e-3)
