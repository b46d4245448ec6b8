"""Shapes: volume, centre and inertia of the meshes against closed forms and quadrature
that share nothing with the meshing."""

import numpy as np
import pytest
import seed_forms
from scipy.integrate import quad, tplquad
from scipy.spatial.transform import Rotation
from scipy.special import gamma

from benchtwin.sim.seed.shape import Shape

SOY = (8.72e-3, 6.84e-3, 5.98e-3)


def box(a, b, c):
    corners = np.array(
        [[x, y, z] for x in (0, a) for y in (0, b) for z in (0, c)], float
    )
    faces = [
        (0, 1, 3),
        (0, 3, 2),
        (4, 6, 7),
        (4, 7, 5),
        (0, 4, 5),
        (0, 5, 1),
        (2, 3, 7),
        (2, 7, 6),
        (0, 2, 6),
        (0, 6, 4),
    ]
    return Shape(corners, [*faces, (1, 5, 7), (1, 7, 3)])


def moments(shape, density=1.0):
    return np.diag(shape.principal()[0].solid.inertia(density))


def test_box_is_exact():
    a, b, c = 3.0, 2.0, 1.0
    solid = box(a, b, c).solid
    assert solid.volume_m3 == pytest.approx(6.0, rel=1e-14)
    assert solid.centre_m == pytest.approx([a / 2, b / 2, c / 2], rel=1e-14)
    assert np.diag(solid.inertia(2.0)) == pytest.approx(
        [b * b + c * c, a * a + c * c, a * a + b * b], rel=1e-13
    )  # m = 12


def test_faces_that_look_inwards_are_turned():
    right = box(1, 2, 3)
    turned = Shape(right.vertices_m, right.faces[:, ::-1])
    assert turned.volume_m3 == pytest.approx(6.0)


def test_ellipsoid():
    a, b, c = np.array(SOY) / 2
    shape = seed_forms.ellipsoid(*SOY)
    volume = 4 / 3 * np.pi * a * b * c
    assert shape.volume_m3 == pytest.approx(volume, rel=1e-12)
    # 5120 flat faces of the same volume: the second moment is theirs, 1e-4 off the
    # curved body's.
    assert moments(shape) == pytest.approx(
        volume / 5 * np.array([b * b + c * c, a * a + c * c, a * a + b * b]), rel=2e-4
    )
    assert shape.dimensions_m == pytest.approx(
        SOY, rel=1e-3
    )  # enlarged to the volume: 0.07 %


def test_outline_of_an_ellipse_is_the_ellipsoid_wherever_it_lies():
    turn = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    outline = np.c_[SOY[0] / 2 * np.cos(turn), SOY[1] / 2 * np.sin(turn)] + [3.0, -2.0]
    for points in (
        outline,
        outline[::-1],
        np.vstack([outline, outline[:1]]),
    ):  # either way round, open or closed
        shape = Shape.from_outline(points, SOY[2])
        # 200 points: the polygon's area is (2π/200)²/6 = 1.6e-4 short of the ellipse's.
        assert shape.volume_m3 == pytest.approx(np.pi / 6 * np.prod(SOY), rel=3e-4)
        assert moments(shape) == pytest.approx(
            moments(seed_forms.ellipsoid(*SOY)), rel=1e-3
        )


def test_outline_of_any_form_has_two_thirds_of_area_times_thickness():
    turn = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    r = 3e-3 * (1 + 0.2 * np.cos(turn) + 0.1 * np.sin(3 * turn))
    x, y = r * np.cos(turn), r * np.sin(turn)
    area = 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    assert Shape.from_outline(np.c_[x, y], 2e-3).volume_m3 == pytest.approx(
        2 / 3 * area * 2e-3, rel=1e-9
    )


