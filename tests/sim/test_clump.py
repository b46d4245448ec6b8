"""Clumps: the fit against balls that are known, its error against closed forms, its
limits, and the seed made from it."""

import numpy as np
import pytest
import seed_forms
from scipy.spatial.transform import Rotation

from benchtwin.sim.picture.outline import silhouette_true
from benchtwin.sim.seed import Seed
from benchtwin.sim.seed.clump import connected, fit_clump, spheres_for
from benchtwin.sim.seed.clump_error import clump_error
from benchtwin.sim.seed.shape import Shape
from benchtwin.sim.seed.surface import area, union_mesh

SHAPES = {
    "ellipsoid": seed_forms.ellipsoid(8.72e-3, 6.84e-3, 5.98e-3),
    "bean with a flat": seed_forms.flattened_ellipsoid(12e-3, 8e-3, 7e-3, 0.75),
    "maize wedge": seed_forms.superquadric(
        11e-3, 7.5e-3, 5e-3, across=0.85, along=0.85, taper=0.3
    ),
    "creased wheat grain": seed_forms.creased_ellipsoid(
        6.5e-3, 3.3e-3, 3.0e-3, depth=0.2, half_width_deg=20.0
    ),
}


def test_balls_are_found_again():
    centres = np.array([[-2.0, 0, 0], [1.0, 0.3, 0], [2.6, 1.5, 0.2]]) * 1e-3
    radii = np.array([2.4, 2.0, 1.2]) * 1e-3
    mesh = union_mesh(centres, radii, 5)
    found, size, error = fit_clump(Shape(mesh.vertices_m, mesh.faces), 3)
    order = [int(np.argmin(np.linalg.norm(found - c, axis=1))) for c in centres]
    # The mesh has flat faces and cuts the seams' corners: 0.5 % of the mean radius.
    assert found[order] == pytest.approx(centres, abs=1.5e-5)
    assert size[order] == pytest.approx(radii, abs=1.5e-5)
    assert error.surface_rms < 0.005


def test_error_of_a_ball_that_is_too_large_is_the_closed_form():
    ball = seed_forms.ellipsoid(2e-3, 2e-3, 2e-3)
    error = clump_error(ball, np.zeros((1, 3)), np.array([1.1e-3]))
    # points lie on flat faces, 1e-3 inside the curve at most
    assert (error.surface_rms, error.surface_mean, error.surface_max) == pytest.approx(
        (0.1, 0.1, 0.1), abs=2e-3
    )
    assert error.volume == pytest.approx(1.1**3 - 1, rel=1e-3)
    assert error.moments == pytest.approx(1.1**5 - 1, rel=2e-3)
    smaller = clump_error(ball, np.array([[0.1e-3, 0, 0]]), np.array([0.8e-3]))
    assert smaller.surface_mean == pytest.approx(
        -0.2, abs=5e-3
    )  # a ball shifted by d: 0.2 + d²/3 on the mean
    assert smaller.surface_max == pytest.approx(0.3, abs=3e-3)
    assert smaller.centre == pytest.approx(0.1, abs=1e-3)


def test_a_point_inside_two_balls_is_as_deep_as_the_way_out_of_both():
    """A sphere inside a dumbbell: towards the second ball the way out leads through
    it."""
    ball = seed_forms.ellipsoid(2e-3, 2e-3, 2e-3)
    error = clump_error(
        ball, np.array([[0.0, 0, 0], [1.0e-3, 0, 0]]), np.array([1.001e-3, 1.2e-3])
    )
    assert error.surface_max == pytest.approx(1.2, abs=0.01)


@pytest.mark.parametrize("name", SHAPES)
def test_few_balls_suffice(name):
    shape = SHAPES[name]
    _, _, eight = fit_clump(shape, 8)
    assert eight.surface_rms < 0.03
    assert abs(eight.volume) < 0.01 and np.abs(eight.moments).max() < 0.02


def test_more_balls_fit_better():
    shape = SHAPES["creased wheat grain"]
    rms = [fit_clump(shape, n)[2].surface_rms for n in (2, 6, 14)]
    assert rms[0] > rms[1] > rms[2]


