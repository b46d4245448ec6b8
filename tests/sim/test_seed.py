"""Seeds: mass, centre and inertia of the union against closed forms and Monte Carlo;
arrangement; sizes; errors by name."""

import numpy as np
import pytest
import seed_forms
from hypothesis import given, settings
from hypothesis import strategies as st

from benchtwin.sim.seed import Seed
from benchtwin.sim.seed.clump_error import clump_error
from benchtwin.sim.seed.sizes import SOYBEAN, Size, Sizes
from benchtwin.sim.seed.solid import _by_slices, _on_a_line, union_of_balls
from benchtwin.sim.seed.surface import enclosed_volume, is_star_shaped

MEAN = (8.72e-3, 6.84e-3, 5.98e-3)  # the paper's mean soybean [m]


def turn(rng):
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))


def connected_balls(rng, n):
    """A chain: each ball overlaps the one before, none inside another."""
    centres, radii = np.zeros((n, 3)), rng.uniform(0.6, 1.0, n)
    for i in range(1, n):
        step = rng.normal(size=3)
        centres[i] = centres[i - 1] + step / np.linalg.norm(step) * rng.uniform(
            0.45, 0.9
        )
    return centres, radii


def upside_down():
    return Sizes(SOYBEAN.thickness, SOYBEAN.width, SOYBEAN.length, 0.6)


def test_single_sphere_is_the_closed_form():
    r, density = 3e-3, 1250.0
    seed = Seed.from_spheres([[5.0e-3, -2e-3, 1e-3]], [r], density)
    mass = density * 4 / 3 * np.pi * r**3
    assert seed.mass_kg == pytest.approx(mass, rel=1e-12)
    assert seed.inertia_kg_m2 == pytest.approx(0.4 * mass * r**2, rel=1e-12)
    assert seed.centres_m == pytest.approx(np.zeros((1, 3)), abs=1e-18)
    assert seed.bounding_radius_m == pytest.approx(r)


@pytest.mark.parametrize(
    ("r1", "r2", "d"), [(1.0, 1.0, 1.0), (1.0, 0.6, 1.2), (0.5, 1.0, 0.7)]
)
def test_two_spheres_less_their_lens_is_the_closed_form(r1, r2, d):
    # Lens of two balls at distance d: V = π (R+r-d)² (d² + 2dr - 3r² + 2dR + 6rR - 3R²)
    # / 12d.
    lens = (
        np.pi
        * (r1 + r2 - d) ** 2
        * (d**2 + 2 * d * r2 - 3 * r2**2 + 2 * d * r1 + 6 * r1 * r2 - 3 * r1**2)
        / (12 * d)
    )
    body = union_of_balls(
        np.array([[0.0, 0, 0], [0.6 * d, 0, 0.8 * d]]), np.array([r1, r2])
    )
    assert body.volume_m3 == pytest.approx(
        4 / 3 * np.pi * (r1**3 + r2**3) - lens, rel=1e-12
    )
    # The common plane cuts each ball into a cap; moments of ball-less-cap by 1-D
    # quadrature in fine steps.
    plane = (d**2 + r1**2 - r2**2) / (2 * d)
    s = np.linspace(-r1, d + r2, 400_001)
    p = np.where(s < plane, r1**2 - s**2, r2**2 - (s - d) ** 2).clip(0)
    volume, first = np.trapezoid(np.pi * p, s), np.trapezoid(np.pi * p * s, s)
    along = np.trapezoid(np.pi * p * s**2, s) - first**2 / volume
    across = np.trapezoid(np.pi / 4 * p**2, s)
    assert body.centre_m == pytest.approx(
        first / volume * np.array([0.6, 0, 0.8]), abs=1e-9
    )
    assert np.linalg.eigvalsh(body.inertia(1.0)) == pytest.approx(
        sorted([2 * across, along + across, along + across]), rel=1e-8
    )


