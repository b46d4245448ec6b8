"""Magnus lift: air pushes a spinning seed sideways."""

from benchtwin.sim.laws.law import Law, Parameter


def magnus(vx, vy, vz, wx, wy, wz, diameter, air_density, lift):
    """F = C (ρ A r/2) ω × v, with A = π d²/4 and r = d/2.

    v [m/s] against still air; w = ω [rad/s]; diameter d [m] of the sphere of equal
    volume; air_density ρ [kg/m3]; lift C [-]: 2 for a smooth sphere at Re ≪ 1 (source
    1), 0.2 to 1 measured for Re of hundreds to thousands and rω/v < 1 (source 2), where
    C may even change sign. Linear in rω/v; not for rω > 5 v.

    Sources: 1. Rubinow, Keller (1961), J. Fluid Mech. 11, 447–459. 2. Oesterlé, Bui
    Dinh (1998), Exp. Fluids 25, 16–22.

    >>> force = magnus(0, 0, -2.0, 0, 100.0, 0, 0.007, 1.204, 1.0)[:3]
    >>> [round(1e6 * f, 2) for f in force]
    [-16.22, 0.0, 0.0]
    """
    k = lift * air_density * 0.19634954084936207 * diameter * diameter * diameter
    return (
        k * (wy * vz - wz * vy),
        k * (wz * vx - wx * vz),
        k * (wx * vy - wy * vx),
        0.0,
        0.0,
        0.0,
    )


LAW = Law(
    name="magnus",
    kind="body",
    function=magnus,
    parameters=(
        Parameter("air_density", "kg/m3", 0.0, 2000.0, "density of the air", 1.204),
        Parameter("lift", "-", -5.0, 5.0, "C in F = C (ρ A r/2) ω × v"),
    ),
    source="Rubinow, Keller (1961); Oesterlé, Bui Dinh (1998)",
)
