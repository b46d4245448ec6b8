"""Type A rolling friction: a constant torque against the relative rolling of the two
bodies."""

from benchtwin.sim.laws.law import Law


def rolling_type_a(normal_force, rolling_speed, radius, mu_r):
    """Torque τ = μ_r F_n R*, which the engine applies along ∓(ω_i − ω_j) across the
    normal: equal and opposite.

    normal_force [N] (≥ 0), rolling_speed [rad/s] (> 0; unused), radius [m] the
    effective radius R*, mu_r [-]. Valid for dry rolling; piles creep under it (Ai et
    al. 2011: 0.242 m high after 9.6 s, 0.219 m after 48 s), so say at what moment an
    angle of repose was read.

    Source: Ai, Chen, Rotter, Ooi (2011), Powder Technol. 206, 269–282, eq. (6);
    doi:10.1016/j.powtec.2010.09.030

    >>> rolling_type_a(2.0, 5.0, 0.003, 0.01)
    6e-05
    """
    return mu_r * normal_force * radius


LAW = Law(
    name="rolling_type_a",
    kind="rolling_relative",
    function=rolling_type_a,
    source="Ai et al. (2011), model A, doi:10.1016/j.powtec.2010.09.030",
)