@pytest.mark.parametrize("n", [3, 8, 20])
def test_union_agrees_with_monte_carlo(n):
    rng = np.random.default_rng(n)
    centres, radii = connected_balls(rng, n)
    body = union_of_balls(centres, radii)
    low, high = (centres - radii[:, None]).min(0), (centres + radii[:, None]).max(0)
    box, points = np.prod(high - low), rng.uniform(low, high, (300_000, 3))
    inside = np.zeros(len(points), dtype=bool)
    for c, r in zip(centres, radii):
        inside |= ((points - c) ** 2).sum(1) < r**2
    share = inside.mean()
    # Tolerances: four standard errors of the counting itself, widened for the moments
    # by their own scatter.
    assert body.volume_m3 == pytest.approx(
        share * box, rel=4 * np.sqrt((1 - share) / share / len(points))
    )
    within = points[inside]
    error = within.std(0) / np.sqrt(len(within))
    assert np.all(np.abs(within.mean(0) - body.centre_m) < 4.5 * error)
    second = np.cov(within.T)
    assert body.second_m5 / body.volume_m3 == pytest.approx(
        second, abs=0.012 * np.trace(second)
    )


@settings(max_examples=15, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10_000), n=st.integers(2, 9))
def test_turning_and_shifting_a_clump_changes_nothing(seed, n):
    rng = np.random.default_rng(seed)
    centres, radii = connected_balls(rng, n)
    body, rotation, shift = (
        union_of_balls(centres, radii),
        turn(rng),
        rng.normal(size=3),
    )
    moved = union_of_balls(centres @ rotation.T + shift, radii)
    assert moved.volume_m3 == pytest.approx(body.volume_m3, rel=1e-5)
    assert moved.centre_m == pytest.approx(rotation @ body.centre_m + shift, abs=1e-5)
    assert moved.second_m5 == pytest.approx(
        rotation @ body.second_m5 @ rotation.T, abs=1e-5 * np.trace(body.second_m5)
    )


def test_slices_agree_with_the_exact_row_of_balls():
    seed = Seed.from_dimensions(*MEAN)
    unit = seed.radii_m.max()
    centres, radii = seed.centres_m / unit, seed.radii_m / unit
    exact, sliced = _on_a_line(centres[:, 0], radii), _by_slices(centres, radii)
    for a, b in zip(exact, sliced):
        assert np.asarray(b) == pytest.approx(np.asarray(a), abs=1e-12)


def test_touching_and_repeated_discs_are_counted_once():
    # A ring in a plane: equal balls, symmetric slices, tangent discs. Volume against
    # balls less neighbouring lenses.
    angle = np.arange(8) * np.pi / 4
    centres, radii = np.c_[np.cos(angle), np.sin(angle), 0 * angle], np.full(8, 0.4)
    d = 2 * np.sin(np.pi / 8)
    lens = np.pi * (4 * 0.4 + d) * (2 * 0.4 - d) ** 2 / 12
    assert union_of_balls(centres, radii).volume_m3 == pytest.approx(
        8 * (4 / 3 * np.pi * 0.4**3 - lens), rel=1e-6
    )


def of_ellipsoid(seed):
    """The clump's error against the ellipsoid of its dimensions, and the ellipsoid's
    mean radius [m]."""
    whole = seed_forms.ellipsoid(*seed.dimensions_m)
    return clump_error(whole, seed.centres_m, seed.radii_m), whole.mean_radius_m


def test_five_balls_of_the_paper():
    seed = Seed.from_dimensions(*MEAN)
    assert np.all(seed.centres_m[:, 1:] == 0.0)
    assert len(set(np.round(seed.radii_m, 9))) == 3  # mirror pairs and the middle one
    assert 2 * seed.bounding_radius_m == pytest.approx(
        MEAN[0], rel=1e-9
    )  # length exact
    assert 2 * seed.radii_m.max() == pytest.approx(np.sqrt(MEAN[1] * MEAN[2]), rel=1e-9)
    error, mean_radius = of_ellipsoid(seed)
    # Measured: 0.126 mm rms, 0.30 mm at most, volume 0.973, inertia 0.944, 1.002, 0.912
    # of the ellipsoid's.
    assert error.surface_rms * mean_radius == pytest.approx(0.1264e-3, abs=0.001e-3)
    assert error.surface_max * mean_radius == pytest.approx(0.3035e-3, abs=0.003e-3)
    assert error.volume == pytest.approx(-0.0273, abs=5e-4)
    assert error.moments == pytest.approx([-0.056, 0.002, -0.088], abs=2e-3)


