"""Stribeck friction: the coefficient falls smoothly with slip speed."""

import math

from benchtwin.sim.laws.law import Law, Parameter


def friction_stribeck(slip_speed, mu, drop, stribeck_speed):
    """μ(v) = max(μ − drop (1 − exp(−v/v_s)), 0).

    slip_speed v [m/s] ≥ 0; mu [-] the coefficient entered, which holds at rest; drop
    [-] coefficient at rest less at high speed; stribeck_speed v_s [m/s] over which it
    falls. Memoryless: for slip that changes slowly against the contact's own vibration.

    Source: Bo, Pavelescu (1982), Wear 82, 277–289, with exponent 1.

    >>> friction_stribeck(0.0, 0.5, 0.2, 0.05)
    0.5
    >>> round(friction_stribeck(0.05, 0.5, 0.2, 0.05), 6)
    0.373576
    """
    return max(mu - drop * (1.0 - math.exp(-slip_speed / stribeck_speed)), 0.0)


LAW = Law(
    name="friction_stribeck",
    kind="friction",
    function=friction_stribeck,
    parameters=(
        Parameter("drop", "-", -2.0, 5.0, "coefficient at rest less at high speed"),
        Parameter(
            "stribeck_speed",
            "m/s",
            1e-6,
            100.0,
            "slip speed over which the coefficient falls",
        ),
    ),
    source="Bo, Pavelescu (1982), Wear 82, 277–289",
)
