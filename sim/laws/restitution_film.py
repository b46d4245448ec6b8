"""Restitution of seeds with a liquid or sticky film that takes a fixed energy from
every impact."""

import math

from benchtwin.sim.laws.law import Law, Parameter


def restitution_film(impact_speed, e, film_speed):
    """e(v) = √(e² − (v_f/v)²), and 0.001 where that is less: slower than v_f/e the seed
    sticks.

    impact_speed v [m/s] ≥ 0; e [-] the dry restitution entered; film_speed v_f = √(2
    W/m) [m/s] for an energy W lost per impact of a mass m. Loss independent of speed: a
    film thin enough that its neck breaks before viscosity matters. Several balls of one
    seed that land together lose it together, as one impact. `film_adhesion` is the same
    loss as a force, which also holds a seed at rest.

    Source: energy balance; Davis, Serayssol, Hinch (1986), J. Fluid Mech. 163, 479–497,
    for when a wet impact sticks.

    >>> [round(restitution_film(v, 0.54, 0.1), 4) for v in (2.466, 0.3, 0.1)]
    [0.5385, 0.4248, 0.001]
    """
    loss = film_speed / max(impact_speed, 1e-12)
    return math.sqrt(max(e * e - loss * loss, 1e-6))


LAW = Law(
    name="restitution_film",
    kind="restitution",
    function=restitution_film,
    parameters=(
        Parameter(
            "film_speed", "m/s", 0.0, 10.0, "√(2 W/m) of the energy W lost per impact"
        ),
    ),
    source=(
        "energy balance; Davis, Serayssol, Hinch (1986), J. Fluid Mech. 163, 479–497"
    ),
)
