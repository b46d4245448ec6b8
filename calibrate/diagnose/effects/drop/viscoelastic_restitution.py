"""Viscous loss in the contact: e = e₀ − γ v^⅕."""

import numpy as np

from calibrate.diagnose.effects.effect import Effect, Hits


def restitution(hits: Hits, e: np.ndarray, value: float) -> np.ndarray:
    """e − value v^⅕ / (2^⅕ − 0.5^⅕), v in m/s; what e tends to at rest is left to the fit."""
    return e - value * hits.speed**0.2 / (2**0.2 - 0.5**0.2)


EFFECT = Effect(
    name="viscoelastic-restitution", sector="impact", unit="1",
    meaning="e(0.5 m/s) - e(2.0 m/s) of the normal restitution of a central impact", prior_sd=0.1, low=0.0, high=0.8,
    source="Kuwabara, Kono (1987), Jpn. J. Appl. Phys. 26, 1230; Ramírez et al. (1999), Phys. Rev. E 60, 4465",
    twins=("restitution-falls-with-speed", "plastic-restitution", "plate-compliance"),
    separating="ten drops of the same seed from each of 20, 100 and 500 mm; a plate that gives way also moves",
    restitution=restitution,
)  # fmt: skip
