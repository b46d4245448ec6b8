"""Vibration of a wall: a drive shakes the plate or the base."""

import math

from benchtwin.sim.laws.law import Law, Parameter


def motion_vibration(t, acceleration, frequency, phase):
    """x(t) = A [sin(2π f t + φ) − sin φ], A = a/(2π f)²; returns x and its rate.

    t [s]; acceleration a [m/s2] (for a turn [rad/s2]) the amplitude; frequency f [Hz];
    phase φ [rad]: π/2 starts from rest, 0 at full speed. The wall is where it was built
    at t = 0. Ten steps of the run or more must fit into 1/f.

    Source: kinematics.

    >>> x, rate = motion_vibration(0.005, 9.81, 50.0, 0.0)
    >>> round(1e6 * x, 2), round(1e3 * rate, 3)
    (99.4, 0.0)
    """
    w = 6.283185307179586 * frequency
    return acceleration / (w * w) * (
        math.sin(w * t + phase) - math.sin(phase)
    ), acceleration / w * math.cos(w * t + phase)


LAW = Law(
    name="motion_vibration",
    kind="motion",
    function=motion_vibration,
    parameters=(
        Parameter("acceleration", "m/s2 or rad/s2", 0.0, 1e4, "amplitude"),
        Parameter("frequency", "Hz", 1e-3, 1e5, "cycles a second"),
        Parameter(
            "phase",
            "rad",
            -10.0,
            10.0,
            "phase at t = 0; π/2 starts from rest",
            1.5707963267948966,
        ),
    ),
    source="kinematics",
)
