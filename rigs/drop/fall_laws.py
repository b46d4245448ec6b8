"""A fall of restitution between two speeds, as the DEM's laws take it."""

from collections.abc import Callable

from scipy.optimize import brentq

from benchtwin.sim.laws import LAWS

SLOW_M_S, FAST_M_S = 0.5, 2.0  # a fall is e(slow) − e(fast)


def viscoelastic(fall: float, e: float, anchor_m_s: float) -> dict[str, float]:
    """Numbers of the law "restitution_viscoelastic" with this fall, and with e at the
    anchor's speed.

    >>> {k: round(v, 3) for k, v in viscoelastic(0.08, 0.5, 1.5).items()}
    {'viscosity': 0.811, 'anchor_speed': 1.5}
    """
    law = LAWS["restitution_viscoelastic"].function
    return {
        "viscosity": _solved(lambda k: _fall(law, e, k, anchor_m_s), fall, 0.0, 3.0),
        "anchor_speed": anchor_m_s,
    }


def yielding(fall: float, e: float, anchor_m_s: float) -> dict[str, float]:
    """The same of the law "restitution_plastic"; the steepest that yielding spheres can
    be where the fall is greater."""
    law = LAWS["restitution_plastic"].function
    speed = _solved(lambda v: -_fall(law, e, v, anchor_m_s), -fall, 1e-3, FAST_M_S)
    return {"yield_speed": speed, "anchor_speed": anchor_m_s}


def _fall(law: Callable, e: float, number: float, anchor: float) -> float:
    return law(SLOW_M_S, e, number, anchor) - law(FAST_M_S, e, number, anchor)


def _solved(
    rising: Callable[[float], float], want: float, low: float, high: float
) -> float:
    """Where rising(x) = want; the nearer end where it is never."""
    if rising(low) >= want:
        return low
    if rising(high) <= want:
        return high
    return brentq(lambda x: rising(x) - want, low, high)
