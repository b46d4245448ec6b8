"""Linear spring and dashpot: stiffness and restitution alike at any overlap and
speed."""

import math

from benchtwin.sim.laws.law import Law, Parameter


def spring_linear(overlap, closing_speed, radius, modulus, e, stiffness):
    """F = k δ, beside a dashpot 2 ζ √(k m*), ζ = −ln e / √(ln² e + π²), which may pull
    at the end of contact: e = exp(−π ζ/√(1 − ζ²)).

    overlap δ [m] ≥ 0; closing_speed [m/s], radius [m], modulus [Pa] unused; e [-] the
    restitution entered; stiffness k [N/m] of every contact, whatever its size. A
    contact lasts π √(m*/k) / √(1 − ζ²). Valid for impacts; at rest the overlap is as
    deep as k says, and k is no property of a material. Take it for k of at least 100
    times a seed's greatest load over its radius.

    Source: Cundall, Strack (1979), Géotechnique 29, 47–65; Schwager, Pöschel (2007),
    Granular Matter 9, 465–469 (the pull at the end).

    >>> force, carried, k, damping = spring_linear(1e-5, 0.0, 0.003, 1e7, 0.5, 1e4)
    >>> round(force, 9), k, round(damping, 6)
    (0.1, 10000.0, 0.430908)
    """
    force = stiffness * max(overlap, 0.0)
    log = math.log(max(e, 1e-3))
    damping = -2.0 * log / math.sqrt(log * log + 9.869604401089358)
    return force, force, stiffness, damping


LAW = Law(
    name="spring_linear",
    kind="spring",
    function=spring_linear,
    parameters=(Parameter("stiffness", "N/m", 1e-3, 1e12, "of every contact"),),
    source="Cundall, Strack (1979), Géotechnique 29, 47–65",
)
