"""Viscous sliding: the coefficient of friction changes linearly with slip speed."""

from benchtwin.sim.laws.law import Law, Parameter


def friction_viscous(slip_speed, mu, slope):
    """μ(v) = max(μ + k v, 0).

    slip_speed v [m/s] ≥ 0; mu [-] the coefficient entered, which holds at rest; slope k
    [s/m]. An expansion to first order: for the speeds at which k was measured.

    Source: Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), Automatica 30, 1083–1138,
    section 2.1 (the viscous term).

    >>> round(friction_viscous(0.5, 0.34, 0.1), 9)
    0.39
    """
    return max(mu + slope * slip_speed, 0.0)


LAW = Law(
    name="friction_viscous",
    kind="friction",
    function=friction_viscous,
    parameters=(
        Parameter(
            "slope", "s/m", -10.0, 10.0, "change of the coefficient with slip speed"
        ),
    ),
    source=(
        "Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), Automatica 30, 1083–1138"
    ),
)
