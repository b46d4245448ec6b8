"""JKR: elastic surfaces that stick, from touch until the neck between them snaps."""

import math

from benchtwin.sim.laws.law import Law, Parameter


def spring_jkr(overlap, closing_speed, radius, modulus, e, work):
    """F = 4 E* a³/(3 R*) − √(8π w E* a³), with the contact radius a from δ = a²/R* −
    √(2π w a/E*); stiffness S = 2 E* a, damping γ(e) of Hertz's spring.

    overlap δ [m] down to −(3/4) (π² w² R*/E*²)^⅓, where the neck snaps (see `reach`):
    there is none before touch, so that an impact costs 7.09 (w⁵ R*⁴/E*²)^⅓ (source 2).
    closing_speed [m/s] unused; radius R* [m]; modulus E* [Pa]; e [-]; work w [J/m2] of
    adhesion (twice the surface energy of equal solids). Strongest pull P = (3/2) π w
    R*, whatever E*; the area, and with it the overlap at rest, does depend on E*.
    Friction is capped by F + 2 P (source 3). Valid for soft, smooth solids, Tabor's R*
    w²/(E*² z³) ≫ 1 (z ≈ 0.3 nm).

    Sources: 1. Johnson, Kendall, Roberts (1971), Proc. R. Soc. Lond. A 324, 301–313. 2.
    Thornton, Ning (1998), Powder Technol. 99, 154–162. 3. Thornton (1991), J. Phys. D
    24, 1942–1946.

    >>> strongest_pull = -1.5 * math.pi * 0.1 * 0.003
    >>> round(spring_jkr(0.0, 0.0, 0.003, 1e7, 1.0, 0.1)[0] / strongest_pull, 6)  # 8/9
    0.888889
    """
    # b = √a solves b⁴/R* − s b = δ. The left side is convex and the start lies above
    # the largest root: Newton descends to it, no farther than where the neck snaps, (R*
    # s/4)^⅓, at which the slope vanishes.
    s = math.sqrt(6.283185307179586 * work / modulus)
    neck = (radius * s) ** 0.3333333333333333
    b = (radius * max(overlap, 0.0)) ** 0.25 + neck
    for _ in range(20):
        slope = 4.0 * b * b * b / radius - s
        b = max(
            b
            - (b * b * b * b / radius - s * b - overlap) / max(slope, 1e-3 * s, 1e-30),
            0.6299605249474366 * neck,
        )
    a = b * b
    force = 4.0 / 3.0 * modulus * a * a * a / radius - math.sqrt(
        25.132741228718345 * work * modulus * a * a * a
    )
    log = math.log(max(e, 1e-3))
    damping = -1.8257418583505538 * log / math.sqrt(log * log + 9.869604401089358)
    return force, force + 9.42477796076938 * work * radius, 2.0 * modulus * a, damping


def reach(radius, modulus, work):
    """Gap at which the neck snaps, (3/4) (π² w² R*/E*²)^⅓ [m]."""
    return (
        0.75
        * (9.869604401089358 * work * work * radius / (modulus * modulus))
        ** 0.3333333333333333
    )


LAW = Law(
    name="spring_jkr",
    kind="spring",
    function=spring_jkr,
    reach=reach,
    parameters=(Parameter("work", "J/m2", 0.0, 1e3, "work of adhesion w"),),
    source=(
        "Johnson, Kendall, Roberts (1971), Proc. R. Soc. Lond. A 324, 301–313;"
        " Thornton, Ning (1998), Powder Technol. 99, 154–162"
    ),
)
