"""What benches leave out, how people read, plates that climb in stairs, cameras near
and far."""

from dataclasses import replace

import numpy as np
import pytest

from benchtwin.prove.cases import drop, drop_snr, slide
from benchtwin.prove.cases.bench import Request
from benchtwin.prove.cases.camera import Camera, project
from benchtwin.prove.cases.record import field_of
from benchtwin.prove.cases.stated import (
    DISTANCE_M,
    GRIDS_DEG,
    LIFTS,
    NEEDED,
    SHARES,
    draw_absent_keys,
    draw_distance_mm,
    mean_sd_deg,
    on_grid,
)
from benchtwin.prove.plan import Spec
from benchtwin.prove.rigs import RIGS

from .making import make

RNG = np.random.default_rng


def test_every_key_is_left_out_sometimes_unless_an_effect_needs_it():
    rng = RNG(1)
    drawn = [draw_absent_keys((), rng) for _ in range(600)]
    for key, share in SHARES.items():
        share_absent = sum(key in absent for absent in drawn) / len(drawn)
        assert abs(share_absent - share) < 0.1 + 0.1 * (key == "camera.plumb_sd_deg"), (
            key
        )  # it goes with plumb
    for name, keys in NEEDED.items():
        assert any(name in rig.effects for rig in RIGS.values())
        assert not any(set(keys) & draw_absent_keys((name,), rng) for _ in range(50))
    assert not any(
        {"track.tilt_deg", "slide.tilt_rate_deg_s"} <= absent for absent in drawn
    )


def test_a_bench_states_all_keys_but_its_absent_ones():
    stated = set()
    for index in range(1, 13):
        bench, key = make(Spec(index, "drop", "clean", (), (), None, False), 5)
        tomls = [bench.toml, *(made.toml for made in bench.recordings)]
        found = {
            f"{section}.{name}"
            for toml in tomls
            for section, keys in toml.items()
            if isinstance(keys, dict)
            for name in keys
        }
        assert not found & set(key.absent)
        assert ("sd_mm" in bench.recordings[0].track) == (
            "track.sd_mm" not in key.absent
        )
        assert ("camera.distance_mm" in found) == (
            "camera.distance_mm" not in key.absent
        )
        stated |= found
    assert {
        "camera.distance_mm",
        "camera.plumb_deg",
        "seed.mass_g",
        "drop.height_mm",
    } <= stated


def test_a_key_that_differs_between_recordings_is_always_stated():
    for index in range(1, 5):
        bench, _ = make(
            Spec(index, "roll", "single", ("slope",), (10.0,), True, False), 5
        )
        assert {made.toml["roll"]["direction"] for made in bench.recordings} == {
            "+x",
            "-x",
        }


@pytest.mark.parametrize(
    ("key", "effect", "size"),
    [
        ("camera.plumb_deg", "camera-roll", 0.5),
        ("camera.mm_per_px_sd", "scale-error", 0.01),
        ("seed.sizes", "updraught", 1.0),
    ],
)
def test_an_absent_key_makes_its_effect_less_visible(key, effect, size):
    scene = drop.draw(Request((effect,)), RNG(7))
    bare = replace(scene, request=replace(scene.request, absent=frozenset({key})))
    key = field_of(effect)
    known, unknown = (
        drop_snr.visibility(s.changed(**{key: size}), key).snr for s in (scene, bare)
    )
    assert unknown < 0.99 * known


@pytest.mark.parametrize("grid", GRIDS_DEG)
def test_readings_lie_on_their_grid_by_their_way(grid):
    angle = RNG(2).uniform(15, 30, 2000)
    read = {lift: on_grid(angle, grid, lift) for lift in LIFTS}
    for values in read.values():
        np.testing.assert_allclose(values / grid, np.round(values / grid), atol=1e-3)
    bias = {lift: np.mean(values - angle) / grid for lift, values in read.items()}
    assert bias == pytest.approx({0.5: 0.0, 0.0: -0.5, 1.0: 0.5}, abs=0.03)


