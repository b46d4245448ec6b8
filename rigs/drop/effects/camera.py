"""Errors of a camera: scale, clock, vertical, perspective, lens, centre of a turning
silhouette."""

from benchtwin.infer.effect import FRAME_RATE, SCALE, Counterpart, Effect, Key
from benchtwin.rigs.drop.effects.hooks import (
    distorted,
    keystone,
    scaled,
    turned,
    wobbled,
)

_WOBBLE = (
    "a shadow or a lit side moves one edge by up to a pixel, so the centre by up to"
    " half of one, at 0.1 to 0.3 mm a pixel"
)

_POINT = (
    "a body turns about its centre of mass: contact-nets' cube of 105 mm is tracked"
    " 6 mm beside it, a mark on a seed lies anywhere"
)


EFFECTS = (
    Effect(
        name="scale-error",
        sector="measurement",
        unit="1",
        meaning="true / stated - 1",
        prior_sd=0.02,
        low=-0.2,
        high=0.2,
        source="similarity; a ruler read to 1 mm on 100 mm gives 1 %",
        picture=scaled,
        wording=("the scale is wrong", "= true/stated − 1"),
        separating="a ruler in the plane of motion, or a fall from a measured height",
        key=SCALE,
        counterpart=Counterpart(
            "a pixel of the camera is {value} of itself larger than stated"
        ),
    ),
    Effect(
        name="clock-error",
        sector="measurement",
        unit="1",
        meaning="true fps / stated fps - 1",
        prior_sd=0.02,
        low=-0.2,
        high=0.2,
        source="t² of free fall",
        clock=lambda value: 1 + value,
        wording=("the frame rate is wrong", "= true/stated − 1"),
        separating="a film of a stop watch, or a fall from a measured height",
        key=FRAME_RATE,
        counterpart=Counterpart(
            "the camera runs {value} of its rate faster than stated"
        ),
    ),
    Effect(
        name="camera-roll",
        sector="measurement",
        unit="deg",
        meaning="true plumb - stated plumb, clockwise",
        prior_sd=1.0,
        low=-10.0,
        high=10.0,
        source="rotation of the picture",
        picture=turned,
        wording=("the camera is rolled", "° clockwise beyond what is stated"),
        separating="a plumb line in the picture",
        key=Key("camera", "plumb_deg", absent=0.0),
        counterpart=Counterpart("the camera is rolled by {value}° more than stated"),
    ),
    Effect(
        name="perspective",
        sector="measurement",
        unit="1/m",
        meaning="relative change of scale per metre of height",
        prior_sd=0.05,
        low=-1.0,
        high=1.0,
        source="pinhole camera, first order",
        picture=keystone,
        wording=("the scale changes with height", "per metre"),
        separating="a ruler in the plane of motion, read at the top and at the bottom",
        counterpart=Counterpart(
            "the camera's scale changes by {value} per metre of height"
        ),
    ),
    Effect(
        name="perspective.ruler",
        sector="measurement",
        unit="1",
        meaning="scale at the middle of the view beside the stated one",
        prior_sd=0.005,
        low=-0.1,
        high=0.1,
        source="a ruler stands on the plate, or hangs anywhere in the view",
        group="perspective",
        picture=scaled,
    ),
    Effect(
        name="silhouette-wobble",
        sector="measurement",
        unit="mm",
        meaning="amplitude",
        prior_sd=0.1,
        low=-2.0,
        high=2.0,
        source=_WOBBLE,
        needs=lambda session: session.spins,
        picture=wobbled(0),
        wording=("the tracked centre wobbles as the seed turns", "mm"),
        separating="a film with light from all sides",
        counterpart=Counterpart(
            "the centre of the silhouette goes round by {value} mm as the seed turns"
        ),
    ),
    Effect(
        name="silhouette-wobble.other_phase",
        sector="measurement",
        unit="mm",
        meaning="amplitude a quarter turn on",
        prior_sd=0.1,
        low=-2.0,
        high=2.0,
        source=_WOBBLE,
        needs=lambda session: session.spins,
        picture=wobbled(1),
        group="silhouette-wobble",
    ),
    Effect(
        name="tracked-point",
        sector="measurement",
        unit="mm",
        meaning="from the centre of mass, along the seed's own 0°",
        prior_sd=0.5,
        low=-50.0,
        high=50.0,
        source=_POINT,
        needs=lambda session: session.spins,
        picture=wobbled(0, turns=1),
        wording=("the tracked point lies beside the centre of mass", "mm along 0°"),
        separating="the same seed with its mark elsewhere, or its outline's middle",
        not_simulated="the twin's seeds are tracked at their centres of mass",
    ),
    Effect(
        name="tracked-point.across",
        sector="measurement",
        unit="mm",
        meaning="the same along the seed's own 90°",
        prior_sd=0.5,
        low=-50.0,
        high=50.0,
        source=_POINT,
        needs=lambda session: session.spins,
        picture=wobbled(1, turns=1),
        group="tracked-point",
    ),
    Effect(  # without a name: it describes the distortion, not its cause
        name="(unlisted) measurement: lens",
        sector="measurement",
        unit="1",
        meaning="distortion at the edge of the view",
        prior_sd=0.01,
        low=-0.3,
        high=0.3,
        source="wide angles bend by 1 to 10 %",
        picture=distorted,
        unlisted=True,
        not_simulated="the twin's camera has no lens",
    ),
)
