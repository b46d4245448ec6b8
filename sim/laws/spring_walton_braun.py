"""Walton and Braun's hysteretic spring: soft while it is pressed deeper than ever
before, stiffer while it gives way."""

from benchtwin.sim.laws.law import Law, Parameter


def spring_walton_braun(
    overlap, closing_speed, radius, modulus, e, greatest, stiffness
):
    """F = min(k_1 δ, k_2 (δ − δ_0)), at least 0, with k_2 = k_1/e², δ_0 = (1 − e²) δ*;
    no dashpot: e comes out at any speed.

    overlap δ [m]; closing_speed [m/s], radius [m], modulus [Pa] unused; e [-] the
    restitution entered; greatest δ* [m] overlap of this contact so far, forgotten when
    it ends; stiffness k_1 [N/m] of first loading. Unloaded and loaded again the force
    goes along k_2 to where it was, then on along k_1. Valid for spheres that yield as
    Walton and Braun's computed ones did, with a k_1 that fits their loads.

    Source: Walton, Braun (1986), J. Rheol. 30, 949–980.

    >>> pressed = spring_walton_braun(1e-5, 0.0, 0.003, 1e7, 0.5, 0.0, 1e4)
    >>> given_way = spring_walton_braun(9e-6, 0.0, 0.003, 1e7, 0.5, 1e-5, 1e4)
    >>> round(pressed[0], 9), round(given_way[0], 9), given_way[4]
    (0.1, 0.06, 1e-05)
    """
    deepest = max(greatest, overlap, 0.0)
    back = stiffness / (e * e) * (overlap - (1.0 - e * e) * deepest)
    force = max(min(stiffness * overlap, back), 0.0)
    return force, force, stiffness, 0.0, deepest


LAW = Law(
    name="spring_walton_braun",
    kind="spring",
    function=spring_walton_braun,
    parameters=(Parameter("stiffness", "N/m", 1e-3, 1e12, "of first loading, k_1"),),
    memory=(Parameter("greatest", "m", 0.0, 1e-3, "greatest overlap of the contact"),),
    source="Walton, Braun (1986), J. Rheol. 30, 949–980",
)
