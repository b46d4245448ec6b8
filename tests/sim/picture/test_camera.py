"""The camera's formula, without rendering: scale, view, roll as plumb_deg, distortion
and its inverse, and bad input."""

import math

import numpy as np
import pytest

from benchtwin.sim.picture.camera import Camera, axes, distort, project, undistort


def test_the_target_is_at_the_centre_and_the_scale_holds_in_its_plane():
    camera = Camera(1280, 800, mm_per_px=0.25, target_m=(0.1, 0.2, 0.3))
    seen = project(
        camera, [(0.1, 0.2, 0.3), (0.11, 0.2, 0.3), (0.1, 0.2, 0.31), (0.11, 2.2, 0.3)]
    )
    assert seen[0] == pytest.approx([639.5, 399.5])
    assert seen[1] == pytest.approx([679.5, 399.5])  # 10 mm to the right: 40 px
    assert seen[2] == pytest.approx([639.5, 359.5])  # z is up, rows go down
    assert seen[3] == pytest.approx([659.5, 399.5])  # twice as far: half as large


def test_azimuth_and_elevation():
    from_the_right = Camera(
        azimuth_deg=90
    )  # stands at +x, looks along -x: +y is to the right
    assert axes(from_the_right) == pytest.approx(
        np.array([[0, 1, 0], [0, 0, -1], [-1, 0, 0]]), abs=1e-12
    )
    above = Camera(elevation_deg=30)
    assert axes(above)[2] == pytest.approx([0, math.cos(math.pi / 6), -0.5])
    assert (
        project(above, [(0, 0.1, 0)])[0, 1] < above.centre_px[1]
    )  # what is behind the target is seen higher


@pytest.mark.parametrize("plumb_deg", [-7.0, 0.0, 3.0])
def test_roll_is_a_recording_s_plumb_deg(plumb_deg):
    """recordings.md: direction of gravity in the picture, clockwise from straight down,
    (-sin, cos) in columns and rows."""
    camera = Camera(roll_deg=plumb_deg, elevation_deg=10)
    fall = np.diff(project(camera, [(0, 0, 0.001), (0, 0, -0.001)]), axis=0)[0]
    turn = math.radians(plumb_deg)
    assert fall / np.linalg.norm(fall) == pytest.approx(
        [-math.sin(turn), math.cos(turn)], abs=1e-6
    )


def test_the_measuring_code_reads_roll_the_same_way():
    from benchtwin.vision.motion.track import make_track

    camera = Camera(roll_deg=4.0)
    places = np.array([(0.01, 0, 0.05), (0.01, 0, 0.02), (0.03, 0, 0.02)])
    seen = project(camera, places) * camera.mm_per_px
    up, across = make_track(np.arange(3.0), seen[:, 0], -seen[:, 1]).upright(4.0)
    assert np.diff(up) == pytest.approx([-30.0, 0.0], abs=1e-9)
    assert np.diff(across) == pytest.approx([0.0, 20.0], abs=1e-9)


@pytest.mark.parametrize("k", [-0.1, -0.02, 0.05, 0.1])
def test_distortion_moves_the_corner_by_k_and_is_undone(k):
    camera = Camera(640, 480, distortion=k)
    corner = np.array([[320.0, 240.0]])
    assert distort(camera, corner) == pytest.approx(corner * (1 + k))
    rng = np.random.default_rng(0)
    seen = rng.uniform(-1, 1, (500, 2)) * [320, 240]
    assert distort(camera, undistort(camera, seen)) == pytest.approx(seen, abs=1e-4)


def test_what_is_far_outside_is_not_folded_back_in():
    camera = Camera(640, 480, distortion=-0.1)
    far = np.outer(np.linspace(1.0, 20.0, 50), [320.0, 240.0])
    assert (np.diff(np.linalg.norm(distort(camera, far), axis=1)) > 0).all()


def test_behind_the_pinhole_is_nowhere():
    assert np.isnan(project(Camera(distance_m=1.0), [(0, -1.5, 0)])).all()


@pytest.mark.parametrize(
    "wrong, said",
    [
        (dict(mm_per_px=0.0), r"mm_per_px = 0: must be 0.0001 to 100 mm/px"),
        (dict(mm_per_px=math.nan), "mm_per_px = nan"),
        (dict(width_px=4), "width_px = 4: must be 8 to 16384 px"),
        (dict(width_px=640.5), "width_px = 640.5: must be a whole number"),
        (dict(distance_m=-1.0), "distance_m = -1"),
        (dict(elevation_deg=90.0), "elevation_deg = 90"),
        (dict(distortion=0.3), "distortion = 0.3"),
        (dict(exposure_s=-1e-3), "exposure_s = -0.001"),
        (dict(subframes=0), "subframes = 0"),
        (dict(target_m=(0, 0)), "target_m"),
        (dict(target_m=(0, 0, math.inf)), "target_m"),
    ],
)
def test_wrong_cameras_are_named(wrong, said):
    with pytest.raises(ValueError, match=said):
        Camera(**wrong)
