"""A plate that is not level turns its line in the picture, a rolled camera
everything."""

from benchtwin.bench.priors import unstated_sd
from benchtwin.infer.effect import Key
from benchtwin.rigs.pile.effects.shapes import HeapEffect, Law

EFFECTS = (
    HeapEffect(
        name="base-tilt",
        sector="measurement",
        unit="deg",
        meaning="tilt of the plate, clockwise in the picture",
        prior_sd=2.0,
        low=-10.0,
        high=10.0,
        source="flanks stand at the angle of repose to gravity, whatever they stand on",
        wording=("the base is tilted", "°"),
        not_simulated="the twin's plate under a heap is level",
        separating=(
            "a plumb line in the picture, the plate's edge seen, and a heap with two"
            " flanks (lifting cylinder)"
        ),
        law=Law(
            turn_deg={"plumb": 0.0, "plate": -1.0, "rows": -1.0},
            turn_after_deg={"plumb": 1.0},
            plate_deg=1.0,
            known_deg=lambda photos: unstated_sd("level-plate"),
        ),
    ),
    HeapEffect(
        name="camera-roll",
        sector="measurement",
        unit="deg",
        meaning="true plumb - stated plumb, clockwise",
        prior_sd=2.0,
        low=-10.0,
        high=10.0,
        source="rotation of the picture",
        wording=("the camera is rolled", "° clockwise beyond what is stated"),
        separating="a plumb line in the picture",
        key=Key("camera", "plumb_deg"),
        not_simulated="the twin's camera of a heap is upright",
        law=Law(
            turn_deg={"plumb": 1.0, "plate": 0.0, "rows": 1.0},
            plate_deg=1.0,
            known_deg=lambda photos: max(p.plumb_sd_deg for p in photos),
        ),
    ),
)
