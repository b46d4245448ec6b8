"""Yielding in the contact: e ∝ v^−¼ above the speed of first yield."""

import numpy as np

from calibrate.diagnose.effects.effect import Effect, Hits


def restitution(hits: Hits, e: np.ndarray, value: float) -> np.ndarray:
    """e + value v^−¼ / (0.5^−¼ − 2^−¼), v in m/s; the constant left to the fit stands for what is not yield."""
    return e + value * hits.speed**-0.25 / (0.5**-0.25 - 2**-0.25)


EFFECT = Effect(
    name="plastic-restitution", sector="impact", unit="1",
    meaning="e(0.5 m/s) - e(2.0 m/s) of the normal restitution of a central impact", prior_sd=0.1, low=0.0, high=0.8,
    source="Johnson (1985), Contact Mechanics, §11.5; Wu, Li, Thornton (2003), Int. J. Impact Eng. 28, 929",
    twins=("restitution-falls-with-speed", "viscoelastic-restitution", "plate-compliance"),
    separating="ten drops of the same seed from each of 20, 100 and 500 mm; a plate that gives way also moves",
    restitution=restitution,
)  # fmt: skip
