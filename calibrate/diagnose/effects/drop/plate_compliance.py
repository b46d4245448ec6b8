"""The plate carries energy away as bending waves: e falls as v^⅕, by Zener."""

import numpy as np

from calibrate.diagnose.effects.effect import Effect, Hits


def restitution(hits: Hits, e: np.ndarray, value: float) -> np.ndarray:
    """e − value v^⅕ / (2^⅕ − 0.5^⅕): e ≈ e₀ (1 − c λ) for small inelasticity λ ∝ v^⅕; the very law of viscous loss."""
    return e - value * hits.speed**0.2 / (2**0.2 - 0.5**0.2)


EFFECT = Effect(
    name="plate-compliance", sector="impact", unit="1",
    meaning="e(0.5 m/s) - e(2.0 m/s) of the normal restitution of a central impact", prior_sd=0.1, low=0.0, high=0.8,
    source="Zener (1941), Phys. Rev. 59, 669; Müller et al. (2016), Powder Technology 292",
    twins=("restitution-falls-with-speed", "viscoelastic-restitution", "plastic-restitution"),
    separating="ten drops of the same seed from each of 20, 100 and 500 mm; a plate that gives way also moves",
    restitution=restitution,
)  # fmt: skip
