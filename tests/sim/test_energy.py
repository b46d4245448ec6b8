"""The step follows the laws that are chosen, and no run makes energy: a law that does
is stopped, one that is stiff is computed right."""

import numpy as np
import pytest
from scenes import RIGID, ball

from benchtwin.sim.engine.audit import Audit
from benchtwin.sim.engine.step import Every, Stopped, init, run, tables_of
from benchtwin.sim.engine.time_step import RAYLEIGH, longest_steps, time_step
from benchtwin.sim.engine.walls import Plane, Slide
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.laws import LAWS, Law, Parameter
from benchtwin.sim.material import Contact, Material

SOFT = Material("soft", 1200.0, 1e3, 0.3)
STIFF = Material("stiff", 1200.0, 3e7, 0.3)
BALL = ball(3e-3, 1200.0)
FALL_M = 0.1
# before the 20 s of compiling: one set of laws for all runs here
HAND = LAWS["motion_steady"].use(rate=0.0)


def spring(overlap, closing_speed, radius, modulus, k, thrust):
    """A linear spring that pushes harder by `thrust` as the bodies part [N]."""
    return k * max(overlap, 0.0) * (1.0 + (thrust if closing_speed < 0.0 else 0.0))


SPRING = Law(
    "spring",
    "normal",
    spring,
    (Parameter("k", "N/m", 0.0, 1e7, ""), Parameter("thrust", "1", 0.0, 10.0, "")),
)


def world(*, lift=HAND, of=SOFT, **numbers) -> World:
    up = np.array([[0.0, 0.0, FALL_M + 3e-3]])
    floor = Plane("floor", RIGID, (0, 0, 0), (0, 0, 1), (Slide(lift, (0.0, 0.0, 1.0)),))
    return World(
        (Placed((BALL,), of, up),),
        (floor,),
        tuple(Contact((of.name, b), 1.0, 0.0, 0.0) for b in (of.name, RIGID.name)),
        (SPRING.use(**numbers),),
        most_overlap=1.0,
    )


def rebound_m(of: World) -> float:
    """How high the ball comes after its first touch."""
    state = init(of, np.random.default_rng(1))
    high: list[float] = [0.0]
    rising = []

    def look(world: World, state) -> bool:
        (x, v) = state.positions[0, 2], state.velocities[0, 2]
        rising.append(v > 0)
        high[0] = max(high[0], x - 3e-3) if any(rising) else 0.0
        return any(rising) and v < 0

    run(of, state, 1.0, [Every(1e-4, look)])
    return high[0]


@pytest.mark.parametrize("k", [1e4, 1e7])
def test_a_stiff_law_of_one_s_own_sets_the_step_and_gives_back_what_it_took(k):
    """A spring without a damper: from .1 m back to .1 m; the step is π √(m/k)/50, by
    which the rebound is right to a thousandth; m is that of two such balls."""
    of = world(k=k, thrust=0.0)
    by_hand = np.pi * np.sqrt(BALL.mass_kg / 2 / k) / 50
    assert time_step(of) == pytest.approx(by_hand)
    assert rebound_m(of) == pytest.approx(FALL_M, rel=1e-3)


def test_a_step_too_long_for_a_law_ends_the_run():
    """The control: ten times the law's own step, at which a contact lasts five."""
    of = world(k=1e7, thrust=0.0)
    slow = World(**{**vars(of), "time_step_s": 10 * time_step(of)})
    with pytest.raises(Stopped, match=r"energy is made: .* by step \d+ .* seed 0: "):
        rebound_m(slow)


def test_a_law_that_makes_energy_ends_the_run():
    """It pushes twice as hard while the bodies part: up comes twice of what went
    down."""
    thrusts = world(k=1e4, thrust=1.0)
    with pytest.raises(Stopped, match="seed 0: spring gives more than it") as told:
        rebound_m(thrusts)
    assert "\n" not in str(told.value)
    assert rebound_m(World(**{**vars(thrusts), "most_gain": 1e3})) > 0.19


def test_a_wall_that_throws_a_ball_is_no_gain():
    """The floor comes up at 1 m/s: the ball leaves it at 2 m/s more than it came."""
    lift = LAWS["motion_steady"].use(rate=1.0)
    thrown = world(k=1e4, thrust=0.0, lift=lift)
    assert rebound_m(thrown) > 2 * FALL_M


def test_no_built_in_law_shortens_the_step():
    """They attract, or only damp: the step is that of the balls."""
    for law in LAWS.values():
        if law.kind in ("normal", "body"):
            middle = {p.name: p.default or (p.low + p.high) / 2 for p in law.parameters}
            of = World(**{**vars(world(of=STIFF, k=0.0, thrust=0.0))})
            of = World(**{**vars(of), "laws": (law.use(**middle),)})
            assert min(longest_steps(of).values()) == longest_steps(of)[RAYLEIGH], law


def test_an_audit_is_due_often_and_costs_little():
    of = world(k=1e4, thrust=0.0)
    state = init(of, np.random.default_rng(1))
    audit = Audit(of, tables_of(of), state)
    assert audit.interval % 16 == 0 and 0 < audit.until_next(state) <= audit.interval
    assert audit.look(state) == ""
