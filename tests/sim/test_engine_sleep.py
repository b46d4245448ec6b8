"""Seeds at rest sleep, and wake when what they rest on, or what rests on them,
changes."""

from dataclasses import fields, replace

import numpy as np
import pytest
from scenes import NO_AIR

from benchtwin.sim.engine.audit import Audit
from benchtwin.sim.engine.gathering import S_NORMAL
from benchtwin.sim.engine.pace import Pace
from benchtwin.sim.engine.sleeping import CALM, SLEEP_EVERY
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.step import init, load, run, save, tables_of
from benchtwin.sim.engine.walls import Plane, Rectangle, Slide, box
from benchtwin.sim.engine.world import Placed, Scattered, World
from benchtwin.sim.laws import LAWS
from benchtwin.sim.material import Q235, SOYBEAN, Contact
from benchtwin.sim.seed import Seed

SOFT = SOYBEAN.softened(1e7)
BALL = Seed.from_spheres([[0, 0, 0]], [3e-3])
BEAN = Seed.from_dimensions(8.72e-3, 6.84e-3, 5.98e-3)
ROUGH = (
    Contact(("soybean", "Q235"), 0.5, 0.5, 0.05),
    Contact(("soybean", "soybean"), 0.5, 0.5, 0.05),
)
SMOOTH = (
    Contact(("soybean", "Q235"), 0.5, 0.0, 0.0),
    Contact(("soybean", "soybean"), 0.5, 0.0, 0.0),
)


def asleep(state: State) -> np.ndarray:
    return (state.calm >= CALM)[state.order]


@pytest.fixture(scope="module")
def bed() -> tuple[World, State]:
    """200 beans in a box, 0.8 s after they were let fall."""
    walls = tuple(box("box", Q235, (0, 0, 0), (0.05, 0.05, 0.3)))
    world = World(
        (Scattered((BEAN,), SOFT, 200, (0, 0, 0), (0.05, 0.05, 0.2)),),
        walls,
        ROUGH,
        sleep=True,
    )
    return world, run(world, init(world, np.random.default_rng(3)), 0.8)


def test_a_bed_falls_asleep_and_then_stands(bed):
    world, state = bed
    resting = asleep(state)
    assert resting.mean() > 0.9
    later = run(world, state, state.time_s + 0.05)
    stood = (later.positions == state.positions).all(axis=1)
    assert (resting & stood).mean() > 0.9
    assert np.abs(later.positions - state.positions).max() < 1e-3 * 6e-3


def test_a_run_that_goes_on_among_sleepers_makes_no_energy(bed):
    """Between two looks at sleepers their stored energy is not in the sums: an audit
    that begins there finds none of it made when they are looked at, to a hundredth of
    what is stored."""
    world, state = bed
    between = run(world, state, steps=SLEEP_EVERY - state.step % SLEEP_EVERY + 5)
    stored = run(world, between, steps=SLEEP_EVERY - 5).sums[:, S_NORMAL].sum()
    assert between.sums[:, S_NORMAL].sum() < 0.5 * stored
    audit = Audit(world, tables_of(world), between)
    there = audit.at_rest + stored
    strict = replace(world, most_gain=0.01 * stored / there)
    run(strict, between, between.time_s + 3 * audit.interval * between.dt)


def test_threads_and_a_checkpoint_do_not_change_a_bit(bed, tmp_path, monkeypatch):
    monkeypatch.setattr(
        Pace, "next_call", lambda self: (self.numbers[0], 1.0)
    )  # two threads, however slow
    world, _ = bed
    start = run(
        world, init(world, np.random.default_rng(3)), 0.3
    )  # some sleep, some fall
    assert 0.05 < asleep(start).mean() < 0.95
    whole = run(world, start, steps=900)
    half = run(world, start, steps=411)
    save(half, tmp_path / "half.npz")
    gone_on = run(world, load(tmp_path / "half.npz"), steps=489, threads=2)
    assert all(
        np.array_equal(getattr(gone_on, f.name), getattr(whole, f.name))
        for f in fields(State)
    )


def test_a_seed_whose_support_is_drawn_away_falls_at_once():
    """A plate sinks from 0.1 s on at 5 m/s, faster than the ball falls: free fall since
    then, but for one look at most."""
    sinking = Slide(LAWS["motion_steady"].use(rate=-5.0, start=0.1), (0, 0, 1))
    plate = Rectangle(
        "plate", Q235, (-0.1, -0.1, 0), (0.2, 0, 0), (0, 0.2, 0), (sinking,)
    )
    world = World(
        (Placed((BALL,), SOFT, [[0, 0, 3e-3]]),), (plate,), ROUGH, NO_AIR, sleep=True
    )
    before = run(world, init(world, np.random.default_rng(0)), 0.099)
    assert asleep(before).all()
    after = run(world, before, 0.12)
    fallen = before.positions[0, 2] - after.positions[0, 2]
    late = SLEEP_EVERY * after.dt
    assert 0.5 * 9.81 * (0.02 - late) ** 2 * 0.99 <= fallen <= 0.5 * 9.81 * 0.02**2


def test_sleepers_move_apart_under_a_load_as_seeds_that_never_sleep():
    """Two balls that touch lie on a smooth floor and sleep; a third is let down between
    them and drives them apart."""
    gap = 6e-3
    places = [[-gap / 2, 0, 3e-3], [gap / 2, 0, 3e-3], [0, 0, 0.03]]

    def after(sleep: bool, t: float) -> State:
        world = World(
            (Placed((BALL,), SOFT, places),),
            (Plane("floor", Q235),),
            SMOOTH,
            sleep=sleep,
        )
        return run(world, init(world, np.random.default_rng(0)), t)

    assert asleep(after(True, 0.06))[:2].all()
    with_sleep, without = after(True, 0.15), after(False, 0.15)
    moved = without.positions[1, 0] - gap / 2
    assert moved > 3e-3
    assert with_sleep.positions[1, 0] - gap / 2 == pytest.approx(
        moved, rel=0.08
    )  # what is lost before they wake: 1 to 7 % over ten heights of the fall


def test_no_seed_sleeps_unless_it_may(bed):
    world, state = bed
    assert asleep(state).any()
    assert not asleep(run(replace(world, sleep=False), state, steps=500)).any()


def test_an_account_of_energies_needs_all_contacts():
    with pytest.raises(ValueError, match="say sleep = False"):
        World(
            (Placed((BALL,), SOFT, [[0, 0, 3e-3]]),),
            (Plane("floor", Q235),),
            ROUGH,
            ledger=True,
            sleep=True,
        )