@pytest.mark.parametrize("flat_at", [0.2, 0.75])
def test_flattened_ellipsoid_is_a_stretched_ball_less_its_cap(flat_at):
    shape = seed_forms.flattened_ellipsoid(12e-3, 8e-3, 7e-3, flat_at)
    # Slices of the unit ball: π (1 - z²) from -f up; means of z and z² by the same
    # slices.
    area = [
        quad(lambda z, k=k: np.pi * (1 - z * z) * z**k, -flat_at, 1)[0]
        for k in range(3)
    ]
    scale = 6e-3 * 4e-3 * 3.5e-3
    assert shape.volume_m3 == pytest.approx(area[0] * scale, rel=1e-12)
    assert shape.solid.centre_m == pytest.approx(
        [0, 0, area[1] / area[0] * 3.5e-3], abs=1e-3 * 3.5e-3
    )
    across = (
        quad(lambda z: np.pi / 4 * (1 - z * z) ** 2, -flat_at, 1)[0] * scale
    )  # ∫x² of the unit body
    about = (area[2] - area[1] ** 2 / area[0]) * scale
    expected = [
        across * 4e-3**2 + about * 3.5e-3**2,
        across * 6e-3**2 + about * 3.5e-3**2,
        across * (6e-3**2 + 4e-3**2),
    ]
    assert moments(shape) == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize(
    ("across", "along"), [(1.0, 1.0), (0.5, 1.0), (0.7, 0.4), (1.4, 1.2)]
)
def test_superquadric_has_the_volume_and_moments_of_the_gamma_function(across, along):
    a, b, c = 4e-3, 3e-3, 2e-3
    shape = seed_forms.superquadric(2 * a, 2 * b, 2 * c, across=across, along=along)

    def b_(p, q):
        return gamma(p) * gamma(q) / gamma(p + q)

    volume = (
        2
        * a
        * b
        * c
        * across
        * along
        * b_(across / 2 + 1, across)
        * b_(along / 2, along / 2)
    )
    assert shape.volume_m3 == pytest.approx(volume, rel=1e-12)
    # Another route to the same volume, which knows no beta function: 8 × the octant.
    octant = (
        quad(lambda x: (1 - x ** (2 / along)) ** (along / 2), 0, 1)[0]
        * quad(lambda z: (1 - z ** (2 / across)) ** across, 0, 1)[0]
    )
    assert volume == pytest.approx(8 * a * b * c * octant, rel=1e-6)
    # Second moments (Jaklič et al. 2000, Eq. 2.67).
    xx = (
        0.5
        * a**3
        * b
        * c
        * across
        * along
        * b_(1.5 * along, 0.5 * along)
        * b_(0.5 * across, 2 * across + 1)
    )
    yy = xx / a**2 * b**2
    zz = (
        a
        * b
        * c**3
        * across
        * along
        * b_(along / 2, along / 2 + 1)
        * b_(1.5 * across, across + 1)
        * 2
    )
    assert np.diag(shape.solid.second_m5) == pytest.approx(
        [xx, yy, zz], rel=6e-3
    )  # facets at blunt corners


def test_taper_leaves_the_volume_and_moves_the_centre():
    plain = seed_forms.superquadric(10e-3, 8e-3, 5e-3, across=0.8, along=0.8)
    wedge = seed_forms.superquadric(10e-3, 8e-3, 5e-3, across=0.8, along=0.8, taper=0.4)
    assert wedge.volume_m3 == pytest.approx(plain.volume_m3, rel=2e-3)
    # ∫ x (1 + t x/a) dV / V = t <x²>/a
    mean_square = plain.solid.second_m5[0, 0] / plain.volume_m3
    assert wedge.solid.centre_m[0] == pytest.approx(0.4 * mean_square / 5e-3, rel=5e-3)


@pytest.mark.parametrize("half_width_deg", [8.0, 25.0])
def test_creased_ellipsoid_has_the_volume_that_quadrature_finds(half_width_deg):
    w, d = np.radians(half_width_deg), 0.3
    shape = seed_forms.creased_ellipsoid(
        6.5e-3, 3.3e-3, 3.0e-3, depth=d, half_width_deg=half_width_deg
    )

    def cone(r, theta, psi):
        return r * r * np.sin(theta)

    volume = (
        tplquad(
            cone,
            0,
            np.pi,
            0,
            np.pi,
            0,
            lambda psi, t: 1 - d * np.sin(t) ** 2 * np.exp(-(psi**2) / (2 * w * w)),
        )[0]
        * 2
    )
    assert shape.volume_m3 == pytest.approx(
        volume * 3.25e-3 * 1.65e-3 * 1.5e-3, rel=1e-6
    )


