"""Designs against the published ones."""

import itertools

import numpy as np
import pytest

from calibrate.statistics import terms as polynomial
from calibrate.statistics.box import Box
from calibrate.statistics.designs import BEHNKEN_BLOCKS, box_behnken, central_composite

# Box & Behnken (1960), factors from 1: six and seven factors
PUBLISHED = {
    6: [(1, 2, 4), (2, 3, 5), (3, 4, 6), (1, 4, 5), (2, 5, 6), (1, 3, 6)],
    7: [(4, 5, 6), (1, 6, 7), (2, 5, 7), (1, 2, 4), (3, 4, 7), (1, 3, 5), (2, 3, 6)],
}


def unit_box(k):
    return Box(tuple(f"x{i}" for i in range(k)), -np.ones(k), np.ones(k))


def coded(design):
    return design[[c for c in design if c.endswith("_coded")]].to_numpy()


@pytest.mark.parametrize(("k", "edges"), [(3, 12), (4, 24), (5, 40), (6, 48), (7, 56)])
def test_box_behnken_has_the_published_runs(k, edges):
    design = box_behnken(unit_box(k), centre_points=4)
    z = coded(design)
    assert (len(design), (design["point"] == "edge").sum()) == (edges + 4, edges)
    assert len(np.unique(z, axis=0)) == edges + 1
    assert set((z[:edges] != 0).sum(axis=1)) == {2 if k < 6 else 3}


@pytest.mark.parametrize("k", [6, 7])
def test_six_and_seven_factors_use_the_published_blocks(k):
    varied = {tuple(np.flatnonzero(row) + 1) for row in coded(box_behnken(unit_box(k), centre_points=1)) if row.any()}
    assert varied == set(PUBLISHED[k])
    together = [sum({i, j} <= set(b) for b in BEHNKEN_BLOCKS[k]) for i, j in itertools.combinations(range(k), 2)]
    assert set(together) == ({1} if k == 7 else {1, 2})


@pytest.mark.parametrize("k", [3, 4, 5, 6, 7])
def test_box_behnken_tells_all_quadratic_terms_apart(k):
    z = coded(box_behnken(unit_box(k), centre_points=3))
    x = polynomial.matrix(z, polynomial.full(k))
    assert np.linalg.matrix_rank(x) == x.shape[1]
    mixed = x[:, 1 : 1 + k].T @ x[:, 1 + k : -k]
    assert not mixed.any() and not z.sum(axis=0).any()


@pytest.mark.parametrize("k", [3, 4, 7])
def test_what_a_block_shares_leaves_main_effects_alone(k):
    """Points of a block may share a packing: its scatter must cancel in every main effect."""
    designs = [box_behnken(unit_box(k), centre_points=2), central_composite(unit_box(k), centre_points=2, alpha="face")]
    for design in designs:
        outer = design[design["point"] != "centre"]
        assert (design.loc[design["point"] == "centre", "block"] == -1).all()
        sums = outer.groupby("block")[[c for c in outer if c.endswith("_coded")]].sum()
        assert len(sums) >= 3 and not sums.to_numpy().any()


def test_the_papers_design_is_box_behnken(runs):
    published = sorted(map(tuple, runs[["A", "B", "C"]].to_numpy()))
    assert sorted(map(tuple, coded(box_behnken(unit_box(3), centre_points=5)))) == published


def test_run_order_is_drawn_and_repeatable(box):
    one, two = (box_behnken(box, centre_points=5, rng=np.random.default_rng(4)) for _ in range(2))
    other = box_behnken(box, centre_points=5, rng=np.random.default_rng(5))
    assert one.equals(two) and list(one["standard"]) != list(other["standard"])
    assert list(one["run"]) == list(range(1, 18)) and sorted(one["standard"]) == list(range(1, 18))
    assert set(one["static_friction"]) == {0.4, 0.5, 0.6}


def prediction_variance(z, at):
    x = polynomial.matrix(z, polynomial.full(z.shape[1]))
    a = polynomial.matrix(at, polynomial.full(z.shape[1]))
    return np.einsum("ij,jk,ik->i", a, np.linalg.inv(x.T @ x), a)


@pytest.mark.parametrize("k", [2, 3, 4])
def test_rotatable_means_equal_variance_at_equal_distance(k):
    rng = np.random.default_rng(0)
    sphere = rng.standard_normal((20, k))
    sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
    rotatable = prediction_variance(coded(central_composite(unit_box(k), centre_points=5)), sphere)
    face = prediction_variance(coded(central_composite(unit_box(k), centre_points=5, alpha="face")), sphere)
    assert np.ptp(rotatable) < 1e-9 < 1e-3 < np.ptp(face)


@pytest.mark.parametrize(("k", "centre", "alpha"), [(2, 1, 1.0), (3, 1, 1.2154), (4, 1, 1.4142), (2, 2, 1.0781), (3, 3, 1.3531)])
def test_orthogonal_axial_distance_is_the_textbook_one(k, centre, alpha):
    z = coded(central_composite(unit_box(k), centre_points=centre, alpha="orthogonal"))
    assert z.max() == pytest.approx(alpha, abs=2e-4)
    squares = z**2 - (z**2).mean(axis=0)
    gram = squares.T @ squares
    assert abs(gram - np.diag(np.diag(gram))).max() < 1e-9


def test_composite_points_and_half_fraction():
    full = central_composite(unit_box(5), centre_points=2)
    half = central_composite(unit_box(5), centre_points=2, half_fraction=True)
    assert (full["point"].value_counts()["factorial"], half["point"].value_counts()["factorial"]) == (32, 16)
    assert coded(half).max() == pytest.approx(2.0)
    x = polynomial.matrix(coded(half), polynomial.full(5))
    assert np.linalg.matrix_rank(x) == 21


def test_inscribed_points_stay_in_the_box(box):
    out, inside = central_composite(box, centre_points=3), central_composite(box, centre_points=3, inscribed=True)
    assert abs(coded(out)).max() > 1.6 and abs(coded(inside)).max() == pytest.approx(1.0)
    assert inside["rolling_friction"].min() == pytest.approx(0.03)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: box_behnken(unit_box(2), centre_points=3), "3 to 7 factors"),
        (lambda: box_behnken(unit_box(8), centre_points=3), "3 to 7 factors"),
        (lambda: box_behnken(unit_box(3), centre_points=0), "centre_points"),
        (lambda: central_composite(unit_box(3), centre_points=3, alpha="far"), "alpha"),
        (lambda: central_composite(unit_box(3), centre_points=3, half_fraction=True), "half_fraction"),
        (lambda: central_composite(unit_box(1), centre_points=3), "2 to 8"),
    ],
)
def test_bad_designs_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
