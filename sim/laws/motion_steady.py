"""Steady motion of a wall: a gate that rises, a plate that is tilted, each at a
constant rate between two moments."""

from benchtwin.sim.laws.law import Law, Parameter


def motion_steady(t, rate, start, duration):
    """x(t) = rate · (t − start) from start to start + duration, 0 before and at rest
    after; returns x and its rate.

    t [s]; rate [m/s] for a slide, [rad/s] for a turn; start, duration [s]. The rate
    jumps at both ends; a wall that seeds rest on passes that on to them as a knock of
    the size of the rate.

    Source: kinematics.

    >>> motion_steady(0.5, 0.02, 1.0, 2.0)
    (0.0, 0.0)
    >>> motion_steady(1.5, 0.02, 1.0, 2.0), motion_steady(9.0, 0.02, 1.0, 2.0)
    ((0.01, 0.02), (0.04, 0.0))
    """
    if t < start:
        return 0.0, 0.0
    if t >= start + duration:
        return rate * duration, 0.0
    return rate * (t - start), rate


LAW = Law(
    name="motion_steady",
    kind="motion",
    function=motion_steady,
    parameters=(
        Parameter("rate", "m/s or rad/s", -1e3, 1e3, "speed of the slide or turn"),
        Parameter("start", "s", 0.0, 1e6, "when it begins", 0.0),
        Parameter("duration", "s", 0.0, 1e6, "how long it lasts", 1e6),
    ),
    source="kinematics",
)
