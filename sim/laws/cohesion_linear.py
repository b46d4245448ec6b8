"""Linear cohesion: a pull in proportion to the contact's area."""

from benchtwin.sim.laws.law import Law, Parameter


def cohesion_linear(overlap, closing_speed, radius, modulus, energy_density):
    """F = −κ π R* δ, the Hertzian contact area π a² (a² = R* δ) times the cohesion
    energy density κ.

    overlap δ [m]; closing_speed [m/s], modulus [Pa] unused; radius R* [m];
    energy_density κ [J/m3]. Nothing at or before touch, so it takes no energy by itself
    and depends on the softness chosen: κ belongs to its shear modulus. Programs that
    take the area of the circle in which two balls cross (2π R* δ) need half this κ.

    Source: EDEM user guide, "Linear Cohesion".

    >>> round(cohesion_linear(1e-6, 0.0, 0.003, 1e8, 1e5), 9)
    -0.000942478
    """
    return -energy_density * 3.141592653589793 * radius * max(overlap, 0.0)


LAW = Law(
    name="cohesion_linear",
    kind="normal",
    function=cohesion_linear,
    parameters=(
        Parameter("energy_density", "J/m3", 0.0, 1e9, "cohesion energy density κ"),
    ),
    source="EDEM user guide, Linear Cohesion",
)
