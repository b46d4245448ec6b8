"""The ellipse fit against ellipses drawn by counting sub-pixels, with a mirror image, a
missing rim, or nothing."""

import numpy as np
import pytest

from benchtwin.vision.motion.ellipse import Ellipse, EllipsePose, Patch, fit_ellipse

AXES = (9.0, 8.0)
FINE = 16  # sub-pixels a pixel and axis


def drawn(x, y, turn=0.0, side=44):
    """Share of each pixel inside the ellipse about (x, y)."""
    at = (np.arange(side * FINE) + 0.5) / FINE - 0.5
    u, v = at[None, :] - x, at[:, None] - y
    along, across = (
        u * np.cos(turn) + v * np.sin(turn),
        v * np.cos(turn) - u * np.sin(turn),
    )
    inside = (along / AXES[0]) ** 2 + (across / AXES[1]) ** 2 < 1
    return inside.reshape(side, FINE, side, FINE).mean(axis=(1, 3))


def centroid(coverage):
    rows, columns = np.indices(coverage.shape)
    return (
        np.array([(coverage * columns).sum(), (coverage * rows).sum()]) / coverage.sum()
    )


def laid(coverage, noise=0.05, turn=0.0, from_top=False):
    coverage = coverage + np.random.default_rng(4).normal(0, noise, coverage.shape)
    x, y = centroid(np.clip(coverage * (coverage > 0.5), 0, 1))
    y = np.flatnonzero((coverage > 0.5).sum(axis=1) > 4)[0] + AXES[1] if from_top else y
    start = EllipsePose(x, y, turn, 0.0, 0.0, 0.0)
    return fit_ellipse(
        Ellipse(*AXES),
        Patch(coverage, np.full(coverage.shape, noise), 0, 0),
        start,
        (1.0, 0.0),
        0.45,
    )


@pytest.mark.parametrize("place", [(20.0, 20.0), (20.37, 19.81), (20.5, 20.5)])
def test_a_body_alone_is_found_where_it_is(place):
    found = laid(drawn(*place, turn=0.4), turn=0.3)
    assert np.hypot(found.x - place[0], found.y - place[1]) < 0.06 and found.sd < 0.05
    assert found.turn == pytest.approx(0.4, abs=0.06) and found.edge_share > 0.9


def test_a_mirror_image_at_its_foot_does_not_draw_it_down():
    """The centroid of both is 6 px lower; laid there the outline meets too little, hung
    from the top it meets the seed."""
    seed = drawn(20.2, 17.0)
    image = drawn(20.2, 32.0)
    image[:25] = 0
    seen = np.maximum(seed, 0.7 * image)
    assert centroid(seen)[1] - 17.0 > 2
    assert laid(seen).edge_share < 0.5
    found = laid(seen, from_top=True)
    assert np.hypot(found.x - 20.2, found.y - 17.0) < 0.2 and found.edge_share > 0.8


def test_a_rim_that_is_not_seen_does_not_push_it_up():
    """The lowest 2.5 px are lost before a background of the seed's own colour."""
    seen = drawn(20.2, 20.0)
    seen[26:] = 0
    assert 20.0 - centroid(seen)[1] > 0.7
    found = laid(seen)
    assert np.hypot(found.x - 20.2, found.y - 20.0) < 0.25


def test_nothing_is_met_where_nothing_is():
    empty, start = (
        Patch(np.zeros((44, 44)), np.full((44, 44), 0.05), 0, 0),
        EllipsePose(20, 20, 0.0, 0.0, 0.0, 0.0),
    )
    found = fit_ellipse(Ellipse(*AXES), empty, start, (1.0, 0.0), 0.45)
    assert found is None or found.edge_share < 0.5
