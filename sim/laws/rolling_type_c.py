"""Type C rolling friction: an elastic–plastic spring between the two bodies' spins, so
that seeds come to rest."""

import math

from benchtwin.sim.laws.law import Law, Parameter


def rolling_type_c(
    mx, my, mz, ax, ay, az, dt, stiffness, normal_force, radius, inertia, mu_r, damping
):
    """Spring moment M ← M − k_r Δθ, |M| ≤ μ_r F_n R*; below that limit a dashpot −2 η
    √(I_r k_r) dθ/dt is added.

    mx my mz [N m] the spring's moment so far; ax ay az [rad] the relative rolling (ω_i
    − ω_j) dt of this step across the normal; dt [s]; stiffness [N/m] the contact's k_n
    = 2 E* √(R* δ); normal_force [N] (≥ 0); radius [m] R*; inertia [kg m²] I_r, both
    bodies' moments about the contact in series; mu_r [-]; damping [-] η. k_r = 2.25 k_n
    μ_r² R*². Returns the new spring moment and the whole torque on body i (body j gets
    the opposite). Valid while the time step resolves the spring: dt < √(I_r / k_r).

    Source: Ai, Chen, Rotter, Ooi (2011), Powder Technol. 206, 269–282, model C, eqs.
    (14)–(22); doi:10.1016/j.powtec.2010.09.030

    >>> below = rolling_type_c(
    ...     0, 0, 0, 1e-3, 0, 0, 1e-6, 1e4, 2.0, 0.003, 1e-9, 0.01, 0.0
    ... )
    >>> [round(m, 9) for m in below]
    [-2e-08, 0.0, 0.0, -2e-08, 0.0, 0.0]
    >>> at_the_limit = rolling_type_c(
    ...     0, 0, 0, 9.0, 0, 0, 1e-6, 1e4, 2.0, 0.003, 1e-9, 0.01, 0.3
    ... )
    >>> at_the_limit[0]  # μ_r F_n R*
    -6e-05
    """
    k_r = 2.25 * stiffness * mu_r * mu_r * radius * radius
    mx = mx - k_r * ax
    my = my - k_r * ay
    mz = mz - k_r * az
    limit = mu_r * normal_force * radius
    size = math.sqrt(mx * mx + my * my + mz * mz)
    if size >= limit:
        scale = limit / size if size > 0.0 else 0.0
        mx = mx * scale
        my = my * scale
        mz = mz * scale
        return mx, my, mz, mx, my, mz
    c = 2.0 * damping * math.sqrt(inertia * k_r) * (1.0 / dt)
    return mx, my, mz, mx - c * ax, my - c * ay, mz - c * az


LAW = Law(
    name="rolling_type_c",
    kind="rolling_spring",
    function=rolling_type_c,
    parameters=(
        Parameter(
            "damping",
            "-",
            0.0,
            1.0,
            "viscous damping ratio η of the rolling spring below its limit",
            0.3,
        ),
    ),
    source="Ai et al. (2011), model C, doi:10.1016/j.powtec.2010.09.030",
)
