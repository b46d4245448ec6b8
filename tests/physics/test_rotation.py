"""Free rotation of an asymmetric clump: what must be conserved, the order, and an
outside solution."""

import numpy as np
import pytest
from scenes import own
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from benchtwin.sim.engine.step import init, run
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.material import SOYBEAN
from benchtwin.sim.seed import Seed

SEED = Seed.from_spheres(
    [[0, 0, 0], [4e-3, 0, 0], [4e-3, 3e-3, 0], [0, 0, 1.5e-3]],
    [3e-3, 2e-3, 2.5e-3, 2.5e-3],
)
SPIN = np.array(
    [20.0, 300.0, 10.0]
)  # near the middle axis, about which rotation is unstable


def spun(dt, until):
    placed = Placed((SEED,), SOYBEAN, np.zeros((1, 3)), spins=SPIN[None])
    world = World((placed,), (), (own(SOYBEAN),), gravity=(0, 0, 0), time_step_s=dt)
    return run(world, init(world, np.random.default_rng(0)), until)


def exact(until):
    """Euler's equations and the quaternion, by another integrator."""
    i = np.asarray(SEED.inertia_kg_m2)

    def rates(t, y):
        w, q = y[:3], y[3:]
        dw = np.cross(i * w, w) / i
        a, b, c, d = q
        dq = 0.5 * np.array(
            [
                -b * w[0] - c * w[1] - d * w[2],
                a * w[0] + c * w[2] - d * w[1],
                a * w[1] - b * w[2] + d * w[0],
                a * w[2] + b * w[1] - c * w[0],
            ]
        )
        return np.concatenate([dw, dq])

    return solve_ivp(
        rates, (0, until), [*SPIN, 1, 0, 0, 0], rtol=1e-12, atol=1e-12, method="DOP853"
    ).y[:, -1]


def test_energy_and_angular_momentum_over_many_tumbles():
    """0.5 s, some 24 turns, with steps of a third of a degree: L to rounding, energy
    within its bounded oscillation, |q| = 1."""
    first, last = spun(2e-5, 0.0), spun(2e-5, 0.5)
    assert last.spin[0] == pytest.approx(first.spin[0], rel=1e-14)
    energy = [0.5 * s.motion[0, 6:9] @ s.spin[0] for s in (first, last)]
    assert energy[1] == pytest.approx(energy[0], rel=1e-5)
    assert np.linalg.norm(last.turn[0]) == pytest.approx(1.0, abs=1e-15)


def test_energy_does_not_drift():
    """The error after 1000 turns is no larger than after 10: the splitting is
    symplectic."""
    start = spun(1e-4, 0.0)
    e0 = 0.5 * start.motion[0, 6:9] @ start.spin[0]
    early, late = (
        max(
            abs(0.5 * s.motion[0, 6:9] @ s.spin[0] / e0 - 1)
            for s in map(lambda t: spun(1e-4, t), times)
        )
        for times in (np.linspace(0.1, 0.2, 9), np.linspace(20.0, 20.1, 9))
    )
    assert early < 1e-3
    assert late < 1.5 * early


def test_order_of_the_rotation():
    """Orientation against the outside solution: the error falls fourfold when the step
    is halved."""
    until = 0.04
    y = exact(until)
    truth = Rotation.from_quat(y[[4, 5, 6, 3]])
    errors = []
    for dt in (4e-5, 2e-5, 1e-5):
        q = spun(dt, until).turn[0]
        errors.append((truth.inv() * Rotation.from_quat(q[[1, 2, 3, 0]])).magnitude())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx([2, 2], abs=0.1)
    assert errors[-1] < 1e-3


def test_a_sphere_keeps_its_spin_and_turns_by_it():
    sphere = Seed.from_spheres([[0, 0, 0]], [3e-3])
    world = World(
        (Placed((sphere,), SOYBEAN, np.zeros((1, 3)), spins=SPIN[None]),),
        (),
        (own(SOYBEAN),),
        gravity=(0, 0, 0),
        time_step_s=1e-5,
    )
    state = run(world, init(world, np.random.default_rng(0)), 0.1)
    assert state.spins[0] == pytest.approx(SPIN, rel=1e-14)
    truth = Rotation.from_rotvec(SPIN * 0.1)
    assert (
        truth.inv() * Rotation.from_quat(state.turn[0][[1, 2, 3, 0]])
    ).magnitude() < 1e-7
