"""JKR cohesion: elastic surfaces that stick, to be added to Hertz's force."""

import math

from benchtwin.sim.laws.law import Law, Parameter


def cohesion_jkr(overlap, closing_speed, radius, modulus, work):
    """F = 4 E* a³/(3 R*) − √(8π w E* a³) − (4/3) E* √R* δ₊^1.5, with the contact radius
    a from δ = a²/R* − √(2π w a/E*).

    overlap δ [m] down to −(3/4) (π² w² R*/E*²)^⅓, where the neck snaps (see `reach`);
    closing_speed [m/s] unused; radius R* [m]; modulus E* [Pa]; work w [J/m2] of
    adhesion (twice the surface energy of equal solids). What is added is JKR less the
    Hertz force that every contact has. Strongest pull (3/2) π w R*, whatever E*; the
    area, and with it the overlap at rest, does depend on E*. Valid for soft, smooth
    solids, Tabor's R* w²/(E*² z³) ≫ 1 (z ≈ 0.3 nm).

    Source: Johnson, Kendall, Roberts (1971), Proc. R. Soc. Lond. A 324, 301–313.

    >>> strongest_pull = -1.5 * math.pi * 0.1 * 0.003
    >>> round(cohesion_jkr(0.0, 0.0, 0.003, 1e7, 0.1) / strongest_pull, 6)  # 8/9
    0.888889
    """
    if work <= 0.0:
        return 0.0
    # b = √a solves b⁴/R* − s b = δ. The left side is convex and the start lies above
    # the largest root: Newton descends to it, no farther than where the neck snaps, (R*
    # s/4)^⅓, at which the slope vanishes.
    s = math.sqrt(6.283185307179586 * work / modulus)
    neck = (radius * s) ** 0.3333333333333333
    b = (radius * max(overlap, 0.0)) ** 0.25 + neck
    for _ in range(20):
        slope = 4.0 * b * b * b / radius - s
        b = max(
            b - (b * b * b * b / radius - s * b - overlap) / max(slope, 1e-3 * s),
            0.6299605249474366 * neck,
        )
    a3 = b * b * b * b * b * b
    hertz = math.sqrt(radius * max(overlap, 0.0)) * max(overlap, 0.0)
    return 4.0 / 3.0 * modulus * (a3 / radius - hertz) - math.sqrt(
        25.132741228718345 * work * modulus * a3
    )


def reach(radius, modulus, work):
    """Gap at which the neck snaps, (3/4) (π² w² R*/E*²)^⅓ [m]."""
    return (
        0.75
        * (9.869604401089358 * work * work * radius / (modulus * modulus))
        ** 0.3333333333333333
    )


LAW = Law(
    name="cohesion_jkr",
    kind="normal",
    function=cohesion_jkr,
    reach=reach,
    parameters=(Parameter("work", "J/m2", 0.0, 1e3, "work of adhesion w"),),
    source="Johnson, Kendall, Roberts (1971), Proc. R. Soc. Lond. A 324, 301–313",
)
