"""DMT cohesion: hard surfaces that stick where they touch."""

from benchtwin.sim.laws.law import Law, Parameter


def cohesion_dmt(overlap, closing_speed, radius, modulus, work):
    """F = −2π w R* while the surfaces touch, beside Hertz's force.

    overlap [m], closing_speed [m/s] and modulus [Pa] unused; radius R* [m]; work w
    [J/m2] of adhesion (twice the surface energy of equal solids). The strongest pull,
    2π w R*, is at the edge of contact; nothing acts across a gap, so an impact costs
    nothing by itself. Friction is capped by Hertz's force, the load and the pull
    together. Valid for hard, small solids, Tabor's R* w²/(E*² z³) ≪ 1 (z ≈ 0.3 nm).

    Source: Derjaguin, Muller, Toporov (1975), J. Colloid Interface Sci. 53, 314–326.

    >>> round(cohesion_dmt(1e-6, 0.0, 0.003, 1e9, 0.1), 9)
    -0.001884956
    """
    return -6.283185307179586 * work * radius


LAW = Law(
    name="cohesion_dmt",
    kind="normal",
    function=cohesion_dmt,
    parameters=(Parameter("work", "J/m2", 0.0, 1e3, "work of adhesion w"),),
    source=("Derjaguin, Muller, Toporov (1975), J. Colloid Interface Sci. 53, 314–326"),
)