def test_fit_is_the_same_wherever_the_shape_lies_and_each_time():
    shape = SHAPES["maize wedge"]
    turn = Rotation.from_rotvec([0.3, 0.2, -1.0]).as_matrix()
    centres, radii, error = fit_clump(shape, 6)
    again, same, _ = fit_clump(shape, 6)
    assert np.array_equal(again, centres) and np.array_equal(same, radii)
    moved, sizes, turned = fit_clump(shape.moved(turn, [0.02, 0.1, -0.03]), 6)
    # An axis may come out reversed, and with it the points: other minima of nearly the
    # same depth.
    assert turned.surface_rms == pytest.approx(error.surface_rms, rel=0.1)
    assert (moved.mean(axis=0) - [0.02, 0.1, -0.03]) @ turn == pytest.approx(
        centres.mean(axis=0), abs=4e-4
    )
    assert np.sort(sizes) == pytest.approx(np.sort(radii), abs=4e-4)


@pytest.mark.slow
def test_no_ball_is_hidden_and_all_are_one_piece():
    for shape in (*SHAPES.values(), seed_forms.ellipsoid(16e-3, 4e-3, 3e-3)):
        for n in (5, 12):  # the longest is 4.6 times as long as thick
            centres, radii, _ = fit_clump(shape, n)
            apart = np.linalg.norm(centres[:, None] - centres, axis=2) + np.eye(
                len(radii)
            )
            assert connected(centres, radii)
            assert not (apart + radii[:, None] <= radii).any()


def test_spheres_for_a_tolerance():
    shape = SHAPES["ellipsoid"]
    n, errors = spheres_for(shape, 0.04, 8)
    assert len(errors) == n and errors[-1].surface_rms <= 0.04 < errors[-2].surface_rms
    with pytest.raises(ValueError, match=r"tolerance = 0.1 %: 3 balls reach"):
        spheres_for(shape, 0.001, 3)


@pytest.mark.parametrize("name", SHAPES)
def test_seed_has_the_shapes_mass_and_inertia(name):
    shape = SHAPES[name]
    turn = Rotation.from_rotvec([0.3, 0.2, -1.0]).as_matrix()
    seed = Seed.from_shape(shape.moved(turn, [0.1, 0.0, 0.2]), 6, 1250.0)
    assert seed.mass_kg == pytest.approx(1250.0 * shape.volume_m3)
    assert np.sort(seed.inertia_kg_m2) == pytest.approx(
        np.linalg.eigvalsh(shape.solid.inertia(1250.0)), rel=1e-8
    )
    assert seed.dimensions_m == pytest.approx(shape.dimensions_m)
    assert (np.diff(seed.dimensions_m) <= 0).all()
    # The balls' frame: their union lies where the shape does.
    union = Seed.from_spheres(seed.centres_m, seed.radii_m, 1250.0)
    assert union.origin_m == pytest.approx(np.zeros(3), abs=0.01 * shape.mean_radius_m)
    assert seed.volume_m3 == pytest.approx(shape.volume_m3)


def test_seed_is_drawn_as_its_shape():
    shape = SHAPES["creased wheat grain"]
    seed = Seed.from_shape(shape, 6, 1300.0)
    mesh = silhouette_true(seed, 3, "union")
    assert area(mesh.vertices_m, mesh.faces) == pytest.approx(shape.area_m2, rel=1e-6)
    assert np.ptp(mesh.vertices_m, axis=0) == pytest.approx(
        shape.dimensions_m, rel=0.01
    )
    furrow = mesh.vertices_m[np.abs(mesh.vertices_m[:, 0]) < 5e-4]
    assert np.ptp(furrow[np.abs(furrow[:, 1]) < 1e-4, 2]) == pytest.approx(
        3.0e-3 * (1 - 0.2 / 2), rel=0.01
    )


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda s: fit_clump(s, 0), "spheres = 0"),
        (lambda s: fit_clump(s, 101), "spheres = 101"),
        (lambda s: Seed.from_shape(s, 21, 1250.0), "spheres = 21"),
        (lambda s: Seed.from_shape(s, 5, 0.0), "density_kg_m3"),
    ],
)
def test_errors_say_what_is_wrong(make, words):
    with pytest.raises(ValueError, match=words):
        make(SHAPES["ellipsoid"])
