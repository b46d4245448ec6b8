"""EDEM's standard rolling friction: a torque of constant size against each body's own
spin, which holds a body at rest."""

from benchtwin.sim.laws.law import Law


def rolling_edem(normal_force, spin_speed, arm, mu_r):
    """Torque τ_i = μ_r F_n R_i: along −ω̂_i while the body spins, and at most that,
    whatever is needed, while it does not.

    normal_force [N] (Hertz's, ≥ 0), spin_speed [rad/s] (> 0; unused, the torque does
    not depend on it), arm [m] the distance R_i from the body's centre to the contact,
    mu_r [-]. Valid for dry rolling at any speed; between two bodies it is not an equal
    and opposite pair. A body at rest on a slope below atan μ_r stays at rest
    (`sim.engine.turning.braked`), the limit that codes which apply the torque with its
    full size in every step come to as their step goes to zero; with usual steps a body
    at rest turns to and fro there, and heaps creep.

    For two equal spheres the same μ_r brakes twice as hard as in the R* conventions
    (type A and C); at a wall they agree.

    Source: EDEM user guide, "Standard Rolling Friction"; Sakaguchi, Ozaki, Igarashi
    (1993).

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
