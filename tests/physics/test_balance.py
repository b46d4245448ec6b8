"""Every joule and every newton second of a collapse accounted for; the order of the
integrator; a bed's weight on its floor."""

import numpy as np
import pytest
from scenes import ball, go, on_floor

from benchtwin.sim.engine import observe
from benchtwin.sim.engine.step import Every, init, run
from benchtwin.sim.engine.walls import Plane, Slide, box
from benchtwin.sim.engine.world import Placed, Scattered, World
from benchtwin.sim.laws import LAWS
from benchtwin.sim.material import Q235, SOYBEAN, SOYBEAN_Q235, SOYBEAN_SOYBEAN
from benchtwin.sim.seed import Seed

SOFT = SOYBEAN.softened(1e7)
CONTACTS = (SOYBEAN_Q235, SOYBEAN_SOYBEAN)
BEAN = Seed.from_dimensions(8.72e-3, 6.84e-3, 5.98e-3)


@pytest.fixture(scope="module")
def collapse():
    """500 five-ball soybeans fall from random places, collapse on a floor between side
    walls and come to rest, 0.4 s."""
    sides = box("box", Q235, (0, 0, 0), (0.08, 0.08, 0.4))[1:]
    walls = (Plane("floor", Q235), *sides)
    world = World(
        (Scattered((BEAN,), SOFT, 500, (0, 0, 1e-3), (0.08, 0.08, 0.09)),),
        walls,
        CONTACTS,
        ledger=True,
    )
    start = init(world, np.random.default_rng(3))
    account = observe.Track(observe.energy)
    push = observe.Track(
        lambda w, s: (s.wall_push_ns.sum(axis=0), s.masses @ s.velocities)
    )
    end = run(world, start, 0.4, observers=(Every(0.005, account), Every(0.005, push)))
    return world, start, end, account, push


def test_energy_of_a_collapse(collapse):
    """Kinetic + potential + elastic + dissipated stays constant to 0.6 % of the energy
    that is turned over, at 20 % of the Rayleigh time; the balance closes as the step's
    square (next test but one)."""
    _, _, _, account, _ = collapse
    totals = np.array([e.total for e in account.values])
    turned_over = account.values[0].mechanical - account.values[-1].mechanical
    assert turned_over > 0.02
    assert np.abs(totals - totals[0]).max() < 6e-3 * turned_over
    last = account.values[-1]
    for part in (last.damping, last.friction, last.rolling):
        assert part > 0.005 * turned_over
    assert last.kinetic < 1e-3 * turned_over
    assert last.adhesion == last.walls == last.body_laws == 0.0


def test_each_dissipation_only_grows(collapse):
    *_, account, _ = collapse
    for name in ("damping", "rolling"):
        assert (np.diff([getattr(e, name) for e in account.values]) > -1e-9).all()


def test_momentum_of_a_collapse(collapse):
    """Weight × time less the push on the walls is the momentum, in every direction, to
    less than one step's push: the integral of the push counts the last force whole, the
    momentum half of it."""
    world, start, _, _, push = collapse
    weight = start.masses.sum() * np.array(world.gravity)
    for t, (on_walls, momentum) in zip(push.times_s, push.values, strict=True):
        assert momentum == pytest.approx(
            weight * t - on_walls, abs=5 * np.abs(weight).max() * start.dt
        )


@pytest.mark.parametrize("e", [1.0, 0.6])
def test_order_of_the_integrator(e):
    """A ball pressed on a floor, oscillating: position after a fixed time, against a
    step 16 times smaller: second order, with damping as without."""
    seed, at = ball(3e-3, 1250.0), []
    steps = (400, 800, 1600, 12800)
    for n in steps:
        world = on_floor(
            seed,
            SOFT,
            e=e,
            mu=0.0,
            floor=Q235,
            positions=[[0, 0, 2.9999e-3]],
            gravity=(0, 0, -2000.0),
            time_step_s=2e-3 / n,
        )
        at.append(go(world, 2e-3).positions[0, 2])
    errors = np.abs(np.array(at[:-1]) - at[-1])
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx([2, 2], abs=0.25)


def test_a_bed_presses_on_its_floor_with_its_weight():
    """Planes of no friction at the sides: the floor carries it all."""
    from benchtwin.sim.material import Contact, Material

    slick = Material("slick", 7850.0, 8.2e10, 0.28)
    contacts = (*CONTACTS, Contact(("soybean", "slick"), 0.3, 0.0, 0.0))
    sides = [
        Plane(f"side{k}", slick, p, n)
        for k, (p, n) in enumerate(
            [
                ((0, 0, 0), (1, 0, 0)),
                ((0.05, 0, 0), (-1, 0, 0)),
                ((0, 0, 0), (0, 1, 0)),
                ((0, 0.05, 0), (0, -1, 0)),
            ]
        )
    ]
    world = World(
        (Scattered((BEAN,), SOFT, 150, (0, 0, 0), (0.05, 0.05, 0.15)),),
        (Plane("floor", Q235), *sides),
        contacts,
    )
    at_rest = observe.Settled(window_s=0.02, displacement=1e-2, kinetic=1e-5)
    state = run(world, init(world, np.random.default_rng(1)), at_rest)
    assert state.time_s < 2.0
    later = run(
        world, state, state.time_s + 0.05
    )  # the mean over a while: single moments still hum by 2e-3
    mean = (later.wall_push_ns - state.wall_push_ns)[0, 2] / (
        later.time_s - state.time_s
    )
    assert -mean == pytest.approx(state.masses.sum() * 9.81, rel=1e-3)


def test_a_moving_floors_work_is_in_the_account():
    """A floor that rises at a constant speed under a ball lifts it: its work is what
    the ball gains and loses."""
    lift = Slide(LAWS["motion_steady"].use(rate=0.05), (0, 0, 1))
    world = World(
        (Placed((ball(3e-3, 1250.0),), SOFT, [[0, 0, 3.0001e-3]]),),
        (Plane("floor", Q235, moves=(lift,)),),
        CONTACTS,
        ledger=True,
    )
    first, last = init(world, np.random.default_rng(0)), None
    last = run(world, first, 0.2)
    account = observe.energy(world, last)
    assert last.positions[0, 2] == pytest.approx(3e-3 + 0.01, abs=2e-5)
    assert account.walls == pytest.approx(
        account.mechanical - observe.energy(world, first).mechanical, rel=0.02
    )
    assert account.total == pytest.approx(
        observe.energy(world, first).total, abs=2e-3 * account.walls
    )
