"""Tilt and roll: a plate that is not level turns its line in the picture, a camera that is rolled turns all of it.

Flanks of a heap that is poured on a tilted plate keep one angle to gravity; tilted later, it is a rolled picture of itself.
"""

from diagnose.effects.pile.shapes import HeapEffect, Law

LEVEL_SD_DEG = 0.2  # of a plate that a spirit level says is level

EFFECTS = (
    HeapEffect(
        name="base-tilt", sector="measurement", unit="deg", meaning="tilt of the plate, clockwise in the picture", prior_sd=2.0,
        low=-10.0, high=10.0, source="flanks stand at the angle of repose to gravity, whatever they stand on",
        says=("the base is tilted", "°"), untwinned="the twin's plate under a heap is level",
        separating="a plumb line in the picture, the plate's edge seen, and a heap with two flanks (lifting cylinder)",
        law=Law(
            turn_deg={"plumb": 0.0, "plate": -1.0, "rows": -1.0}, turn_after_deg={"plumb": 1.0},
            plate_deg=1.0, known_deg=lambda photos: LEVEL_SD_DEG,
        ),
    ),
    HeapEffect(
        name="camera-roll", sector="measurement", unit="deg", meaning="true plumb - stated plumb, clockwise", prior_sd=2.0,
        low=-10.0, high=10.0, source="rotation of the picture", says=("the camera is rolled", "° clockwise beyond what is stated"),
        separating="a plumb line in the picture", untwinned="the twin's camera of a heap is upright",
        law=Law(
            turn_deg={"plumb": 1.0, "plate": 0.0, "rows": 1.0}, plate_deg=1.0,
            known_deg=lambda photos: max(p.plumb_sd_deg for p in photos),
        ),
    ),
)  # fmt: skip
