"""Unseen depth: what a pinhole camera shows of it, in closed form."""

import math

import numpy as np
import pytest

from vision.motion.depth import drift_share, per_distance


def test_no_drift_costs_nothing():
    assert drift_share(np.zeros(2), np.array([0.3, 0.2]), 1500.0, 800.0) == 0


def test_scale_follows_the_mean_depth_of_each_flight():
    """50 mm/s for .2 s is 5 mm on average, at 500 mm 1 %; a plate near the optical axis (slow impact) adds little."""
    share = drift_share(np.array([0.0, 50.0]), np.array([0.3, 0.2]), 300.0, 500.0)
    assert share == pytest.approx(0.01, rel=0.02)


def test_an_unknown_distance_is_no_far_one():
    """Mean of 1/D² over factors of distance alike, against a sum."""
    distance = np.geomspace(300, 20_000, 200_001)
    assert per_distance(None) == pytest.approx(math.sqrt(np.mean(distance**-2.0)), rel=1e-3)
    assert per_distance(2000.0) == 1 / 2000
