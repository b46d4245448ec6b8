"""Designs against the published ones, and how evenly the other one fills the box."""

import numpy as np
import pytest
from scipy.stats import qmc

from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.designs import box_behnken, space_filling


def unit_box(k):
    return Box(tuple(f"x{i}" for i in range(k)), -np.ones(k), np.ones(k))


def coded(design):
    return design[[c for c in design if c.endswith("_coded")]].to_numpy()


@pytest.mark.parametrize(("k", "edges"), [(3, 12), (4, 24), (5, 40)])
def test_box_behnken_has_the_published_runs(k, edges):
    design = box_behnken(unit_box(k), centre_points=4)
    z = coded(design)
    assert (len(design), (design["point"] == "edge").sum()) == (edges + 4, edges)
    assert len(np.unique(z, axis=0)) == edges + 1
    assert set((z[:edges] != 0).sum(axis=1)) == {2}


@pytest.mark.parametrize("k", [3, 4, 5])
def test_box_behnken_tells_all_quadratic_terms_apart(k):
    z = coded(box_behnken(unit_box(k), centre_points=3))
    x = polynomial.matrix(z, polynomial.full(k))
    assert np.linalg.matrix_rank(x) == x.shape[1]
    mixed = x[:, 1 : 1 + k].T @ x[:, 1 + k : -k]
    assert not mixed.any() and not z.sum(axis=0).any()


def test_the_papers_design_is_box_behnken(runs):
    published = sorted(map(tuple, runs[["A", "B", "C"]].to_numpy()))
    assert (
        sorted(map(tuple, coded(box_behnken(unit_box(3), centre_points=5))))
        == published
    )


def test_natural_values_are_those_of_the_box_without_rounding_errors(box):
    assert set(box_behnken(box, centre_points=1)["static_friction"]) == {0.4, 0.5, 0.6}


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: box_behnken(unit_box(2), centre_points=3), "3 to 5 factors"),
        (lambda: box_behnken(unit_box(6), centre_points=3), "3 to 5 factors"),
        (lambda: box_behnken(unit_box(3), centre_points=0), "centre_points"),
    ],
)
def test_bad_designs_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_a_space_filling_design_fills_every_factors_range_evenly():
    """One run in each of as many equal parts of every range, more even than random runs
    (discrepancy, the control)."""
    box = Box.of({"a": (0.4, 0.8), "b": (0.0, 1.0), "c": (0.1, 0.2)})
    z = (box.coded(space_filling(box, 24).to_numpy()) + 1) / 2
    for column in z.T:
        assert sorted(np.floor(24 * column)) == list(range(24))
    rng = np.random.default_rng(0)
    chance = [qmc.discrepancy(rng.random((24, 3))) for _ in range(20)]
    assert qmc.discrepancy(z) < min(chance)


def test_factors_of_two_levels_stand_at_the_ends_half_of_the_runs_each():
    box = Box.of({n: (-1.0, 1.0) for n in "abcdef"})
    z = space_filling(box, 24, two_level=3).to_numpy()
    assert set(np.unique(z[:, 3:])) == {-1.0, 1.0} and not z[:, 3:].sum(axis=0).any()
    quadratic = polynomial.matrix(z[:, :3], polynomial.full(3))
    # told apart from the quadratic and from one another
    both = np.column_stack([quadratic, z[:, 3:]])
    assert np.linalg.cond(both) < 2 * np.linalg.cond(quadratic)


def test_the_same_box_has_the_same_design():
    box = unit_box(3)
    assert space_filling(box, 20).equals(space_filling(box, 20))
