"""Piles and lifted cylinders, small ones: nothing is lost, the outline is the balls'
own, bad rigs are refused."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scenes import NO_AIR

from benchtwin.sim.engine.observe import Settled
from benchtwin.sim.material import SOYBEAN_Q235, SOYBEAN_SOYBEAN
from benchtwin.sim.motion import Motion
from benchtwin.sim.rigs import cylinder, pile
from benchtwin.sim.rigs.bench import Bench, no_watch
from benchtwin.sim.rigs.cylinder import LiftedCylinder
from benchtwin.sim.rigs.engine import POURED, QUIET, Ours
from benchtwin.sim.rigs.heap import fill
from benchtwin.sim.rigs.pile import Pile
from benchtwin.sim.rigs.profile import centroid_angle, outline, slope_angle
from benchtwin.sim.rotation import turned
from benchtwin.sim.seed import Seed

# soft: quick; nothing here asks for an angle to a degree
BENCH = Bench(shear_modulus_pa=1e6, air_density_kg_m3=0.0, laws=NO_AIR)
SMALL = Pile(
    box_m=(0.06, 0.02, 0.2),
    gate_m=(0.02, 0.2),
    plate_m=(0.15, 0.02),
    fill_height_m=0.03,
    gate_speed_m_s=0.2,
    slab=True,
)
# One thread: tests run beside each other, and threads that wait for each other take
# their cores.
ONE = Ours(1)
run_cylinder = partial(cylinder.run_cylinder, engine=ONE)
run_pile = partial(pile.run_pile, engine=ONE)


def fill_pile(rig, bench, rng, engine=ONE):
    return fill(pile.vessel(rig, bench), bench, rng, engine, no_watch)


@pytest.fixture(scope="module")
def filled():
    return fill_pile(SMALL, BENCH, np.random.default_rng(1))


@pytest.fixture(scope="module")
def heap(filled):
    return run_pile(SMALL, BENCH, np.random.default_rng(1), filled=filled, fps=50.0)


def test_the_filling_is_struck_off_at_its_height_and_dense(filled):
    top = max(
        x[2]
        + float(
            np.max(
                (turned(q, filled.shapes[k].centres_m))[:, 2] + filled.shapes[k].radii_m
            )
        )
        for x, q, k in zip(filled.positions_m, filled.orientations, filled.shape_of)
    )
    assert 0.024 < top <= 0.030
    solid = sum(filled.shapes[k].volume_m3 for k in filled.shape_of)
    assert (
        0.38 < solid / (0.06 * 0.02 * 0.03) < 0.65
    )  # 0.55 to 0.62 inside; four layers lose half of one to the striking-off


def test_the_seeds_flow_out_and_lie_still(heap):
    assert heap.truth["lies_still"] == 1.0
    x = heap.positions_m[:, :, 0]
    assert np.nanmax(x[0]) < 0.06 < 0.07 < np.nanmax(x[-1])
    assert np.nanmin(heap.positions_m[-1, :, 2]) > 0.0
    moved = np.linalg.norm(heap.positions_m[-1] - heap.positions_m[-2], axis=1)
    assert np.nanmax(moved) < 1e-3


def test_the_angle_lies_between_flat_and_friction(heap):
    assert 8.0 < heap.truth["repose_angle_deg"] < 45.0


def test_seeds_over_the_edge_are_gone_and_counted():
    short = replace(SMALL, plate_m=(0.07, 0.02))
    motion = run_pile(short, BENCH, np.random.default_rng(1))
    lost = int(np.isnan(motion.positions_m[-1, :, 0]).sum())
    assert lost > 0
    assert motion.truth["retained_seeds"] == motion.seeds - lost


def test_a_given_filling_is_used_as_it_is_and_runs_are_repeatable(filled):
    # as good as all that leaves the box has left it; what is slippery lies still after
    # 6 s
    flowing = replace(SMALL, photo_s=0.4)
    one, two = (
        run_pile(flowing, BENCH, np.random.default_rng(k), filled=filled)
        for k in (1, 2)
    )
    assert np.array_equal(one.positions_m[-1], two.positions_m[-1], equal_nan=True)
    slippery = replace(
        BENCH,
        seed_seed=replace(SOYBEAN_SOYBEAN, static_friction=0.0, rolling_friction=0.0),
    )
    flat = run_pile(flowing, slippery, np.random.default_rng(1), filled=filled)
    assert flat.truth["crest_mm"] < one.truth["crest_mm"]


def test_the_photo_is_taken_when_asked():
    motion = run_pile(replace(SMALL, photo_s=0.25), BENCH, np.random.default_rng(1))
    assert motion.t_s[-1] == pytest.approx(0.25, abs=0.011)


def test_a_lifted_cylinder_leaves_a_heap_with_slopes_all_round():
    rig = LiftedCylinder(
        cylinder_m=(0.04, 0.08),
        plate_m=(0.2, 0.2),
        fill_height_m=0.04,
        gate_speed_m_s=0.2,
    )
    grippy = replace(
        BENCH,
        seed_wall=replace(SOYBEAN_Q235, static_friction=0.6, rolling_friction=0.05),
    )
    motion = run_cylinder(rig, grippy, np.random.default_rng(1))
    x, y = motion.positions_m[-1, :, 0], motion.positions_m[-1, :, 1]
    assert abs(np.nanmedian(x)) < 0.01 > abs(np.nanmedian(y))
    assert np.nanmax(np.hypot(x, y)) > 0.03
    assert motion.truth["lies_still"] == 1.0


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"fill_height_m": 0.3}, "fill_height_m = 0.3: the box is only 0.2 m high"),
        ({"gate_m": (0.2, 0.2)}, "gate_m = 0.2 wide"),
        ({"gate_m": (0.1, 0.05)}, "gate_m = 0.05 high"),
        ({"plate_m": (0.05, 0.2)}, "plate_m"),
        ({"gate_speed_m_s": 0.0}, "above 0"),
        ({"box_m": (0.1, float("nan"), 0.2)}, "above 0"),
    ],
)
def test_rigs_that_do_not_fit_are_refused(wrong, named):
    with pytest.raises(ValueError, match=named):
        Pile(**wrong)


def test_a_gate_narrower_than_seeds_need_is_refused():
    with pytest.raises(ValueError, match=r"jam in an opening of 9 mm"):
        run_pile(Pile(gate_m=(0.009, 0.2)), BENCH, np.random.default_rng(1))


def test_the_outline_of_one_ball_is_its_circle():
    ball = Seed.from_spheres([[0, 0, 0]], [0.003])
    one = np.zeros((1, 1, 3))
    motion = Motion(
        np.zeros(1),
        (ball,),
        np.zeros(1, int),
        one + np.array([0.01, 0.5, 0.02]),
        np.array([[[1.0, 0, 0, 0]]]),
        one,
        one,
    )
    x = np.linspace(0, 0.02, 190)
    circle = np.where(
        np.abs(x - 0.01) < 0.003,
        0.02 + np.sqrt(np.maximum(0.003**2 - (x - 0.01) ** 2, 0)),
        0.0,
    )
    assert np.allclose(outline(motion, x), circle, atol=1e-12)


def test_the_line_through_a_bumpy_slope_of_known_angle():
    """Bumps of a seed's size on a 27° slope with a level crest and a toe: the line's
    angle within 0.5°."""
    x = np.arange(0, 0.2, 1e-4)
    height = np.clip(0.09 - np.tan(np.radians(27)) * np.maximum(x - 0.01, 0), 0, None)
    height = np.where(height > 0, height + 5e-4 * np.sin(2 * np.pi * x / 6e-3), 0)
    assert slope_angle(x, height) == pytest.approx(27.0, abs=0.5)
    assert np.isnan(slope_angle(x, np.full_like(x, 0.05)))
    layer = np.where(
        x < 0.01, 0.02, 0.006 + 0.02 * x
    )  # a seed on a layer that rises outwards: no slope
    assert np.isnan(slope_angle(x, layer))


@pytest.mark.parametrize("wall", [0.0, None])
def test_the_centroids_angle_of_a_straight_pile_is_its_slope_whatever_rolled_away(wall):
    x = np.arange(-0.2, 0.3, 1e-4)
    away = np.where(x >= 0, x, np.inf) if wall == 0.0 else abs(x)
    height = np.clip(0.05 - np.tan(np.radians(25)) * away, 0.0, None)
    far = np.where(abs(x - 0.25) < 0.004, 0.007, 0.0)
    assert centroid_angle(x, height, wall) == pytest.approx(25, abs=0.05)
    assert centroid_angle(x, height + far, wall) == centroid_angle(x, height, wall)
    assert np.isnan(centroid_angle(x, 0 * x, wall))


def test_what_was_filled_in_and_what_is_left_are_weighed(heap, filled):
    seeds = 1e3 * sum(filled.shapes[k].mass_kg for k in filled.shape_of)
    assert heap.truth["filled_mass_g"] == pytest.approx(seeds)
    assert 0 < heap.truth["retained_mass_g"] <= heap.truth["filled_mass_g"]


def bed(convention: str, rolling: float, quiet: Settled) -> tuple[float, float]:
    """Simulated seconds that a bed of nearly round seeds of great friction takes to be
    poured, and its mean height then [mm]."""
    rough = {
        "static_friction": 0.7,
        "rolling_friction": rolling,
        "rolling_convention": convention,
    }
    contacts = {
        "seed_seed": replace(SOYBEAN_SOYBEAN, **rough),
        "seed_wall": replace(SOYBEAN_Q235, **rough),
    }
    bench = replace(BENCH, sizes=(0.0075, 0.0071, 0.0069), **contacts)
    seen = []

    class Watched(Ours):
        def settle(self, world, state, stage, watch, _):
            out = super().settle(world, state, stage, watch, quiet)
            height = 1e3 * float(out.positions[:, 2].mean())
            seen.append((out.time_s - state.time_s, height))
            return out

    fill_pile(SMALL, bench, np.random.default_rng(1), Watched(1))
    return seen[0]


@pytest.mark.parametrize(
    ("convention", "rolling"),
    [
        ("edem", 0.09),
        pytest.param("type_c", 0.18, marks=pytest.mark.slow),
    ],
)
def test_a_poured_bed_stays_as_it_is(convention, rolling):
    """Waiting until all is quiet changes nothing."""
    waits = POURED, QUIET
    at_once, later = (bed(convention, rolling, until) for until in waits)
    assert at_once[0] < 1.0 and at_once[1] == pytest.approx(
        later[1], abs=0.05
    )  # mm: a seed is 7


@pytest.mark.slow
def test_a_poured_bed_sinks_where_its_rolling_friction_creeps():
    """Type A, a torque of constant size, turns resting seeds to and fro: the
    control."""
    waits = POURED, QUIET
    at_once, later = (bed("type_a", 0.18, until) for until in waits)
    assert later[1] < at_once[1] - 0.1


CHANNEL = Pile(
    box_m=(0.06, 0.02, 0.2),
    gate_m=(0.02, 0.2),
    plate_m=(0.1, 0.02),
    fill_height_m=0.03,
    gate_speed_m_s=0.3,
    channel_m=(0.1, 0.02),
)


def test_a_channel_keeps_every_seed_between_its_walls_and_its_end():
    """Where the heap would run farther its end holds seeds back."""
    heap = run_pile(CHANNEL, BENCH, np.random.default_rng(1))
    x, y, _ = heap.positions_m[-1].T
    assert np.isfinite(x).all() and heap.truth["retained_seeds"] == len(x)
    assert x.min() > 0.0 and 0.09 < x.max() < 0.1 and np.abs(y).max() < 0.01


def test_walls_of_a_channel_are_of_the_plates_material_and_as_long_as_it():
    """So that seeds rub on them, where a slab's sides are smooth."""
    vessel = pile.vessel(CHANNEL, BENCH)
    walls = {w.name: w for w in vessel.walls(0.0, vessel.lift(0.0))}
    for name in ("near side", "far side", "end"):
        assert walls[name].material == BENCH.wall
    assert walls["near side"].a[0] == CHANNEL.plate_m[0] == walls["end"].corner[0]
    assert not vessel.contacts and pile.vessel(SMALL, BENCH).contacts


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"slab": True}, "walls of a channel rub"),
        ({"box_m": (0.06, 0.03, 0.2)}, "as wide as it"),
        ({"plate_m": (0.15, 0.02)}, "must be its floor"),
        ({"channel_m": (0.05, 0.02), "plate_m": (0.05, 0.02)}, "stand"),
    ],
)
def test_a_channel_that_cannot_be_is_refused(wrong, says):
    with pytest.raises(ValueError, match=says):
        replace(CHANNEL, **wrong)
