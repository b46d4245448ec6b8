"""Kinetic friction below static friction: once a contact slides, it holds less."""

import math

from benchtwin.sim.laws.law import Law, Parameter


def friction_kinetic(slip_speed, mu, drop, settle_speed):
    """μ(v) = μ_k + (μ − μ_k) exp(−(v/v_0)²), μ_k = max(μ − drop, 0).

    slip_speed v [m/s] ≥ 0; mu [-] the static coefficient entered; drop [-] static less
    kinetic; settle_speed v_0 [m/s], above which the contact counts as sliding: a step
    in μ made smooth. Take it well below the speeds of interest and above the tremble of
    a contact at rest (1 mm/s for seeds). Rate and state effects (μ growing with time of
    rest) are left out.

    Source: Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), Automatica 30, 1083–1138,
    eq. (2) with δ_s = 2.

    >>> friction_kinetic(0.0, 0.5, 0.2, 1e-3)
    0.5
    >>> round(friction_kinetic(0.1, 0.5, 0.2, 1e-3), 12)
    0.3
    """
    kinetic = max(mu - drop, 0.0)
    x = slip_speed / settle_speed
    return kinetic + (mu - kinetic) * math.exp(-x * x)


LAW = Law(
    name="friction_kinetic",
    kind="friction",
    function=friction_kinetic,
    parameters=(
        Parameter("drop", "-", -2.0, 5.0, "static less kinetic coefficient"),
        Parameter(
            "settle_speed",
            "m/s",
            1e-6,
            1.0,
            "slip speed above which a contact slides",
            1e-3,
        ),
    ),
    source=(
        "Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), Automatica 30, 1083–1138"
    ),
)
