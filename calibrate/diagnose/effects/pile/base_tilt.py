"""Base tilt: the plate is not level. Its line turns; a heap poured on it keeps both flanks at one angle to gravity."""

from calibrate.diagnose.effects.effect import Effect
from calibrate.diagnose.effects.pile.shapes import Law

EFFECT = Effect(
    name="base-tilt", sector="measurement", unit="deg", meaning="tilt of the plate, clockwise in the picture", prior_sd=2.0,
    low=-10.0, high=10.0, source="flanks stand at the angle of repose to gravity, whatever they stand on", twins=("camera-roll",),
    separating="a plumb line in the picture, the plate's edge seen, and a heap with two flanks (lifting cylinder)",
)  # fmt: skip
LAWS = {"base-tilt": Law(turn_deg={"plumb": 0.0, "plate": -1.0, "rows": -1.0}, plate_deg=1.0)}
