"""Held-out figures: what share of what the baseline misses is removed, and when there is no such share."""

import math

import pytest

from calibrate.diagnose.scores import HeldOut


def test_removed_fraction():
    assert HeldOut.of(300.0, 120.0, 100.0).removed_fraction == pytest.approx(0.9)
    assert HeldOut.of(400.0, 100.0, 100.0).rmse_ratio == pytest.approx(0.5)
    assert HeldOut.of(300.0, 80.0, 100.0).removed_fraction > 1  # not held down: a fit below the noise is seen as such


@pytest.mark.parametrize("noise", [100.0, 100.0000001, 130.0])
def test_a_baseline_that_misses_nothing_has_no_share_to_remove(noise):
    assert math.isnan(HeldOut.of(100.0, 99.0, noise).removed_fraction)
