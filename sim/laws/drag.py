"""Air drag on a seed, with C_d(Re) of a sphere times a shape factor, in still air or a
uniform draught."""

import math

from benchtwin.sim.laws.law import Law, Parameter


def drag(
    vx,
    vy,
    vz,
    wx,
    wy,
    wz,
    diameter,
    air_density,
    viscosity,
    factor,
    wind_x,
    wind_y,
    wind_z,
):
    """F = −(π/8) ρ d² C_d |u| u, u = v − wind, C_d = factor · [24/Re (1 + 0.15
    Re^0.681) + 0.407/(1 + 8710/Re)].

    Re = ρ |u| d/η. vx vy vz [m/s]; wx wy wz [rad/s] (unused); diameter d [m] of the
    sphere of equal volume; air_density ρ [kg/m3]; viscosity η [Pa s]; factor [-] 1 for
    a sphere; wind [m/s]. No torque. Valid for Re < 2·10⁵ (measured spheres, 5 %
    scatter); written without a division by Re, so that it tends to Stokes' 3π η d u at
    rest.

    Source: Brown, Lawler (2003), J. Environ. Eng. 129, 222–231, eq. (19).

    >>> force = drag(0, 0, -2.0, 0, 0, 0, 0.007, 1.204, 1.825e-5, 1.0, 0, 0, 0)
    >>> round(1e6 * force[2], 2)
    43.8
    """
    x = vx - wind_x
    y = vy - wind_y
    z = vz - wind_z
    re = air_density * math.sqrt(x * x + y * y + z * z) * diameter / viscosity
    cd_re = 24.0 * (1.0 + 0.15 * re**0.681) + 0.407 * re * re / (re + 8710.0)
    k = -0.39269908169872414 * factor * viscosity * diameter * cd_re
    return k * x, k * y, k * z, 0.0, 0.0, 0.0


LAW = Law(
    name="drag",
    kind="body",
    function=drag,
    parameters=(
        Parameter(
            "air_density", "kg/m3", 0.0, 2000.0, "density of the air (0: vacuum)", 1.204
        ),
        Parameter(
            "viscosity", "Pa s", 1e-7, 1e3, "dynamic viscosity of the air", 1.825e-5
        ),
        Parameter(
            "factor", "-", 0.0, 20.0, "drag over that of a sphere of equal volume", 1.0
        ),
        Parameter("wind_x", "m/s", -50.0, 50.0, "draught along x", 0.0),
        Parameter("wind_y", "m/s", -50.0, 50.0, "draught along y", 0.0),
        Parameter("wind_z", "m/s", -50.0, 50.0, "draught along z", 0.0),
    ),
    source="Brown, Lawler (2003), J. Environ. Eng. 129, 222–231",
)
