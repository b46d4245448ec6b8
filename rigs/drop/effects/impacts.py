"""Impacts: a sticky film's energy, damage by each impact, a tilted plate, a seed less
round.

A seed less round than stated exchanges spin and translation, an alternative baseline:
its contact lies b beside the centre, I Δω = b J_n + h J_t, which shows in b or in the
scatter of kicks."""

import math

import numpy as np

from benchtwin.infer.effect import Counterpart, Effect, Key
from benchtwin.rigs.drop.effects.hooks import Hits, tilted_kick, tilted_restitution

REACH = 0.45  # rms of b over (a − c) of ellipsoids in any attitude: 0.37 to 0.41 in 3-D
ROUGH = 0.02  # of the radius: b of a rough ball


def filmed(hits: Hits, e: np.ndarray, value: float) -> np.ndarray:
    """√(e² − value/v²), `value` = 2 W/m [m²/s²]; 0 where nothing is left."""
    return np.sqrt(np.maximum(e**2 - value / hits.speed**2, 0.0))


def damaged(hits: Hits, e: np.ndarray, value: float) -> np.ndarray:
    """e (1 + value)^(n − 1), n = 1 for the first impact of a recording."""
    return e * np.maximum(1 + value, 0.0) ** (hits.count - 1)


SHAPE = Effect(
    name="shape-conversion",
    sector="impact",
    unit="",
    meaning="the seed is much less round than stated",
    prior_sd=1.0,
    low=0.0,
    high=10.0,
    source="angular momentum about the point of contact",
    separating="callipers on the seeds that were dropped",
    wording=("the seed's shape turns fall into spin more than allowed for", ""),
    not_simulated="shape is the twin's own already: its seeds are not spheres",
)
EFFECTS = (
    Effect(
        name="film-adhesion",
        sector="impact",
        unit="m/s",
        meaning="sqrt(2 W / m) of the energy W lost per impact",
        prior_sd=0.15**2,
        low=0.0,
        high=0.25,
        restitution=filmed,
        reported=lambda value: math.copysign(math.sqrt(abs(value)), value),
        source=(
            "energy balance; films on seeds hold 0.01 to 0.15 m/s, dry JKR adhesion"
            " 0.002 m/s"
        ),
        wording=("a sticky film takes energy at every impact", "m/s"),
        separating=(
            "drops from 30 and 100 mm: a film takes most from slow impacts, damage"
            " does not"
        ),
        counterpart=Counterpart(
            "a film takes ½ m v² of every impact, v = {value} m/s",
            lambda v: {
                "laws": {
                    "restitution_film": {"film_speed": max(v["film-adhesion"], 0.0)}
                }
            },
        ),
    ),
    Effect(
        name="impact-damage",
        sector="impact",
        unit="1",
        meaning="relative change of e per impact",
        prior_sd=0.05,
        low=-0.6,
        high=0.0,
        source="a bruised seat is softer: 1 to 10 % an impact; no impact mends a seed",
        restitution=damaged,
        wording=(
            "restitution changes with every impact of a seed",
            "of itself per impact",
        ),
        separating=(
            "the same seed again from the same height: damage stays, a film or a law of"
            " speed begins anew"
        ),
        not_simulated="the twin's seeds do not remember their impacts",
    ),
    Effect(
        name="plate-tilt",
        sector="impact",
        unit="deg",
        meaning="tilt, falling towards +x",
        prior_sd=1.0,
        low=-15.0,
        high=15.0,
        source="reflection about the plate's normal",
        wording=("the plate is tilted", "° falling towards +x"),
        key=Key("drop", "tilt_deg", absent=0.0, whole=True),
        kick=tilted_kick,
        restitution=tilted_restitution,
        separating="a spirit level on the plate; the plate turned round by half a turn",
        counterpart=Counterpart(
            "the plate slopes by {value}° (positive: falling towards +x)",
            lambda v: {"rig": {"tilt_deg": v["plate-tilt"]}},
        ),
    ),
    SHAPE,
)