def test_nothing_depends_on_where_and_how_it_lies():
    shape = seed_forms.superquadric(
        11e-3, 8e-3, 4.8e-3, across=0.8, along=0.8, taper=0.35
    )
    turn = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
    moved = shape.moved(turn, [0.5, -0.2, 1.0])
    assert moved.volume_m3 == pytest.approx(shape.volume_m3, rel=1e-9)
    assert moments(moved) == pytest.approx(moments(shape), rel=1e-8)
    assert moved.dimensions_m == pytest.approx(shape.dimensions_m, rel=1e-7)
    own, axes, origin = moved.principal()
    assert (moved.vertices_m - origin) @ axes == pytest.approx(
        own.vertices_m, abs=1e-12
    )
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert own.solid.centre_m == pytest.approx(np.zeros(3), abs=1e-12)


def test_scaled():
    shape = seed_forms.ellipsoid(*SOY)
    assert shape.scaled(2.0).volume_m3 == pytest.approx(8 * shape.volume_m3)
    assert shape.scaled([2, 1, 1]).dimensions_m == pytest.approx(
        shape.dimensions_m * [2, 1, 1]
    )


def test_points_stand_for_equal_shares_of_the_surface():
    shape = box(3.0, 2.0, 1.0)
    points, normals = shape.points(2200)
    top = np.isclose(points[:, 2], 1.0)
    assert top.sum() == pytest.approx(2200 * 6 / 22, abs=2)
    assert normals[top] == pytest.approx(np.tile([0, 0, 1.0], (top.sum(), 1)))
    assert points[top].mean(axis=0) == pytest.approx([1.5, 1.0, 1.0], abs=0.02)


def test_what_is_drawn_has_few_faces_and_the_volume():
    mesh = seed_forms.creased_ellipsoid(
        6.5e-3, 3.3e-3, 3.0e-3, depth=0.3, half_width_deg=12.0
    ).mesh(1280)
    assert 1000 < len(mesh.faces) <= 1290
    assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(1.0)
    outward = np.einsum("ij,ij->i", mesh.normals, mesh.vertices_m)
    assert (outward > 0).mean() > 0.99


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Shape(np.eye(3), [(0, 1, 2)]), "not closed"),
        (lambda: Shape(np.eye(3), [(0, 1, 3)]), "name three"),
        (lambda: seed_forms.ellipsoid(1.0, -1.0, 1.0), "must be above 0"),
        (lambda: seed_forms.flattened_ellipsoid(1.0, 1.0, 1.0, 1.0), "flat_at"),
        (
            lambda: seed_forms.superquadric(1, 1, 1, across=0.01, along=1),
            "across = 0.01",
        ),
        (
            lambda: seed_forms.superquadric(1, 1, 1, across=1, along=1, taper=1.0),
            "taper",
        ),
        (
            lambda: seed_forms.creased_ellipsoid(1, 1, 1, depth=0.9, half_width_deg=10),
            "depth",
        ),
        (lambda: Shape.from_outline(np.zeros((3, 2)), 1.0), "8 or more points"),
        (lambda: Shape.from_outline(np.zeros((9, 2)), 1.0), "no area"),
        (
            lambda: Shape.from_outline(
                [
                    (0, 0),
                    (4, 0),
                    (4, 4),
                    (0, 4),
                    (0, 3.9),
                    (3.9, 3.9),
                    (3.9, 0.1),
                    (0, 0.1),
                ],
                1.0,
            ),
            "crosses",
        ),
        (lambda: box(1, 1, 1).scaled(0.0), "positive"),
    ],
)
def test_errors_say_what_is_wrong(make, words):
    with pytest.raises(ValueError, match=words):
        make()
