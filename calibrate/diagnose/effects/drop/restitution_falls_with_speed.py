"""Restitution falls with speed, by whatever mechanism: the class of the three laws that a seed hardly tells apart."""

import numpy as np

from calibrate.diagnose.effects.effect import Effect, Hits


def restitution(hits: Hits, e: np.ndarray, value: float) -> np.ndarray:
    """e − value ln(v / 1 m/s) / ln 4: between the powers ⅕ and −¼; `value` = e(0.5 m/s) − e(2 m/s)."""
    return e - value * np.log(hits.speed) / np.log(4)


def curved(hits: Hits, e: np.ndarray, value: float) -> np.ndarray:
    """e − value ln²(v / 1 m/s): leaves e(0.5 m/s) − e(2 m/s) as it is."""
    return e - value * np.log(hits.speed) ** 2


EFFECT = Effect(
    name="restitution-falls-with-speed", sector="impact", unit="1",
    meaning="e(0.5 m/s) - e(2.0 m/s) of the normal restitution of a central impact", prior_sd=0.1, low=0.0, high=0.8,
    source="Biosystems Engineering (2017), 10.1016/j.biosystemseng.2017.06.009",
    twins=("viscoelastic-restitution", "plastic-restitution", "plate-compliance"),
    separating="ten drops of the same seed from each of 20, 100 and 500 mm; a plate that gives way also moves",
    restitution=restitution,
)  # fmt: skip
CURVATURE = Effect(
    name="restitution-falls-with-speed.curvature", sector="impact", unit="1", meaning="coefficient of -ln(v / 1 m/s)^2 beside it",
    prior_sd=0.02, low=-1.0, high=1.0, source="between the powers -1/4 and 1", restitution=curved,
    group="restitution-falls-with-speed",
)  # fmt: skip