@pytest.mark.parametrize(
    ("grid", "scatter"), [(0.1, 0.15), (0.5, 0.15), (1.0, 0.15), (0.5, 0.02)]
)
def test_the_mean_of_readings_is_known_as_told(grid, scatter):
    rng = RNG(3)
    true = rng.uniform(20, 25, 4000)
    angles = true[:, None] + scatter * rng.standard_normal((4000, 12))
    off = on_grid(angles, grid).mean(axis=1) - true
    assert np.std(off) == pytest.approx(mean_sd_deg(grid, scatter, 12), rel=0.15)


def test_people_read_in_all_these_ways():
    read = Request(("reading-delay",))
    drawn = [slide.draw(read, RNG(k)).worlds[0] for k in range(300)]
    assert {world.reading_grid_deg for world in drawn} == set(GRIDS_DEG)
    assert {world.reading_lift for world in drawn} == set(LIFTS)


def filmed(seed: int):
    scene = slide.draw(Request(("stepped-tilt",)), RNG(seed))
    return scene.worlds[0]._replace(column_grid_deg=0.0, tilt_off_deg=0.0)


def test_a_plate_that_climbs_in_stairs_moves_the_block_in_stairs():
    """It lets go while a stair is climbed, and no column on a grid makes it do so."""
    stair = 0.8
    plain = filmed(4)._replace(rate_deg_s=1.0)
    world, t = plain._replace(stepped_tilt=stair), slide.times(plain)
    x, n = slide.simulate(world, t)
    t, x = t[:n], x[:n]
    part = (world.start_deg + t[np.argmax(x > 0)]) / stair % 1
    assert part > 1 - slide.JOG - 0.05 or part < 0.05
    coarse = plain._replace(column_grid_deg=0.5)
    assert np.array_equal(slide.simulate(coarse, t)[0], slide.simulate(plain, t)[0])
    tilt = slide.recorded_tilt(world, t, RNG(0))
    standing = np.abs(tilt / stair - np.round(tilt / stair)) * stair < 0.03
    assert np.mean(standing) == pytest.approx(1 - slide.JOG, abs=0.1)
    steady = slide.recorded_tilt(plain, t, RNG(0))
    assert np.mean(np.abs(steady / stair % 1 - 0.5) > 0.46) < 0.15


def test_a_recorded_tilt_on_a_grid_is_a_smooth_plate():
    world = filmed(4)._replace(column_grid_deg=0.5)
    t = slide.times(world)
    column = slide.recorded_tilt(world, t, RNG(0))
    np.testing.assert_allclose(column / 0.5, np.round(column / 0.5), atol=1e-6)
    assert np.abs(column - world.start_deg - world.rate_deg_s * t).max() < 0.3


def test_camera_distances_span_their_range():
    rng = RNG(5)
    distance = np.array([draw_distance_mm(rng) for _ in range(500)]) / 1e3
    assert DISTANCE_M[0] < distance.min() < 0.4 and 15 < distance.max() < DISTANCE_M[1]
    assert np.median(distance) == pytest.approx(np.sqrt(0.3 * 20), rel=0.25)


def at_distance(world, distance_mm: float):
    return world._replace(camera=world.camera._replace(distance_mm=distance_mm))


def test_perspective_acts_whether_or_not_the_distance_is_stated():
    near = Camera((0.0, 0.0), 100.0, distance_mm=500.0)
    x, _ = project(
        near, np.array([40.0]), np.array([0.0]), np.zeros(1), np.array([-20.0])
    )
    assert x[0] == pytest.approx(40 / (1 - 20 / 500))
    scene = drop.draw(Request(), RNG(9))
    moved = []
    for world in scene.worlds:
        near, far = (
            drop.record(scene, at_distance(world, mm), "drop-01").track
            for mm in (400.0, np.inf)
        )
        moved.append(np.abs(near.x_mm - far.x_mm).max())
    assert np.median(moved) > 3 * scene.noise.sd


def test_a_near_camera_hides_a_force_that_a_far_one_shows():
    """A seed that may come nearer by itself is a nuisance, the more the nearer the
    camera."""
    scene = drop.draw(Request(("updraught",)), RNG(11))
    snr = []
    for distance in (400.0, 2e4):
        worlds = tuple(at_distance(world, distance) for world in scene.worlds)
        moved = replace(scene, worlds=worlds).changed(updraught=3.0)
        snr.append(drop_snr.visibility(moved, "updraught").snr)
    assert snr[0] < 0.95 * snr[1]
