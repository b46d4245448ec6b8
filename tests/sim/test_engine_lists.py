"""Neighbour lists against the naive way: all pairs, every step."""

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scenes import NO_AIR

from benchtwin.sim.engine import lists
from benchtwin.sim.engine.step import init, run
from benchtwin.sim.engine.walls import Plane, Rectangle, Slide, Turn
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.laws import LAWS
from benchtwin.sim.material import Q235, SOYBEAN, SOYBEAN_Q235, SOYBEAN_SOYBEAN
from benchtwin.sim.seed import Seed

SOFT = SOYBEAN.softened(1e7)
SHAPES = (
    Seed.from_spheres([[0, 0, 0]], [2e-3]),
    Seed.from_spheres([[0, 0, 0]], [4e-3]),
    Seed.from_dimensions(8.72e-3, 6.84e-3, 5.98e-3),
    Seed.from_spheres([[0, 0, 0], [5e-3, 0, 0]], [3e-3, 2e-3]),
)


def scene(numbers: np.random.Generator, count: int, moving: bool) -> World:
    """Seeds of four shapes on a jittered grid, thrown about, over a floor, a plate that
    moves and one that turns."""
    grid = np.stack(np.unravel_index(np.arange(count), (64, 4, 4)), axis=1) * 10.9e-3
    x = grid + numbers.uniform(-3e-4, 3e-4, (count, 3)) + [0, 0, 7e-3]
    turns = numbers.normal(size=(count, 4))
    steady = LAWS["motion_steady"]
    slide = (Slide(steady.use(rate=0.5), (1, 0, 0)),) if moving else ()
    turn = (Turn(steady.use(rate=3.0), (0.02, 0.02, 0.0), (0, 1, 0)),) if moving else ()
    walls = (
        Plane("floor", Q235, moves=turn),
        Rectangle(
            "plate", Q235, (-0.02, -0.01, 0), (0, 0.06, 0), (0, 0, 0.1), moves=slide
        ),
    )
    placed = Placed(
        SHAPES,
        SOFT,
        x,
        turns / np.linalg.norm(turns, axis=1, keepdims=True),
        numbers.normal(size=(count, 3)),
        numbers.normal(size=(count, 3)) * 100,
        numbers.integers(0, len(SHAPES), count),
    )
    laws = NO_AIR if moving else ()
    return World(
        (placed,), walls, (SOYBEAN_Q235, SOYBEAN_SOYBEAN), laws, most_overlap=0.9
    )


def touching(state) -> set:
    """Ball pairs in contact, by permanent numbers."""
    on = np.flatnonzero(state.pair_touch)
    a, b = state.ball_id[state.pair_i[on]], state.ball_id[state.pair_j[on]]
    return set(zip(np.minimum(a, b).tolist(), np.maximum(a, b).tolist(), strict=True))


def naive(state) -> set:
    """Overlapping ball pairs of different bodies, by looking at all of them."""
    gap = (
        np.linalg.norm(state.ball[:, None, :3] - state.ball[None, :, :3], axis=2)
        - state.ball[:, None, 3]
        - state.ball[None, :, 3]
    )
    i, j = np.nonzero(
        np.triu((gap < 0) & (state.owner[:, None] != state.owner[None, :]))
    )
    a, b = state.ball_id[i], state.ball_id[j]
    return set(zip(np.minimum(a, b).tolist(), np.maximum(a, b).tolist(), strict=True))


@settings(max_examples=12, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(2, 48), moving=st.booleans())
def test_lists_find_what_all_pairs_find(seed, count, moving):
    world = scene(np.random.default_rng(seed), count, moving)
    state = init(world, np.random.default_rng(0))
    for _ in range(4):
        state = run(world, state, steps=150)
        assert touching(state) == naive(state)


@settings(max_examples=6, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), moving=st.booleans())
def test_motion_is_that_with_everything_listed(seed, moving):
    """Endless lists never need making anew; sums are then in another order, and equal
    to rounding grown over 200 steps."""
    world = scene(np.random.default_rng(seed), 40, moving)
    try:
        start = init(world, np.random.default_rng(0))
    except ValueError:  # drawn on top of each other
        assume(False)
    listed = run(world, start, steps=200)
    few, lists.FEW = lists.FEW, 10**9
    try:
        naive_run = run(world, init(world, np.random.default_rng(0)), steps=200)
    finally:
        lists.FEW = few
    assert naive_run.skin > 1.0 > listed.skin
    assert np.allclose(listed.positions, naive_run.positions, rtol=0, atol=1e-9)
    assert np.allclose(
        listed.wall_push_ns, naive_run.wall_push_ns, rtol=1e-6, atol=1e-10
    )


def test_every_listed_pair_is_listed_once():
    world = scene(np.random.default_rng(5), 60, False)
    state = run(world, init(world, np.random.default_rng(0)), steps=300)
    pairs = list(zip(state.pair_i.tolist(), state.pair_j.tolist(), strict=True))
    assert len(pairs) == len(set(pairs)) > 0
    assert (state.owner[state.pair_i] < state.owner[state.pair_j]).all()
