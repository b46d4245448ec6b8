"""Liquid bridge: a neck of liquid between wet grains pulls from first touch until it
is stretched to its end."""

import math

from benchtwin.sim.laws.law import Law, Parameter


def liquid_bridge(
    overlap, closing_speed, radius, modulus, surface_tension, angle_deg, volume
):
    """F = −4π R* γ cos θ / (1 + 1.05 s + 2.5 s²), s = S √(2 R*/V), while the gap S is
    no longer than `reach`, else 0; in touch S = 0.

    overlap [m], negative while apart (the gap S); closing_speed [m/s] and modulus [Pa]
    unused; radius R* [m], half a ball's between equal balls (source 1 has R = 2 R*);
    surface_tension γ [N/m]; angle_deg θ of contact; volume V [m3] of each neck, alike
    for all. The bridge forms at first touch and its liquid stays. Static: viscosity
    left out (capillary number below 0.01); not for large bridges (V above some
    0.001 R³), whose pull in touch is less than this, nor for θ above 50°. Source 1
    writes half the gap: 2.1 and 10 in the place of 1.05 and 2.5.

    Sources: 1. Willett, Adams, Johnson, Seville (2000), Langmuir 16, 9396–9405, Eq. 12.
    2. Lian, Thornton, Adams (1993), J. Colloid Interface Sci. 161, 138–147.

    >>> touching = liquid_bridge(0.0, 0.0, 0.002, 1e8, 0.072, 0.0, 1e-10)
    >>> round(touching / (4 * math.pi * 0.002 * 0.072), 12)
    -1.0
    """
    gap = max(-overlap, 0.0)
    theta = math.radians(angle_deg)
    end = (1.0 + 0.5 * theta) * volume**0.3333333333333333
    if gap > end or volume <= 0.0:
        return 0.0
    s = gap * math.sqrt(2.0 * radius / volume)
    strongest = 12.566370614359172 * radius * surface_tension * math.cos(theta)
    return -strongest / (1.0 + 1.05 * s + 2.5 * s * s)


def reach(radius, modulus, surface_tension, angle_deg, volume):
    """The neck's length when it breaks, (1 + θ/2) V^⅓ [m] (source 2)."""
    return (1.0 + 0.5 * math.radians(angle_deg)) * volume**0.3333333333333333


LAW = Law(
    name="liquid_bridge",
    kind="normal",
    function=liquid_bridge,
    reach=reach,
    parameters=(
        Parameter("surface_tension", "N/m", 0.0, 1.0, "of the liquid", 0.072),
        Parameter("angle_deg", "deg", 0.0, 89.0, "of contact of the liquid", 0.0),
        Parameter("volume", "m3", 0.0, 1e-6, "of liquid in each neck"),
    ),
    source="Willett et al. (2000), Eq. 12; Lian, Thornton, Adams (1993)",
)
