"""Viscous rolling: a resistance that grows with rolling speed, on top of the chosen
rolling friction."""

from benchtwin.sim.laws.law import Law, Parameter


def rolling_viscous(normal_force, rolling_speed, radius, mu_r, slope):
    """Torque τ = k (ω_r R*) F_n R*: as if μ_r (R* convention) grew by k times the
    rolling speed ω_r R*.

    normal_force F_n [N] ≥ 0; rolling_speed ω_r [rad/s] ≥ 0 of one body on the other;
    radius R* [m]; mu_r [-] unused (the constant part is another law's); slope k [s/m].
    On a wall ω_r R* is the speed of the ball's centre. Linear: for the speeds at which
    k was measured.

    Source: Brilliantov, Pöschel (1998), Europhys. Lett. 42, 511–516 (rolling of
    viscoelastic balls, μ_r ∝ v).

    >>> round(1e6 * rolling_viscous(2.0, 100.0, 0.003, 0.01, 0.05), 6)
    90.0
    """
    return slope * rolling_speed * radius * normal_force * radius


LAW = Law(
    name="rolling_viscous",
    kind="rolling_relative",
    function=rolling_viscous,
    parameters=(
        Parameter("slope", "s/m", 0.0, 10.0, "growth of μ_r with rolling speed"),
    ),
    source="Brilliantov, Pöschel (1998), Europhys. Lett. 42, 511–516",
)
