"""One ball or clump on a slope or a floor, against closed forms."""

import math

import numpy as np
import pytest
from scenes import ball, flat_clump, go, on_floor

from benchtwin.sim.material import Q235, SOYBEAN

G, R = 9.81, 3e-3
SEED = ball(R, 1250.0)
EASE = {"rayleigh_fraction": 0.2}


def at_rest_height(seed, slope=0.0):
    """Overlap under the seed's own weight on the floor, so that it starts in
    balance."""
    from benchtwin.sim.material import effective_moduli

    modulus, _ = effective_moduli(SOYBEAN, Q235)
    touching = np.isclose(
        seed.centres_m[:, 2] - seed.radii_m, (seed.centres_m[:, 2] - seed.radii_m).min()
    ).sum()
    weight = seed.mass_kg * G * math.cos(slope) / touching
    radius = float(seed.radii_m[0])
    return float((seed.radii_m - seed.centres_m[:, 2]).max()) - (
        0.75 * weight / (modulus * math.sqrt(radius))
    ) ** (2 / 3)


def on_slope(
    seed, angle_deg, mu, mu_r=0.0, until=0.1, velocity=(0, 0, 0), spin=(0, 0, 0), e=0.5
):
    """The slope is level here and gravity tilted, downhill along x."""
    a = math.radians(angle_deg)
    world = on_floor(
        seed,
        SOYBEAN,
        e=e,
        mu=mu,
        mu_r=mu_r,
        floor=Q235,
        positions=[[0, 0, at_rest_height(seed, a)]],
        velocities=[velocity],
        spins=[spin],
        gravity=(G * math.sin(a), 0, -G * math.cos(a)),
        **EASE,
    )
    return go(world, until)


@pytest.mark.parametrize(
    ("angle", "mu_r"), [(5, 0.0), (15, 0.01), (15, 0.1), (30, 0.04)]
)
def test_rolling_down_a_slope(angle, mu_r):
    """v = (5/7) g (sin β − μ_r cos β) t."""
    a, t = math.radians(angle), 0.1
    state = on_slope(SEED, angle, 1.0, mu_r, t)
    assert state.velocities[0, 0] == pytest.approx(
        5 / 7 * G * (math.sin(a) - mu_r * math.cos(a)) * t, rel=2e-3
    )
    assert state.spins[0, 1] * R == pytest.approx(state.velocities[0, 0], rel=1e-3)


def test_a_steep_enough_resistance_holds_a_ball():
    """μ_r ≥ tan β: once the contact's springs are at rest, it does not turn at all."""
    early, late = (on_slope(SEED, 5.0, 1.0, 0.1, t) for t in (0.2, 0.4))
    assert abs(early.positions[0, 0]) < 1e-3 * R
    assert abs(late.positions[0, 0] - early.positions[0, 0]) < 1e-9 * R
    assert np.abs(late.spins).max() < 1e-9


def test_rolling_on_a_floor_slows_down():
    """At (5/7) μ_r g."""
    v, mu_r, t = 0.3, 0.02, 0.2
    state = on_slope(SEED, 0.0, 0.5, mu_r, t, velocity=(v, 0, 0), spin=(0, v / R, 0))
    assert state.velocities[0, 0] == pytest.approx(v - 5 / 7 * mu_r * G * t, rel=1e-3)


def test_sliding_becomes_rolling():
    """At 5/7 of the speed, after 2 u / (7 μ g)."""
    u, mu = 0.5, 0.2
    half = u / (7 * mu * G)
    state = on_slope(SEED, 0.0, mu, 0.0, half, velocity=(u, 0, 0))
    assert state.velocities[0, 0] == pytest.approx(u - mu * G * half, rel=2e-3)
    state = on_slope(SEED, 0.0, mu, 0.0, 3 * half, velocity=(u, 0, 0))
    assert state.velocities[0, 0] == pytest.approx(5 / 7 * u, rel=2e-3)
    assert state.spins[0, 1] * R == pytest.approx(5 / 7 * u, rel=2e-3)


@pytest.mark.parametrize(("slope", "mu_r"), [(15.0, 0.05), (10.0, 0.03)])
def test_run_out(slope, mu_r):
    """Pure rolling down S and out on a level floor: μ_r = S sin β / (S cos β + L). Here
    the floor's part: from the speed at the foot."""
    s, b = 0.01, math.radians(slope)
    v = math.sqrt(2 * 5 / 7 * G * s * (math.sin(b) - mu_r * math.cos(b)))
    way = s * math.sin(b) / mu_r - s * math.cos(b)
    time = v / (5 / 7 * mu_r * G)
    state = on_slope(
        SEED, 0.0, 0.5, mu_r, 1.2 * time, velocity=(v, 0, 0), spin=(0, v / R, 0)
    )
    assert state.positions[0, 0] == pytest.approx(way, rel=3e-3)
    assert abs(state.velocities[0, 0]) < 1e-4


@pytest.mark.parametrize(
    ("mu", "angle"),
    [
        (0.2, 5),
        (0.2, 11),
        (0.2, 12),
        (0.34, 18),
        (0.34, 19.5),
        (0.5, 26),
        (0.5, 27),
        (0.8, 38),
        (0.8, 39.5),
    ],
)
def test_ramp_grid(mu, angle):
    """A flat clump across the slope stays below atan μ and slides above, at g (sin θ −
    μ cos θ)."""
    a, t, seed = math.radians(angle), 0.05, flat_clump(R, 1250.0, 5, 0.8)
    early, late = (
        on_slope(seed, angle, mu, 0.0, t).velocities[0, 0] for t in (t, 2 * t)
    )  # less the jerk of letting go
    expected = max(0.0, G * (math.sin(a) - mu * math.cos(a)))
    assert (late - early) / t == pytest.approx(expected, rel=5e-3, abs=1e-3)


def test_stopping_distance():
    """v² / (2 μ g) for a clump that cannot roll."""
    v, mu = 0.3, 0.4
    state = on_slope(
        flat_clump(R, 1250.0, 5, 0.8),
        0.0,
        mu,
        0.0,
        1.3 * v / (mu * G),
        velocity=(v, 0, 0),
    )
    assert state.positions[0, 0] == pytest.approx(v * v / (2 * mu * G), rel=3e-3)
    assert np.abs(state.velocities).max() < 1e-4
