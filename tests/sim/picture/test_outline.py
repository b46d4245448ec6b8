"""What is rendered against closed forms: area and centroid of an ellipsoid's outline,
through roll, lens and blur; unions."""

import numpy as np
import pytest
from picture_scenes import SOYBEAN, still

from benchtwin.sim.motion import Motion
from benchtwin.sim.picture import Camera, Look, coverage, photo, project
from benchtwin.sim.picture.camera import axes
from benchtwin.sim.picture.pose import matrices

pytestmark = pytest.mark.usefixtures("egl")


def conic(camera: Camera, halves_m, place_m, turn):
    """Centre (2,) [px] and area [px²] of an ellipsoid's outline: its dual quadric,
    projected (Hartley & Zisserman, 8.3)."""
    pose = matrices(np.array([place_m]), np.array([turn]))[0]
    quadric = pose @ np.diag([*np.square(halves_m), -1.0]) @ pose.T
    turned = axes(camera)
    pinhole = np.asarray(camera.target_m) - camera.distance_m * turned[2]
    lens = np.array(
        [
            [camera.focal_px, 0, camera.centre_px[0]],
            [0, camera.focal_px, camera.centre_px[1]],
            [0, 0, 1],
        ]
    )
    dual = lens @ np.c_[turned, -turned @ pinhole]
    dual = dual @ quadric @ dual.T
    dual = dual / -dual[2, 2]
    centre = -dual[:2, 2]
    return centre, np.pi * np.sqrt(
        np.linalg.det(dual[:2, :2] + np.outer(centre, centre))
    )


def moments(mask):
    rows, columns = np.indices(mask.shape)
    total = mask.sum(dtype=float)
    return np.array(
        [(mask * columns).sum() / total, (mask * rows).sum() / total]
    ), total


def some_seed(rng, **camera):
    turn = rng.standard_normal(4)
    place = rng.uniform(-3e-3, 3e-3, 3)
    options = dict(
        roll_deg=rng.uniform(-5, 5),
        azimuth_deg=rng.uniform(0, 360),
        elevation_deg=rng.uniform(0, 20),
    )
    return (
        Camera(
            **{**dict(width_px=192, height_px=160, distance_m=0.5), **options, **camera}
        ),
        place,
        turn / np.linalg.norm(turn),
    )


def test_an_ellipsoid_s_outline_has_the_closed_form_s_area_and_centre():
    """Centroids within 0.02 px each, areas within 0.3 % of a seed 80 px long; measured
    0.003 px and 0.01 %."""
    rng, off = np.random.default_rng(0), []
    for _ in range(12):
        camera, place, turn = some_seed(rng, mm_per_px=0.11)
        centre, area = moments(coverage(still(place, turn), camera, of="ellipsoid"))
        true_centre, true_area = conic(camera, SOYBEAN.dimensions_m / 2, place, turn)
        off.append([*(centre - true_centre), area / true_area - 1])
    off = np.array(off)
    assert np.abs(off[:, :2]).max() < 0.02
    assert np.abs(off[:, 2]).max() < 0.003
    assert np.abs(off.mean(axis=0)) == pytest.approx([0, 0, 0], abs=0.003)


@pytest.mark.parametrize("k", [-0.08, 0.08])
def test_the_lens_bends_outlines_as_project_says(k):
    """A seed in the picture's corner, where the lens moves it by tens of pixels: its
    centroid is that of the bent outline."""
    rng = np.random.default_rng(1)
    camera, _, turn = some_seed(
        rng,
        mm_per_px=0.2,
        width_px=480,
        height_px=320,
        distortion=k,
        roll_deg=2.0,
        azimuth_deg=0.0,
    )
    place = np.array([0.034, 0.0, -0.019])
    flat = Camera(**{**vars(camera), "distortion": 0.0})
    centre, area = moments(coverage(still(place, turn), camera, of="ellipsoid"))
    straight, true_area = conic(flat, SOYBEAN.dimensions_m / 2, place, turn)
    # The lens formula integrated over the straight outline, an ellipse of the second
    # moments that its conic has.
    fine = coverage(still(place, turn), flat, of="ellipsoid", fine=4)
    rows, columns = np.nonzero(fine)
    weight, offset = (
        fine[rows, columns].astype(float),
        np.c_[columns, rows] - flat.centre_px,
    )
    ratio = (offset**2).sum(axis=1) / camera.corner_px**2
    growth = (1 + k * ratio) * (1 + 3 * k * ratio)  # area of the bent pixel
    bent = camera.centre_px + offset * (1 + k * ratio)[:, None]
    assert np.linalg.norm(centre - straight) > 2.0  # it did move
    assert centre == pytest.approx(
        np.average(bent, axis=0, weights=weight * growth), abs=0.02
    )
    assert area == pytest.approx(
        true_area * np.average(growth, weights=weight), rel=0.003
    )


