"""Unseen depth: what a pinhole camera shows of it, in closed form."""

import math

import numpy as np
import pytest
from benchtwin.vision.motion.flight import Gravity, fit_flights
from benchtwin.vision.motion.gravity import (
    depth_drift_sd,
    depth_drift_shifts,
    inverse_distance,
)


def test_no_drift_costs_nothing():
    assert depth_drift_sd(np.zeros(2), np.array([0.3, 0.2]), 1500.0, 800.0) == 0


def test_scale_follows_the_mean_depth_of_each_flight():
    """50 mm/s for .2 s is 5 mm on average, at 500 mm 1 %; a plate near the optical axis
    (slow impact) adds little."""
    share = depth_drift_sd(np.array([0.0, 50.0]), np.array([0.3, 0.2]), 300.0, 500.0)
    assert share == pytest.approx(0.01, rel=0.02)


def test_an_unknown_distance_is_no_far_one():
    """Mean of 1/D² over factors of distance alike, against a sum."""
    distance = np.geomspace(300, 20_000, 200_001)
    assert inverse_distance(None) == pytest.approx(
        math.sqrt(np.mean(distance**-2.0)), rel=1e-3
    )
    assert inverse_distance(2000.0) == 1 / 2000


def test_a_drift_towards_the_camera_is_seen_as_height_away_from_its_axis():
    """A pinhole shows (h − c) D/(D + z): 40 mm/s away at 500 mm, an axis 30 mm above
    the plate, against the exact picture."""
    t = np.arange(0.0, 0.6, 1 / 240)
    fall, e, g, high = 0.2, 0.6, 9806.65, 9806.65 * 0.2**2 / 2
    late = t - fall
    h = np.where(t < fall, high - g * t**2 / 2, e * g * fall * late - g * late**2 / 2)
    h = np.where(late > 2 * e * fall, 0.0, h)
    keep = late < 2 * e * fall
    t, h, late = t[keep], h[keep], late[keep]
    across = np.where(late > 0, 40.0 * late, 0.0)
    flights = fit_flights(
        t, np.arange(len(t)), h, across, np.full(len(t), 0.02), Gravity(g, 0.003)
    )
    before, after = depth_drift_shifts(flights, t, h, across, 30.0, 500.0)
    exact = (h - 30.0) * (500.0 / (500.0 + 40.0 * np.clip(late, 0, None)) - 1)
    assert np.abs(before).max() < 0.02
    assert after == pytest.approx(exact, abs=0.03 * np.abs(exact).max())
