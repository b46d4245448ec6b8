"""EDEM's standard rolling friction: a constant torque against each body's own spin."""

from sim.laws.law import Law


def rolling_edem(normal_force, spin_speed, arm, mu_r):
    """Torque τ_i = μ_r F_n R_i, which the engine applies along −ω̂_i.

    normal_force [N] (Hertz's, ≥ 0), spin_speed [rad/s] (> 0; unused, the torque does not depend on it), arm [m] the
    distance R_i from the body's centre to the contact, mu_r [-]. Valid for dry rolling at any speed; between two bodies it is not
    an equal and opposite pair, and a body at rest on a slope below atan μ_r trembles by one step's worth of spin.

    For two equal spheres the same μ_r brakes twice as hard as in the R* conventions (type A and C); at a wall they agree.

    Source: EDEM user guide, "Standard Rolling Friction"; Sakaguchi, Ozaki, Igarashi (1993).

    >>> rolling_edem(2.0, 5.0, 0.003, 0.01)
    6e-05
    """
    return mu_r * normal_force * arm


LAW = Law(
    name="rolling_edem",
    kind="rolling_spin",
    function=rolling_edem,
    source="EDEM user guide, Standard Rolling Friction; Sakaguchi et al. (1993)",
)
