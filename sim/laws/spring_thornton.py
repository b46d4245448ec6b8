"""Thornton's elastic–plastic spheres: Hertz's until they yield, then a pressure that
does not grow, and Hertz's again from a dent."""

import math

from benchtwin.sim.laws.law import Law, Parameter


def spring_thornton(
    overlap, closing_speed, radius, modulus, e, greatest, yield_pressure
):
    """F = (4/3) E* √R* δ^1.5 up to a_y = π R* p_y/(2 E*), F = F_y + π p_y R* (δ − δ_y)
    beyond it, and F = F* [(δ − δ_p)/(δ* − δ_p)]^1.5 on the way back, δ* − δ_p = 3
    F*/(4 E* √(R* δ*)); stiffness S = 2 E* a.

    overlap δ [m]; closing_speed [m/s] and e [-] unused: what an impact loses is the
    dent, e = 1 below yield and 1.185 (v_y/v)^¼ far above it; radius R* [m]; modulus E*
    [Pa]; greatest δ* [m] overlap of this contact so far, F* the force at it; δ_y =
    a_y²/R*, F_y = (2/3) π p_y a_y²; yield_pressure p_y [Pa], 1.6 times the yield
    strength of a ductile solid, softened with its modulus. A contact that ends is
    forgotten: each impact meets an undented spot. Valid for contacts small beside the
    spheres, a below 0.1 R*.

    Sources: 1. Thornton (1997), J. Appl. Mech. 64, 383–386. 2. Thornton, Ning (1998),
    Powder Technol. 99, 154–162.

    >>> pressed = spring_thornton(1e-5, 0.0, 0.003, 1e8, 1.0, 0.0, 1e6)
    >>> given_way = spring_thornton(8e-6, 0.0, 0.003, 1e8, 1.0, 1e-5, 1e6)
    >>> round(pressed[0], 6), round(given_way[0], 6)
    (0.091922, 0.032259)
    """
    deepest = max(greatest, overlap, 0.0)
    yielding = 1.5707963267948966 * yield_pressure / modulus  # a_y / R*
    at_yield = radius * yielding * yielding
    widest = math.sqrt(radius * deepest)
    strongest = 4.0 / 3.0 * modulus * widest * deepest
    if deepest > at_yield:
        strongest = (
            3.141592653589793 * yield_pressure * radius * (deepest - at_yield / 3.0)
        )
    springs_back = max(0.75 * strongest / max(modulus * widest, 1e-300), 1e-300)
    x = max(1.0 - (deepest - overlap) / springs_back, 0.0)
    force = strongest * x * math.sqrt(x)
    return force, force, 2.0 * modulus * widest * math.sqrt(x), 0.0, deepest


LAW = Law(
    name="spring_thornton",
    kind="spring",
    function=spring_thornton,
    parameters=(
        Parameter("yield_pressure", "Pa", 1.0, 1e12, "contact pressure at yield, p_y"),
    ),
    memory=(Parameter("greatest", "m", 0.0, 1e-3, "greatest overlap of the contact"),),
    source=(
        "Thornton (1997), J. Appl. Mech. 64, 383–386; Thornton, Ning (1998), Powder"
        " Technol. 99, 154–162"
    ),
)
