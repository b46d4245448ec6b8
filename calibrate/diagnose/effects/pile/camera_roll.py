"""Camera roll: the picture is rolled, plate and heap together. A heap that was tilted after it was poured looks the same."""

from calibrate.diagnose.effects.effect import Effect
from calibrate.diagnose.effects.pile.shapes import Law

EFFECT = Effect(
    name="camera-roll", sector="measurement", unit="deg", meaning="true plumb - stated plumb, clockwise", prior_sd=2.0, low=-10.0,
    high=10.0, source="rotation of the picture", twins=("base-tilt",), separating="a plumb line in the picture",
)  # fmt: skip
LAWS = {"camera-roll": Law(turn_deg={"plumb": 1.0, "plate": 0.0, "rows": 1.0}, plate_deg=1.0)}
