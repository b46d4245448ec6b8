"""Running: the same bits whatever the threads, stops and restarts; seeds that leave;
watches; what is refused."""

import os
import subprocess
import sys
from dataclasses import fields, replace

import numpy as np
import pytest
from scenes import NO_AIR

from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.engine.observe import Settled, Track
from benchtwin.sim.engine.pace import Pace
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.step import Every, Stopped, init, load, run, save, step
from benchtwin.sim.engine.walls import (
    Cylinder,
    Mesh,
    Plane,
    Rectangle,
    Slide,
    Turn,
    box,
)
from benchtwin.sim.engine.world import Placed, Scattered, World
from benchtwin.sim.laws import LAWS
from benchtwin.sim.material import Q235, SOYBEAN, SOYBEAN_Q235, SOYBEAN_SOYBEAN, Contact
from benchtwin.sim.rotation import any_turn, turned
from benchtwin.sim.seed import Seed

SOFT = SOYBEAN.softened(1e7)
CONTACTS = (SOYBEAN_Q235, SOYBEAN_SOYBEAN)
BEAN = Seed.from_dimensions(8.72e-3, 6.84e-3, 5.98e-3)
BALL = Seed.from_spheres([[0, 0, 0]], [3e-3])
RNG = np.random.default_rng


def same(a: State, b: State) -> bool:
    return all(
        np.array_equal(getattr(a, f.name), getattr(b, f.name)) for f in fields(State)
    )


@pytest.fixture(scope="module")
def heap():
    """300 beans and 300 balls falling into a box with a gate that rises."""
    gate = Slide(LAWS["motion_steady"].use(rate=0.2, start=0.05), (0, 0, 1))
    floor, *sides = box("box", Q235, (0, 0, 0), (0.07, 0.07, 0.2))
    walls = (floor, replace(sides[0], moves=(gate,)), *sides[1:])
    groups = (
        Scattered((BEAN,), SOFT, 300, (0, 0, 0), (0.07, 0.07, 0.1)),
        Scattered((BALL,), SOFT, 300, (0, 0, 0.1), (0.07, 0.07, 0.2)),
    )
    world = World(groups, walls, CONTACTS, NO_AIR)
    return world, run(world, init(world, RNG(4)), 0.06)


@pytest.fixture
def all_threads(monkeypatch):
    """Every call on as many threads as are allowed, however slow."""
    monkeypatch.setattr(Pace, "next_call", lambda self: (self.numbers[0], 1.0))


@pytest.mark.parametrize("threads", [2, 3])
def test_threads_do_not_change_a_bit(heap, threads, all_threads):
    world, state = heap
    assert len(state.block_body) > 3
    assert same(
        run(world, state, steps=700), run(world, state, steps=700, threads=threads)
    )


def calls(pace: Pace, ns_of: dict[int, float], count: int) -> list[int]:
    """Threads of so many calls, where a ball-step takes so long with each number of
    them."""
    used = []
    for _ in range(count):
        threads, share = pace.next_call()
        used.append(threads)
        pace.took(threads, 1e-9 * ns_of[threads] * 1e6 * share, int(1e6 * share))
    return used


def test_the_quicker_number_of_threads_is_used_and_the_other_tried_now_and_then():
    pace = Pace(2)
    assert np.mean(np.array(calls(pace, {1: 80.0, 2: 45.0}, 200)) == 2) > 0.95
    busy = calls(pace, {1: 90.0, 2: 900.0}, 200)
    assert np.mean(np.array(busy) == 1) > 0.9 and 2 in busy[20:]
    assert (
        calls(pace, {1: 80.0, 2: 45.0}, 200)[-50:].count(2) > 45
    )  # the machine is free again
    assert set(calls(Pace(1), {1: 80.0}, 100)) == {1}


def test_a_checkpoint_continues_bit_for_bit(heap, tmp_path, all_threads):
    world, state = heap
    whole = run(world, state, steps=900)
    half = run(world, state, steps=411)
    save(half, tmp_path / "half.npz")
    assert same(load(tmp_path / "half.npz"), half)
    assert same(run(world, load(tmp_path / "half.npz"), steps=489, threads=2), whole)


def test_observers_and_single_steps_do_not_change_a_bit(heap):
    world, state = heap
    whole = run(world, state, steps=40)
    track = Track(lambda w, s: s.positions[0, 2])
    assert same(
        run(world, state, steps=40, observers=[Every(3.3 * state.dt, track)]), whole
    )
    assert len(track.values) in (12, 13)
    for _ in range(40):
        state = step(world, state)
    assert same(state, whole)