def test_planar_keeps_width_and_thickness_apart():
    errors = [
        of_ellipsoid(Seed.from_dimensions(*MEAN, n, arrangement="planar"))
        for n in (6, 7, 8)
    ]
    rms = [error.surface_rms * mean_radius for error, mean_radius in errors]
    assert rms == sorted(rms, reverse=True) and rms[0] < 0.065e-3 and rms[-1] < 0.05e-3
    six = errors[0][0]
    assert six.moments == pytest.approx(
        np.zeros(3), abs=0.015
    ) and six.volume == pytest.approx(0.0, abs=0.003)


def test_more_balls_come_closer_and_one_ball_keeps_the_volume():
    rms = [
        of_ellipsoid(Seed.from_dimensions(9e-3, 6e-3, 6e-3, n))[0].surface_rms
        for n in (1, 3, 5, 9, 20)
    ]
    assert rms == sorted(rms, reverse=True) and rms[-1] < 0.005
    one = Seed.from_dimensions(*MEAN, 1)
    assert one.volume_m3 == pytest.approx(np.pi / 6 * np.prod(MEAN), rel=1e-12)


def test_mass_of_the_ellipsoid_by_choice():
    seed = Seed.from_dimensions(*MEAN, mass_of="ellipsoid", density_kg_m3=1200.0)
    mass = 1200.0 * np.pi / 6 * np.prod(MEAN)
    a, b, c = np.array(MEAN) / 2
    assert seed.mass_kg == pytest.approx(mass)
    assert seed.inertia_kg_m2 == pytest.approx(
        mass / 5 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    )


def test_principal_frame_of_a_lopsided_clump():
    rng = np.random.default_rng(4)
    centres, radii = connected_balls(rng, 6)
    seed = Seed.from_spheres(1e-3 * centres, 1e-3 * radii)
    again = union_of_balls(seed.centres_m, seed.radii_m)
    inertia = again.inertia(seed.density_kg_m3)
    assert again.centre_m == pytest.approx(np.zeros(3), abs=1e-8)
    assert inertia == pytest.approx(
        np.diag(seed.inertia_kg_m2), abs=1e-5 * np.trace(inertia)
    )
    assert seed.axes.T @ seed.axes == pytest.approx(
        np.eye(3), abs=1e-12
    ) and np.linalg.det(seed.axes) == pytest.approx(1.0)
    assert (1e-3 * centres - seed.origin_m) @ seed.axes == pytest.approx(
        seed.centres_m, abs=1e-12
    )


def test_meshes_are_closed_smooth_and_of_the_right_size():
    seed = Seed.from_dimensions(*MEAN)
    drawn = seed.mesh()
    assert drawn.faces.shape == (320, 3)
    assert enclosed_volume(drawn.vertices_m, drawn.faces) == pytest.approx(
        np.pi / 6 * np.prod(MEAN), rel=1e-9
    )
    balls = seed.mesh(4, of="union")
    assert enclosed_volume(balls.vertices_m, balls.faces) == pytest.approx(
        seed.volume_m3, rel=5e-3
    )
    for mesh in (
        drawn,
        balls,
        Seed.from_spheres([[0, 0, 0], [1, 0, 0]], [0.6, 0.7]).mesh(1),
    ):
        corners = mesh.vertices_m[mesh.faces]
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert np.all(np.einsum("ij,ij->i", flat, mesh.normals[mesh.faces].mean(1)) > 0)
        assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(1.0)
        edges = np.sort(
            np.concatenate(
                [mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]]
            ),
            axis=1,
        )
        assert np.all(np.unique(edges, axis=0, return_counts=True)[1] == 2)  # closed


def test_a_ring_is_drawn_ball_by_ball():
    angle = np.arange(8) * np.pi / 4
    seed = Seed.from_spheres(
        np.c_[np.cos(angle), np.sin(angle), 0 * angle], np.full(8, 0.42)
    )
    assert not is_star_shaped(seed.centres_m, seed.radii_m)
    mesh = seed.mesh(2)
    gap = (
        np.linalg.norm(mesh.vertices_m[:, None] - seed.centres_m, axis=2) - seed.radii_m
    )
    assert (
        0 < len(mesh.faces) < 8 * 320
        and np.abs(gap.min(axis=1)[np.unique(mesh.faces)]).max() < 0.1
    )


