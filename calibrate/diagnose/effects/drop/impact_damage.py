"""Impact damage: e falls by a fixed factor with every impact that a seed has had; no impact mends a seed."""

import numpy as np

from calibrate.diagnose.effects.effect import Effect, Hits


def restitution(hits: Hits, e: np.ndarray, value: float) -> np.ndarray:
    """e (1 + value)^(n − 1), n = 1 for the first impact of a recording."""
    return e * np.maximum(1 + value, 0.0) ** (hits.count - 1)


EFFECT = Effect(
    name="impact-damage", sector="impact", unit="1", meaning="relative change of e per impact", prior_sd=0.05, low=-0.6, high=0.0,
    source="a bruised seat is softer: 1 to 10 % an impact", twins=("film-adhesion",),
    separating="the same seed again from the same height: damage stays, a film or a law of speed begins anew",
    restitution=restitution,
)  # fmt: skip
