"""Film adhesion: a liquid or sticky film takes a fixed energy W in every impact."""

import math

import numpy as np

from calibrate.diagnose.effects.effect import Effect, Hits


def restitution(hits: Hits, e: np.ndarray, value: float) -> np.ndarray:
    """√(e² − value/v²), `value` = 2 W/m [m²/s²]; below the speed at which nothing is left the seed sticks: 0."""
    square = e**2 - value / hits.speed**2
    return np.sqrt(np.maximum(square, 0.0))


def speed(value: float) -> float:
    """√(2 W/m) [m/s], the sign kept."""
    return math.copysign(math.sqrt(abs(value)), value)


EFFECT = Effect(
    name="film-adhesion", sector="impact", unit="m/s", meaning="sqrt(2 W / m) of the energy W lost per impact", prior_sd=0.15**2,
    low=0.0, high=0.25, source="energy balance; films on seeds hold 0.01 to 0.15 m/s, dry JKR adhesion 0.002 m/s",
    twins=("impact-damage",), separating="drops from 30 and 100 mm: a film takes most from slow impacts, damage does not",
    restitution=restitution, reported=speed,
)  # fmt: skip
