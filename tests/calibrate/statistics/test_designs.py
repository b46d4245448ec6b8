"""Designs against the published ones."""

import numpy as np
import pytest

from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.designs import box_behnken, central_composite


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


@pytest.mark.parametrize("k", [3, 4])
def test_what_a_block_shares_leaves_main_effects_alone(k):
    """Points of a block may share a packing: its scatter must cancel in every main
    effect."""
    designs = [
        box_behnken(unit_box(k), centre_points=2),
        central_composite(unit_box(k), centre_points=2),
    ]
    for design in designs:
        outer = design[design["point"] != "centre"]
        assert (design.loc[design["point"] == "centre", "block"] == -1).all()
        sums = outer.groupby("block")[[c for c in outer if c.endswith("_coded")]].sum()
        assert len(sums) >= 3 and not sums.to_numpy().any()


def test_the_papers_design_is_box_behnken(runs):
    published = sorted(map(tuple, runs[["A", "B", "C"]].to_numpy()))
    assert (
        sorted(map(tuple, coded(box_behnken(unit_box(3), centre_points=5))))
        == published
    )


@pytest.mark.parametrize("k", [2, 3, 4])
def test_a_face_centred_composite_is_a_cube_with_faces_and_tells_quadratic_terms_apart(
    k,
):
    design = central_composite(unit_box(k), centre_points=2)
    z, kinds = coded(design), design["point"]
    assert kinds.value_counts().to_dict() == {
        "factorial": 2**k,
        "axial": 2 * k,
        "centre": 2,
    }
    assert abs(z).max() == 1 and (abs(z[kinds == "axial"]).sum(axis=1) == 1).all()
    x = polynomial.matrix(z, polynomial.full(k))
    assert np.linalg.matrix_rank(x) == x.shape[1] and not z.sum(axis=0).any()


def test_natural_values_are_those_of_the_box_without_rounding_errors(box):
    assert set(box_behnken(box, centre_points=1)["static_friction"]) == {0.4, 0.5, 0.6}


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: box_behnken(unit_box(2), centre_points=3), "3 to 5 factors"),
        (lambda: box_behnken(unit_box(6), centre_points=3), "3 to 5 factors"),
        (lambda: box_behnken(unit_box(3), centre_points=0), "centre_points"),
        (lambda: central_composite(unit_box(3), centre_points=0), "centre_points"),
    ],
)
def test_bad_designs_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
