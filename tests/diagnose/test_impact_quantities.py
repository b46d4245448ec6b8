"""Quantities of impacts from speeds and spins, and the scatter of bounces."""

import math

import falling
import numpy as np
import pytest

from benchtwin.rigs.drop.impact_quantities import impact_quantities
from benchtwin.rigs.drop.impacts import Impacts, seeds_of
from benchtwin.rigs.drop.variance_components import scatter_of

SOY = {"length_mm": 8.72, "width_mm": 6.84, "thickness_mm": 5.98}


def hit(angle, e):
    """Before and after (v_x, v_z, ω anticlockwise) of an ellipsoid that falls upright
    in the picture plane, without friction."""
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    bench = falling.Bench(e=e, friction=0.0)
    state = (np.zeros(3), np.array([0.0, 0.0, -2.0]), turn, np.zeros(3))
    _, v, _, w = falling.bounce(state, bench, np.array([0.0, 0.0, 1.0]), 1)
    return (0.0, -2.0, 0.0), (v[0], v[2], -w[1])


def test_restitution_of_a_central_impact_is_that_of_the_point_of_contact():
    """A third of a seed's loss of height is spin: where that is seen, e of the contact
    comes back to 3 %."""
    before, after = zip(
        *(hit(angle, 0.6) for angle in (0.0, 0.2, 0.4, -0.3)), strict=True
    )
    none, count = np.zeros(4), len(before)
    table = Impacts(
        ("a",),
        np.zeros(4, dtype=int),
        np.ones(4, dtype=int),
        np.array(before),
        np.array(after),
        np.column_stack([np.arange(count), np.arange(count) + 1]),
        np.zeros((count + 1, 3)),
        none,
        0.0,
        seeds_of([{"seed": SOY}]),
        none,
        np.full(4, np.inf),
        ("",),
        (5.0,),
    )
    seen = impact_quantities(table, 0.19)
    plain = table.after[:, 1] / 2.0
    assert plain.min() < 0.5
    assert seen.e == pytest.approx(0.6, abs=0.02)
    assert seen.e_error == pytest.approx(np.zeros((4, 4)))


def test_a_badly_seen_spin_makes_the_restitution_of_a_long_seed_uncertain():
    """e of the point of contact holds the spins: its stated error is that of redrawn
    ones, and a ball's is nil."""
    before, after = (
        np.array(rows)
        for rows in zip(
            *(hit(angle, 0.6) for angle in (0.05, 0.2, 0.4, -0.3)), strict=True
        )
    )
    sd, rng, flights = 3.0, np.random.default_rng(0), np.arange(8).reshape(4, 2)

    def seen(turned, long):
        sds = np.column_stack([np.zeros((8, 2)), np.full(8, sd)])
        one = np.ones(4, dtype=int)
        table = Impacts(
            ("a",),
            0 * one,
            one,
            before + turned[0],
            after + turned[1],
            flights,
            sds,
            np.zeros(4),
            0.0,
            seeds_of([{"seed": SOY}]),
            np.zeros(4),
            np.full(4, np.inf),
            ("",),
            (5.0,),
        )
        return impact_quantities(table, long)

    redrawn = [
        seen(sd * rng.normal(size=(2, 4, 1)) * [0, 0, 1], 0.19).e for _ in range(2000)
    ]
    told = np.sqrt(np.diag(seen(np.zeros((2, 4, 3)), 0.19).e_error))
    assert told == pytest.approx(np.std(redrawn, axis=0), rel=0.1) and told.max() > 1e-3
    assert np.diag(seen(np.zeros((2, 4, 3)), 0.0).e_error) == pytest.approx(np.zeros(4))


def test_scatter_estimate_is_robust_to_outliers():
    rng = np.random.default_rng(3)
    x = np.tile(np.linspace(-1, 1, 10), 8)
    y = 0.5 + 0.3 * x + 0.02 * rng.normal(size=80)
    y[::10] += 1.0
    design = np.column_stack([np.ones(80), x])
    parts = [np.eye(80), np.diag(np.zeros(80))]
    found = scatter_of(y, design, np.zeros((80, 80)), parts, 0.003)
    sds = np.sqrt(np.diag(found.covariance))
    good = np.ones(80, dtype=bool)
    good[::10] = False
    # Student's weights cost a factor of up to 1.2, what 8 outliers leave up to 2
    assert 0.015 < np.median(sds[good]) < 0.05
    assert sds[~good].min() > 5 * np.median(sds[good])
    assert (
        scatter_of(y[:3], design[:3], np.zeros((3, 3)), [np.eye(3), np.eye(3)], 0.003)
        is None
    )
    twice = scatter_of(
        y, np.column_stack([design, 2 * x - 1]), np.zeros((80, 80)), parts, 0.003
    )  # a law of two columns all the same
    np.testing.assert_allclose(twice.covariance, found.covariance)
