"""Restitution that changes with a power of impact speed."""

import math

from benchtwin.sim.laws.law import Law, Parameter


def restitution_power(impact_speed, e, slope, speed, power):
    """e(v) = e + k ((v/v_0)^p − 1)/p, e + k ln(v/v_0) for p = 0; between 0.001 and 1.

    impact_speed v [m/s] ≥ 0, taken as v_0/20 below that; e [-] the restitution entered,
    which holds at speed v_0 [m/s]; slope k = de/d ln v [-] there; power p [-]. Valid
    for the speeds at which it was measured.

    Source: a law of regression; Box, Cox (1964), J. R. Stat. Soc. B 26, 211–243, for
    the form that is continuous in p.

    >>> [round(restitution_power(v, 0.5, -0.05, 1.0, 2.0), 4) for v in (0.5, 1.0, 2.0)]
    [0.5188, 0.5, 0.425]
    >>> round(restitution_power(2.0, 0.5, -0.05, 1.0, 0.0), 4)
    0.4653
    """
    over = max(impact_speed / speed, 0.05)
    if abs(power) < 1e-9:
        risen = math.log(over)
    else:
        risen = (over**power - 1.0) / power
    return min(max(e + slope * risen, 1e-3), 1.0)


LAW = Law(
    name="restitution_power",
    kind="restitution",
    function=restitution_power,
    parameters=(
        Parameter("slope", "-", -5.0, 5.0, "growth of e with ln v at that speed"),
        Parameter("speed", "m/s", 1e-3, 100.0, "impact speed at which e is as entered"),
        Parameter("power", "-", -4.0, 6.0, "power of the impact speed"),
    ),
    source="Box, Cox (1964), J. R. Stat. Soc. B 26, 211–243, for the form",
)
