"""Rolling friction with a power of rolling speed beside the chosen constant part."""

from benchtwin.sim.laws.law import Law, Parameter


def rolling_power(normal_force, rolling_speed, radius, mu_r, size, speed, power):
    """Torque τ = [max(μ_r + A (v/v_0)^p, 0) − μ_r] F_n R*, v = ω_r R*.

    normal_force F_n [N] ≥ 0; rolling_speed ω_r [rad/s] ≥ 0 of one body on the other;
    radius R* [m]; mu_r [-] the constant part, which another law makes; size A [-], what
    is added at speed v_0 [m/s], < 0: less; power p [-]; where p < 0 it is constant
    below v_0/20. Valid for the speeds at which it was measured.

    Source: a law of regression; of viscoelastic balls p = 1: Brilliantov, Pöschel
    (1998), Europhys. Lett. 42, 511–516.

    >>> round(1e6 * rolling_power(2.0, 100.0, 0.003, 0.01, 0.05, 0.1, 2.0), 6)
    2700.0
    """
    over = rolling_speed * radius / speed
    if power < 0.0:
        over = max(over, 0.05)
    return (max(mu_r + size * over**power, 0.0) - mu_r) * normal_force * radius


LAW = Law(
    name="rolling_power",
    kind="rolling_relative",
    function=rolling_power,
    parameters=(
        Parameter("size", "-", -5.0, 5.0, "what is added to μ_r at that speed"),
        Parameter("speed", "m/s", 1e-3, 100.0, "rolling speed at which it is added"),
        Parameter("power", "-", -4.0, 6.0, "power of the rolling speed"),
    ),
    source="a law of regression",
)
