"""Film adhesion: a neck of liquid or glue pulls with a constant force from first touch
until it is stretched to its end."""

from benchtwin.sim.laws.law import Law, Parameter


def film_adhesion(overlap, closing_speed, radius, modulus, pull, rupture):
    """F = −pull while the surfaces are no farther apart than `rupture`, else 0.

    overlap [m], negative while apart; closing_speed [m/s], radius [m], modulus [Pa]
    unused; pull [N] at each touching place; rupture [m] the neck's length when it
    breaks. Each impact loses W = pull · rupture, since the neck forms only at touch; a
    seed that leaves slower than √(2 W/m) comes back. A wetted ball has pull = 4π γ R*
    cos θ (source 1) and a neck of volume V breaks at (1 + θ/2) V^⅓ (source 2). Static:
    viscosity of the liquid left out (capillary number below 0.01).

    Sources: 1. Israelachvili (2011), Intermolecular and Surface Forces, section 17.9.
    2. Lian, Thornton, Adams (1993), J. Colloid Interface Sci. 161, 138–147.

    >>> film_adhesion(-1e-5, 0.0, 0.003, 1e8, 2e-3, 5e-5)
    -0.002
    >>> film_adhesion(-6e-5, 0.0, 0.003, 1e8, 2e-3, 5e-5)
    0.0
    """
    return -pull if overlap >= -rupture else 0.0


def reach(radius, modulus, pull, rupture):
    """The neck's length at rupture [m]."""
    return rupture


LAW = Law(
    name="film_adhesion",
    kind="normal",
    function=film_adhesion,
    reach=reach,
    parameters=(
        Parameter("pull", "N", 0.0, 10.0, "force of the film at each touching place"),
        Parameter("rupture", "m", 0.0, 1e-2, "gap at which the film breaks"),
    ),
    source="Israelachvili (2011), section 17.9; Lian, Thornton, Adams (1993)",
)
