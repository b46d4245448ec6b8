"""Slope: the level plate is not level; where seeds stay on their incline, all leans."""

import math

from benchtwin.infer.effect import Counterpart, Effect, Key

SLOPE = "slope"


def drive(value: float, sign: float) -> float:
    """Weight's share along the motion, sign sin of `value` [deg], falling along +x."""
    return sign * math.sin(math.radians(value))


EFFECTS = (
    Effect(
        name=SLOPE,
        sector="run-out",
        unit="deg",
        meaning="slope, falling towards +x",
        prior_sd=0.5,
        low=-5.0,
        high=5.0,
        source=(
            "component of the weight; one direction alone cannot tell it from rolling"
            " friction"
        ),
        wording=("the plate is not level", "° falling towards +x"),
        separating="the same plate run the other way",
        needs=lambda runs, seed: len({run.sign for run in runs}) > 1,
        act=lambda way, value, context: (
            way | {"level": way["level"] + drive(value, context.run.sign)}
        ),
        counterpart=Counterpart(
            "the level plate slopes by {value}° (positive: falling towards +x)"
        ),
        key=Key("roll", "slope_deg", absent=0.0, whole=True),
    ),
)
