"""Restitution that falls with impact speed because the solids yield."""

import math

from benchtwin.sim.laws.law import Law, Parameter


def restitution_plastic(impact_speed, e, yield_speed, anchor_speed):
    """e(v) = e · T(v_y/v) / T(v_y/v_a), at most 1; T(q) = √(6√3/5) √(1 − q²/6) [q/(q +
    2 √(6/5 − q²/5))]^¼ for q < 1, else 1.

    impact_speed v [m/s] ≥ 0; e [-] the restitution entered, which holds at anchor_speed
    v_a [m/s] (0: below yield, where T = 1); yield_speed v_y [m/s] above which an impact
    leaves a dent. Far above it e falls as 1.185 (v_y/v)^¼. Valid for one material that
    yields ideally, until the contact spreads over the whole body (v of about 100 v_y);
    each impact meets an undented spot.

    Source: Thornton (1997), J. Appl. Mech. 64, 383–386, eq. (26).

    >>> speeds = (0.05, 0.1, 1.0, 10.0)
    >>> [round(restitution_plastic(v, 0.8, 0.1, 0.0), 4) for v in speeds]
    [0.8, 0.8, 0.5268, 0.2994]
    """
    q = yield_speed / max(impact_speed, yield_speed)
    p = yield_speed / max(anchor_speed, yield_speed)
    here = math.sqrt(
        2.0784609690826527
        * (1.0 - q * q / 6.0)
        * math.sqrt(q / (q + 2.0 * math.sqrt(1.2 - 0.2 * q * q)))
    )
    there = math.sqrt(
        2.0784609690826527
        * (1.0 - p * p / 6.0)
        * math.sqrt(p / (p + 2.0 * math.sqrt(1.2 - 0.2 * p * p)))
    )
    return min(e * here / there, 1.0)


LAW = Law(
    name="restitution_plastic",
    kind="restitution",
    function=restitution_plastic,
    parameters=(
        Parameter(
            "yield_speed", "m/s", 1e-6, 1e3, "impact speed above which the solids yield"
        ),
        Parameter(
            "anchor_speed",
            "m/s",
            0.0,
            100.0,
            "impact speed at which e is as entered",
            0.0,
        ),
    ),
    source="Thornton (1997), J. Appl. Mech. 64, 383–386",
)