def test_the_same_seed_gives_the_same_run_and_another_a_different_one(heap):
    world, _ = heap
    a, b, c = (init(world, RNG(k)) for k in (1, 1, 2))
    assert same(run(world, a, steps=50), run(world, b, steps=50))
    assert not np.array_equal(a.positions, c.positions)


def test_run_leaves_the_given_state_alone(heap):
    world, state = heap
    before = state.copy()
    run(world, state, steps=20)
    assert same(state, before)


def test_no_checkpoint(tmp_path):
    np.savez(tmp_path / "other.npz", step=1)
    with pytest.raises(ValueError, match="no checkpoint of this version"):
        load(tmp_path / "other.npz")


def test_seeds_that_leave_are_removed_and_counted():
    x = np.array([[0.0, 0, 0.003], [0.05, 0, 0.003]])
    v = np.array([[0.0, 0, 0], [1.0, 0, 0]])
    plate = Rectangle("plate", Q235, (-0.06, -0.06, 0), (0.12, 0, 0), (0, 0.12, 0))
    world = World(
        (Placed((BALL,), SOFT, x, velocities=v),),
        (plate,),
        CONTACTS,
        domain=((-0.1, -0.1, -0.1), (0.1, 0.1, 0.1)),
    )
    shaken = init(world, RNG(0))
    end = run(
        world, replace(shaken, skin=1e-3), 0.2
    )  # a skin, so that the lists are made anew on the way
    assert end.count == 1 and end.removed.tolist() == [1] and end.ids.tolist() == [0]


def test_overlap_watch():
    world = World(
        (
            Placed(
                (BALL,),
                SOYBEAN.softened(1e5),
                [[0, 0, 0.0031]],
                velocities=[[0, 0, -3.0]],
            ),
        ),
        (Plane("floor", Q235),),
        CONTACTS,
    )
    with pytest.raises(
        Stopped,
        match=r"largest overlap \d+ % of the radius at t = .* reduce dt or stiffen",
    ) as stopped:
        run(world, init(world, RNG(0)), 0.1)
    assert stopped.value.state.step > 0


def test_runaway_watch():
    world = World(
        (Placed((BALL,), SOFT, [[0, 0, 1.0]]),),
        (Plane("floor", Q235),),
        CONTACTS,
        most_speed_m_s=1.0,
    )
    with pytest.raises(Stopped, match="above most_speed_m_s = 1"):
        run(world, init(world, RNG(0)), 0.5)


def test_settled_ends_a_run():
    world = World(
        (Placed((BALL,), SOFT, [[0, 0, 0.004]]),), (Plane("floor", Q235),), CONTACTS
    )
    end = run(world, init(world, RNG(0)), Settled(window_s=0.05))
    assert 0.05 < end.time_s < 1.0
    assert abs(end.velocities).max() < 1e-4


def test_a_ball_rolls_over_a_tessellated_floor_as_over_a_plane():
    """32 triangles with long and short edges; the same path to a few parts in a
    thousand."""
    xs, ys = np.linspace(-0.01, 0.1, 9), np.array([-0.02, -0.001, 0.02])
    grid = np.array([[x, y, 0.0] for x in xs for y in ys])
    faces = [
        f
        for i in range(8)
        for j in range(2)
        for f in (
            (3 * i + j, 3 * i + j + 3, 3 * i + j + 1),
            (3 * i + j + 4, 3 * i + j + 1, 3 * i + j + 3),
        )
    ]
    ends = []
    for wall in (
        Plane("floor", Q235),
        Mesh("floor", Q235, grid, np.array(faces)),
        Rectangle("floor", Q235, (-0.01, -0.02, 0), (0.11, 0, 0), (0, 0.04, 0)),
    ):
        placed = Placed((BALL,), SOFT, [[0, 0, 0.003]], velocities=[[0.4, 0, 0]])
        world = World(
            (placed,),
            (wall,),
            (Contact(("soybean", "Q235"), 0.5, 0.4, 0.01), SOYBEAN_SOYBEAN),
        )
        ends.append(run(world, init(world, RNG(0)), 0.2))
    plane, mesh, rectangle = ends
    assert rectangle.positions == pytest.approx(plane.positions, abs=1e-12)
    assert mesh.positions[0] == pytest.approx(plane.positions[0], rel=3e-3, abs=1e-6)
    assert mesh.spins[0] == pytest.approx(plane.spins[0], rel=5e-3, abs=0.5)


