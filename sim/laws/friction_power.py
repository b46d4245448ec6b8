"""Sliding friction with a power of slip speed beside the coefficient at rest."""

from benchtwin.sim.laws.law import Law, Parameter


def friction_power(slip_speed, mu, size, speed, power):
    """μ(v) = max(μ + A (v/v_0)^p, 0).

    slip_speed v [m/s] ≥ 0; mu [-] the coefficient entered; size A [-], what is added at
    speed v_0 [m/s], < 0: less; power p [-]; where p < 0 it is constant below v_0/20.
    Valid for the speeds at which it was measured.

    Source: a law of regression; p = 1 is the viscous term of Armstrong-Hélouvry,
    Dupont, Canudas de Wit (1994), Automatica 30, 1083–1138.

    >>> round(friction_power(0.2, 0.34, 0.05, 0.1, 3.0), 9)
    0.74
    """
    over = slip_speed / speed
    if power < 0.0:
        over = max(over, 0.05)
    return max(mu + size * over**power, 0.0)


LAW = Law(
    name="friction_power",
    kind="friction",
    function=friction_power,
    parameters=(
        Parameter("size", "-", -5.0, 5.0, "what is added to μ at that speed"),
        Parameter("speed", "m/s", 1e-3, 100.0, "slip speed at which it is added"),
        Parameter("power", "-", -4.0, 6.0, "power of the slip speed"),
    ),
    source="a law of regression",
)
