"""Losses beside a constant restitution: a sticky film's energy, damage by each impact."""

import math

import numpy as np

from diagnose.effects.drop.hooks import Hits
from diagnose.effects.effect import Counterpart, Effect


def filmed(hits: Hits, e: np.ndarray, value: float) -> np.ndarray:
    """√(e² − value/v²), `value` = 2 W/m [m²/s²]; 0 where nothing is left."""
    return np.sqrt(np.maximum(e**2 - value / hits.speed**2, 0.0))


def damaged(hits: Hits, e: np.ndarray, value: float) -> np.ndarray:
    """e (1 + value)^(n − 1), n = 1 for the first impact of a recording."""
    return e * np.maximum(1 + value, 0.0) ** (hits.count - 1)


EFFECTS = (
    Effect(
        name="film-adhesion", sector="impact", unit="m/s", meaning="sqrt(2 W / m) of the energy W lost per impact",
        prior_sd=0.15**2, low=0.0, high=0.25, restitution=filmed, reported=lambda value: math.copysign(math.sqrt(abs(value)), value),
        source="energy balance; films on seeds hold 0.01 to 0.15 m/s, dry JKR adhesion 0.002 m/s",
        wording=("a sticky film takes energy at every impact", "m/s"),
        separating="drops from 30 and 100 mm: a film takes most from slow impacts, damage does not",
        counterpart=Counterpart(
            "a film takes ½ m v² of every impact, v = {value} m/s",
            lambda v: {"laws": {"restitution_film": {"film_speed": max(v["film-adhesion"], 0.0)}}},
        ),
    ),
    Effect(
        name="impact-damage", sector="impact", unit="1", meaning="relative change of e per impact", prior_sd=0.05, low=-0.6, high=0.0,
        source="a bruised seat is softer: 1 to 10 % an impact; no impact mends a seed", restitution=damaged,
        wording=("restitution changes with every impact of a seed", "of itself per impact"),
        separating="the same seed again from the same height: damage stays, a film or a law of speed begins anew",
        not_simulated="the twin's seeds do not remember their impacts",
    ),
)  # fmt: skip