def test_a_point_is_rendered_where_project_says():
    """A seed so small that it is a point, through lens, roll and perspective."""
    camera = Camera(
        400,
        300,
        mm_per_px=1.0,
        distance_m=1.0,
        distortion=0.05,
        roll_deg=-3.0,
        azimuth_deg=20.0,
        elevation_deg=8.0,
    )
    for place in ((0.12, 0.1, 0.08), (-0.13, 0.2, -0.06)):
        centre, _ = moments(coverage(still(place, [1, 0, 0, 0]), camera, fine=4))
        assert centre == pytest.approx(project(camera, [place])[0], abs=0.03)


def test_seeds_are_the_union_of_their_balls():
    """The silhouette of five balls in a row against their exact union, counted on a
    grid of 8 × 8 points a pixel."""
    camera = Camera(
        192, 160, mm_per_px=0.06, distance_m=50.0
    )  # so far that every ball's outline is its circle
    place, turn = np.zeros(3), np.array([np.cos(0.3), 0.0, np.sin(0.3), 0.0])
    mask = coverage(still(place, turn), camera, of="union")
    centres = project(
        camera, SOYBEAN.centres_m @ matrices(place[None], turn[None])[0, :3, :3].T
    )
    step = (np.arange(8) + 0.5) / 8 - 0.5
    columns, rows = (
        (np.arange(192)[:, None] + step).ravel(),
        (np.arange(160)[:, None] + step).ravel(),
    )
    inside = np.zeros((rows.size, columns.size), bool)
    for centre, radius in zip(centres, SOYBEAN.radii_m * 1e3 / camera.mm_per_px):
        inside |= np.hypot(columns - centre[0], rows[:, None] - centre[1]) < radius
    truth = inside.reshape(160, 8, 192, 8).mean(axis=(1, 3))
    assert mask.sum() == pytest.approx(truth.sum(), rel=0.003)
    assert moments(mask)[0] == pytest.approx(moments(truth)[0], abs=0.02)
    ellipsoid = coverage(still(place, turn), camera, of="ellipsoid")
    assert abs(ellipsoid.sum() / truth.sum() - 1) > 0.005  # the other choice would show


def test_an_edge_is_where_the_light_is_half():
    """Averaging is of light: a wall's edge at a known column, half way between its
    level and the background's, to 0.02 px."""
    from picture_scenes import slab

    from benchtwin.sim.motion import Part

    for shift in (0.0, 0.13, 0.37, 0.61):
        edge = (100 + shift - 127.5) * 0.2e-3
        wall = Part("wall", slab((-0.1, 0.0, -0.1), (edge, 0.001, 0.1)))
        camera = Camera(256, 64, mm_per_px=0.2, distance_m=1.0)
        motion = still([0.02, 0.0, 0.0], [1, 0, 0, 0], parts=(wall,))
        row = photo(motion, camera, Look(grey=True, blur_px=0.8))[4].astype(float)
        inside, outside = row[80], row[130]
        place = (row[80:130] - outside).sum() / (inside - outside) + 79.5
        assert place == pytest.approx(
            100 + shift, abs=0.02 + 0.5 / 8
        )  # 4 multisamples in 2 × 2: edges snap to 1/8 px


def test_blur_is_as_long_as_the_way_gone_in_the_exposure():
    """40 px of motion in the exposure: the blurred seed's second moment along it grows
    by 40²/12, its centroid stays."""
    camera = dict(width_px=256, height_px=128, mm_per_px=0.25)
    speed = np.array([[[10.0, 0.0, 0.0]]])
    rest = still(np.zeros(3), [1, 0, 0, 0])
    moves = Motion(
        rest.t_s,
        rest.shapes,
        rest.shape_of,
        rest.positions_m,
        rest.orientations,
        speed,
        rest.spins_rad_s,
    )
    look = Look(
        grey=True, background=(0, 0, 0), blur_px=0.0, ambient=1.0
    )  # evenly bright: its centre is the outline's
    sharp = photo(moves, Camera(**camera), look)
    blurred = photo(moves, Camera(**camera, exposure_s=1e-3, subframes=80), look)
    spread = []
    for image in (sharp, blurred):
        centre, total = moments(image)
        spread.append((image * (np.arange(256) - centre[0]) ** 2).sum() / total)
        assert centre[0] == pytest.approx(127.5, abs=0.02)
    assert spread[1] - spread[0] == pytest.approx(40**2 / 12, rel=0.02)


def test_a_turning_seed_is_blurred_too():
    rest = still(np.zeros(3), [1, 0, 0, 0])
    look, camera = (
        Look(grey=True),
        Camera(128, 128, mm_per_px=0.1, exposure_s=1e-3, subframes=16),
    )
    images = []
    for rate in (0.0, 1000.0):  # 1 rad in the exposure
        spin = np.array([[[0.0, rate, 0.0]]])
        images.append(
            photo(
                Motion(*_parts(rest), rest.velocities_m_s, spin), camera, look
            ).astype(int)
        )
    assert np.abs(images[0] - images[1]).max() > 30


def _parts(motion):
    return (
        motion.t_s,
        motion.shapes,
        motion.shape_of,
        motion.positions_m,
        motion.orientations,
    )