def test_soybean_sizes_have_the_papers_ranges_and_means():
    sizes = 1e3 * SOYBEAN.sample(np.random.default_rng(7), 20_000)
    assert np.all(sizes >= [7.60, 5.30, 4.60]) and np.all(sizes <= [10.0, 7.70, 7.00])
    # 0.02 mm is what keeping the order of the three costs; the counting error of 20,000
    # is 0.004.
    assert sizes.mean(0) == pytest.approx([8.72, 6.84, 5.98], abs=0.025)
    assert sizes.std(0) == pytest.approx(2.4 / 5.015, abs=0.015)
    assert np.all(np.diff(sizes, axis=1) <= 0)
    correlation = np.corrcoef(sizes.T)[np.triu_indices(3, 1)]
    assert correlation == pytest.approx(0.6, abs=0.06)


def test_a_batch_is_reproducible_and_each_seed_its_own():
    one, two = (SOYBEAN.sample_batch(np.random.default_rng(3), 40) for _ in range(2))
    assert [s.mass_kg for s in one] == [s.mass_kg for s in two] and len(
        {s.mass_kg for s in one}
    ) == 40
    planar = SOYBEAN.sample_batch(np.random.default_rng(3), 5, 6, arrangement="planar")
    assert (
        max(
            error.surface_rms * mean_radius
            for error, mean_radius in map(of_ellipsoid, planar)
        )
        < 0.12e-3
    )


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (
            lambda: Seed.from_dimensions(8.72, 6.84, 5.98),
            "length_m = 8.72 m: must be 5e-05 to 3 m",
        ),
        (lambda: Seed.from_dimensions(6e-3, 7e-3, 5e-3), "length_m ≥ width_m"),
        (lambda: Seed.from_dimensions(6e-3, 5e-3, float("nan")), "thickness_m = nan"),
        (lambda: Seed.from_dimensions(6e-3, 5e-3, -1e-3), "thickness_m = -0.001"),
        (lambda: Seed.from_dimensions(6e-3, 6e-3, 6e-3), "spheres=1"),
        (
            lambda: Seed.from_dimensions(40e-3, 4e-3, 4e-3, 5),
            "spheres = 5: too few to touch",
        ),
        (lambda: Seed.from_dimensions(*MEAN, 21), "spheres = 21: must be 1 to 20"),
        (lambda: Seed.from_dimensions(*MEAN, 9, arrangement="planar"), "spheres = 9"),
        (
            lambda: Seed.from_dimensions(*MEAN, arrangement="cubic"),
            "arrangement = 'cubic'",
        ),
        (lambda: Seed.from_dimensions(*MEAN, mass_of="shell"), "mass_of = 'shell'"),
        (lambda: Seed.from_dimensions(*MEAN, density_kg_m3=-1.0), "density_kg_m3 = -1"),
        (lambda: Seed.from_spheres([[0, 0, 0], [1, 0, 0]], [0.4, 0.4]), "touches none"),
        (
            lambda: Seed.from_spheres([[0, 0, 0], [0.1, 0, 0]], [0.4, 0.2]),
            "ball 1 lies wholly inside ball 0",
        ),
        (
            lambda: Seed.from_spheres([[0, 0, 0]], [0.4, 0.2]),
            "one centre and one radius",
        ),
        (lambda: Seed.from_spheres([[0, np.inf, 0]], [0.4]), "centres_m"),
        (lambda: Seed.from_spheres([[0, 0, 0]], [np.nan]), r"radii_m\[0\]"),
        (lambda: Seed.from_dimensions(*MEAN).mesh(9), "level = 9"),
        (lambda: Size(1.0, 3.0, 2.0, 0.1), "least_m < mean_m"),
        (lambda: Size(1.0, 1.5, 2.0, 0.6), "sd_m = 0.6"),
        (
            lambda: Sizes(SOYBEAN.length, SOYBEAN.width, SOYBEAN.thickness, 1.0),
            "correlation = 1",
        ),
        (lambda: SOYBEAN.sample(np.random.default_rng(0), -1), "n = -1"),
        (lambda: upside_down().sample(np.random.default_rng(0), 9), "check the means"),
    ],
)
def test_errors_name_the_parameter_and_its_range(make, says):
    with pytest.raises(
        ValueError, match=says.replace("(", r"\(") if "\\" not in says else says
    ):
        make()
