"""Spring–dashpot–slider rolling friction, LAMMPS's `rolling sds`: a spring of one
stiffness between the two bodies' rolling."""

import math

from benchtwin.sim.laws.law import Law, Parameter


def rolling_sds(
    mx,
    my,
    mz,
    ax,
    ay,
    az,
    dt,
    stiffness,
    normal_force,
    radius,
    inertia,
    mu_r,
    spring,
    dashpot,
):
    """M = M_before − k R*² Δθ, torque M − γ R*² dθ/dt, cut to μ_r F_n R*; at the cap M
    is left holding it less the dashpot's part.

    Arguments as in `rolling_type_c` (stiffness [N/m] and inertia [kg m²] unused);
    spring k [N/m] and dashpot γ [N s/m] act on the rolling distance R* θ. mu_r [-] is
    in the R* convention: between two equal balls twice EDEM's number brakes alike, on a
    wall the same. Valid while the time step resolves the spring: dt < √(I_r / k R*²).

    Source: LAMMPS manual, pair_style granular, rolling sds; Luding (2008), Granular
    Matter 10, 235–246.

    >>> below = rolling_sds(
    ...     0, 0, 0, 1e-3, 0, 0, 1e-6, 0.0, 2.0, 0.003, 0.0, 0.02, 1000.0, 0.0
    ... )
    >>> [round(m, 9) for m in below]
    [-9e-06, 0.0, 0.0, -9e-06, 0.0, 0.0]
    >>> at_the_cap = rolling_sds(
    ...     0, 0, 0, 1.0, 0, 0, 1e-6, 0.0, 2.0, 0.003, 0.0, 0.02, 1000.0, 0.0
    ... )
    >>> round(at_the_cap[0], 9)
    -0.00012
    """
    k = spring * radius * radius
    c = dashpot * radius * radius / dt
    mx = mx - k * ax
    my = my - k * ay
    mz = mz - k * az
    tx = mx - c * ax
    ty = my - c * ay
    tz = mz - c * az
    limit = mu_r * normal_force * radius
    size = math.sqrt(tx * tx + ty * ty + tz * tz)
    if size > limit:
        cut = limit / size
        tx = tx * cut
        ty = ty * cut
        tz = tz * cut
        mx = tx + c * ax
        my = ty + c * ay
        mz = tz + c * az
    return mx, my, mz, tx, ty, tz


LAW = Law(
    name="rolling_sds",
    kind="rolling_spring",
    function=rolling_sds,
    parameters=(
        Parameter(
            "spring",
            "N/m",
            0.0,
            1e12,
            "stiffness k against rolling distance, below the cap",
        ),
        Parameter("dashpot", "N s/m", 0.0, 1e6, "damping γ of the rolling spring"),
    ),
    source=(
        "LAMMPS manual, pair_style granular, rolling sds; Luding (2008), Granular"
        " Matter 10, 235–246"
    ),
)