def test_a_mesh_edge_and_corner_push_once():
    """A ball on the top corner of a cube made of twelve triangles feels one contact,
    through its middle."""
    import trimesh

    cube = Mesh.from_trimesh(trimesh.creation.box((0.02, 0.02, 0.02)), "cube", Q235)
    for at in ([0.01, 0.01, 0.01], [0.01, 0.0, 0.01], [0.002, 0.002, 0.01]):
        outwards = np.array([k if abs(k) > 0.009 else 0 for k in at])
        placed = Placed(
            (BALL,),
            SOFT,
            [np.array(at) + 0.002999 * outwards / np.linalg.norm(outwards)],
        )
        state = init(World((placed,), (cube,), CONTACTS), RNG(0))
        assert state.sums[:, 8].sum() == 1
        push = state.load[0, :3] + [0, 0, G_M_S2 * BALL.mass_kg]
        assert push / np.linalg.norm(push) == pytest.approx(
            outwards / np.linalg.norm(outwards), abs=1e-9
        )


def test_inside_and_outside_of_a_cylinder():
    tube = Cylinder("tube", Q235, (0, 0, 0), (0, 0, 0.1), 0.02)
    for x, sign in ((0.017001, -1), (0.022999, 1)):
        state = init(
            World(
                (Placed((BALL,), SOFT, [[x, 0, 0.05]]),),
                (tube,),
                CONTACTS,
                gravity=(0, 0, 0),
            ),
            RNG(0),
        )
        assert np.sign(state.load[0, 0]) == sign


def test_a_turning_floor_carries_a_ball_along():
    """A disc's worth of floor turning about z: without slip the contact point moves
    with it; the ball's centre circles slowly."""
    turn = Turn(LAWS["motion_steady"].use(rate=2.0), (0, 0, 0), (0, 0, 1))
    floor = Rectangle(
        "floor", Q235, (-0.1, -0.1, 0), (0.2, 0, 0), (0, 0.2, 0), moves=(turn,)
    )
    contacts = (Contact(("soybean", "Q235"), 0.5, 1.0, 0.0), SOYBEAN_SOYBEAN)
    world = World(
        (Placed((BALL,), SOFT, [[0.03, 0, 0.003]]),), (floor,), contacts, NO_AIR
    )
    state = run(world, init(world, RNG(0)), 0.3)
    x, v, w = state.positions[0], state.velocities[0], state.spins[0]
    at_contact = v + np.cross(w, [0, 0, -0.003])
    assert at_contact[:2] == pytest.approx(np.cross([0, 0, 2.0], x)[:2], abs=2e-3)
    assert w[0] ** 2 + w[1] ** 2 > 1.0


def refused(match, **change):
    good = {
        "seeds": (Placed((BALL,), SOFT, [[0, 0, 0.004]]),),
        "walls": (Plane("floor", Q235),),
        "contacts": CONTACTS,
    }
    with pytest.raises(ValueError, match=match):
        init(World(**{**good, **change}), RNG(0))


@pytest.mark.parametrize(
    ("group", "walls", "said"),
    [
        (  # two balls of 3 mm whose centres are 5.4 mm apart
            Placed((BALL,), SOFT, [[0, 0, 0.02], [0, 0, 0.0254], [0.01, 0, 0.02]]),
            (),
            "seed 0 and seed 1 overlap by 20 % of the smaller ball's radius at the"
            " start; 0.1 % is allowed",
        ),
        (  # of a small and a large ball, 1.5 mm
            Placed(
                (BALL, Seed.from_spheres([[0, 0, 0]], [6e-3])),
                SOFT,
                [[0, 0, 0.02], [0, 0.0075, 0.02]],
                shape_of=[0, 1],
            ),
            (),
            "seed 0 and seed 1 overlap by 50 %",
        ),
        (  # 2 mm from the inside of a cylinder
            Placed((BALL,), SOFT, [[0.018, 0, 0.05]]),
            (Cylinder("tube", Q235, (0, 0, 0), (0, 0, 0.1), 0.02),),
            "seed 0 and wall 'tube' overlap by 33 %",
        ),
        (  # beside a rectangle's edge, its corner 2.4 mm away
            Placed((BALL,), SOFT, [[0.5024, 0, 0.1]]),
            (Rectangle("shelf", Q235, (0, -0.5, 0.1), (0.5, 0, 0), (0, 1, 0)),),
            "seed 0 and wall 'shelf' overlap by 20 %",
        ),
        (  # on a triangle of a mesh
            Placed((BALL,), SOFT, [[0.1, 0.1, 0.0015]]),
            (Mesh("chute", Q235, 0.5 * np.eye(3)[[2, 0, 1]] * [1, 1, 0], [[0, 1, 2]]),),
            "seed 0 and wall 'chute' overlap by 50 %",
        ),
    ],
)
def test_a_start_with_overlaps_says_who_and_by_how_much(group, walls, said):
    world = World((group,), walls or (Plane("floor", Q235),), CONTACTS)
    with pytest.raises(ValueError, match=said):
        init(world, RNG(0))
    assert init(world, RNG(0), allowed_overlap=0.9).count == len(group.positions)


