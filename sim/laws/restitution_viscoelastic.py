"""Restitution that falls with impact speed because the solids are viscous."""

from benchtwin.sim.laws.law import Law, Parameter


def restitution_viscoelastic(impact_speed, e, viscosity, anchor_speed):
    """e(v) = e · P(k v^0.1) / P(k v_a^0.1), at most 1.

    P(x) = (1 + .501086 x)/(1 + .501086 x + 1.15345 x² + .577977 x³ + .532178 x⁴).

    impact_speed v [m/s] ≥ 0; e [-] the restitution entered, which holds at anchor_speed
    v_a [m/s]; v_a = 0: at vanishing speed, where P = 1. With e = 1 and v_a = 0 this is
    the exact law of viscoelastic spheres, P = 1 − 1.15345 k² v^⅕ + 0.79827 k⁴ v^⅖ ∓ …
    viscosity k [(s/m)^0.1] = √β, β = (3/2) A (4 E* √R*/3 m*)^⅖, A [s] the material's
    dissipative time: k falls with size as d^-0.2. Within 0.006 of the equation of
    motion for k v^0.1 < 1.1; valid for impacts that flatten little and do not yield.

    Sources: 1. Schwager, Pöschel (2008), Phys. Rev. E 78, 051304. 2. Müller, Pöschel
    (2011), Phys. Rev. E 84, 021302 (Padé form).

    >>> speeds = (0.5, 2.466, 5.0)
    >>> [round(restitution_viscoelastic(v, 0.54, 0.8, 2.466), 4) for v in speeds]
    [0.6438, 0.54, 0.4933]
    """
    x = viscosity * impact_speed**0.1
    y = viscosity * anchor_speed**0.1
    here = (1.0 + 0.501086 * x) / (
        1.0 + x * (0.501086 + x * (1.15345 + x * (0.577977 + x * 0.532178)))
    )
    there = (1.0 + 0.501086 * y) / (
        1.0 + y * (0.501086 + y * (1.15345 + y * (0.577977 + y * 0.532178)))
    )
    return min(e * here / there, 1.0)


LAW = Law(
    name="restitution_viscoelastic",
    kind="restitution",
    function=restitution_viscoelastic,
    parameters=(
        Parameter(
            "viscosity",
            "(s/m)^0.1",
            0.0,
            10.0,
            "k = √β: how strongly e falls with speed",
        ),
        Parameter(
            "anchor_speed",
            "m/s",
            0.0,
            100.0,
            "impact speed at which e is as entered",
            0.0,
        ),
    ),
    source=(
        "Schwager, Pöschel (2008), Phys. Rev. E 78, 051304; Müller, Pöschel (2011),"
        " Phys. Rev. E 84, 021302"
    ),
)
