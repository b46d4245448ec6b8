"""A force along the motion of a seed that goes as a power of its speed."""

import math

from benchtwin.sim.laws.law import Law, Parameter


def push_power(vx, vy, vz, wx, wy, wz, diameter, force, speed, power):
    """F = −F_0 (|v|/v_0)^p v/|v|.

    vx vy vz [m/s]; wx wy wz [rad/s] and diameter [m] unused; force F_0 [N] at speed v_0
    [m/s], > 0 against the motion; power p [-]; where p < 0 its size is constant below
    v_0/20. No torque; 0 at rest. Valid for the speeds at which it was measured.

    Source: a law of regression; p = 1 is Stokes', 2 Newton's drag.

    >>> push_power(0.0, 0.0, -2.0, 0, 0, 0, 0.007, 1e-3, 1.0, 3.0)[:3]
    (-0.0, -0.0, 0.008)
    """
    fast = math.sqrt(vx * vx + vy * vy + vz * vz)
    over = fast / speed
    if power < 0.0:
        over = max(over, 0.05)
    k = -force * over**power / max(fast, 1e-12)
    return k * vx, k * vy, k * vz, 0.0, 0.0, 0.0


LAW = Law(
    name="push_power",
    kind="body",
    function=push_power,
    parameters=(
        Parameter("force", "N", -10.0, 10.0, "force at that speed"),
        Parameter("speed", "m/s", 1e-3, 100.0, "speed at which it is the force"),
        Parameter("power", "-", -4.0, 6.0, "power of the speed"),
    ),
    source="a law of regression",
)