def test_a_turned_seeds_overlap_with_a_wall_is_its_balls():
    """0.5 mm of the lowest ball, or more of a smaller one's radius, as the seed
    lies."""
    rng = RNG(3)
    for _ in range(20):
        q = any_turn(rng)
        heights = turned(q, BEAN.centres_m)[:, 2] - BEAN.radii_m
        height = -heights.min() - 0.5e-3
        group = Placed((BEAN,), SOFT, [[0, 0, height]], [q])
        share = 100 * np.max(-(heights + height) / BEAN.radii_m)
        with pytest.raises(ValueError, match=f"wall 'floor' overlap by {share:.2g} %"):
            init(World((group,), (Plane("floor", Q235),), CONTACTS), RNG(0))


REFUSED = """
import numpy as np
from numba.core import event
from benchtwin.sim.engine.step import init
from benchtwin.sim.engine.walls import Plane
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.laws import LAWS
from benchtwin.sim.material import Q235, SOYBEAN, SOYBEAN_Q235, SOYBEAN_SOYBEAN
from benchtwin.sim.seed import Seed
ball = Seed.from_spheres([[0, 0, 0]], [3e-3])
two = LAWS["spring_linear"].use(stiffness=1e4), LAWS["spring_jkr"].use(work=0.1)
stiff = (LAWS["spring_linear"].use(stiffness=1e12),)
cases = [
    ("overlap by 33 %", [[0, 0, 2e-3]], ()),
    ("overlap by 33 %", [[0, 0, 4e-3], [0, 5e-3, 4e-3]], ()),
    ("choose one", [[0, 0, 4e-3]], two),
    ("choose what is softer", [[0, 0, 4e-3]], stiff),
]
with event.install_recorder("numba:compile") as compiled:
    for said, places, laws in cases:
        try:
            group = Placed((ball,), SOYBEAN, places)
            contacts = SOYBEAN_Q235, SOYBEAN_SOYBEAN
            world = World((group,), (Plane("floor", Q235),), contacts, laws)
            init(world, np.random.default_rng(0))
        except ValueError as error:
            assert said in str(error), error
        else:
            raise AssertionError(said)
assert not compiled.buffer, compiled.buffer
"""


def test_what_is_refused_is_refused_before_anything_is_compiled(tmp_path):
    """In a process of its own, in which nothing has been."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    subprocess.run([sys.executable, "-c", REFUSED], env=environment, check=True)
    assert not list(tmp_path.rglob("*.nbi"))


def test_what_is_refused():
    refused("finite", seeds=(Placed((BALL,), SOFT, [[0, 0, np.nan]]),))
    refused("outside the domain", domain=((0, 0, 0), (1, 1, 0.001)))
    refused(
        "unit quaternions",
        seeds=(Placed((BALL,), SOFT, [[0, 0, 0.004]], orientations=[[1, 1, 0, 0]]),),
    )
    refused("needs one Contact", contacts=(SOYBEAN_SOYBEAN,))
    refused("at least one group", seeds=())
    refused("rayleigh_fraction = 0.9: must be 0.0001 to 0.5", rayleigh_fraction=0.9)
    refused("time_step_s", time_step_s=-1.0)
    refused("gravity", gravity=(0, 0, np.nan))
    refused("names must differ", walls=(Plane("a", Q235), Plane("a", Q235)))
    refused("not all 0", walls=(Plane("a", Q235, normal=(0, 0, 0)),))
    refused(
        "perpendicular", walls=(Rectangle("a", Q235, (0, 0, 0), (1, 0, 0), (1, 1, 0)),)
    )
    refused("radius = -1", walls=(Cylinder("a", Q235, (0, 0, 0), (0, 0, 1), -1),))
    refused(
        "no area", walls=(Mesh("a", Q235, np.zeros((3, 3)), np.array([[0, 1, 2]])),)
    )
    refused(
        "do not fit",
        seeds=(Scattered((BALL,), SOFT, 100, (0, 0, 0), (0.01, 0.01, 0.01)),),
    )
    refused("give it to Slide or Turn", laws=(LAWS["motion_steady"].use(rate=1.0),))
    refused(
        "no seed or wall is made of",
        laws=(
            LAWS["cohesion_linear"].use(between=("soybean", "ice"), energy_density=1e4),
        ),
    )
