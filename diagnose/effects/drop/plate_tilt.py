"""Plate tilt: the plate is not level in the picture plane and deflects every seed to one side."""

from diagnose.effects.drop.hooks import tilted_kick, tilted_restitution
from diagnose.effects.effect import Counterpart, Effect

EFFECTS = (
    Effect(
        name="plate-tilt", sector="impact", unit="deg", meaning="tilt", prior_sd=1.0, low=-15.0, high=15.0,
        source="reflection about the plate's normal", wording=("the plate is tilted", "°"),
        kick=tilted_kick, restitution=tilted_restitution,
        separating="a spirit level on the plate; the plate turned round by half a turn",
        counterpart=Counterpart("the plate falls by {value}° towards +x", lambda v: {"rig": {"tilt_deg": v["plate-tilt"]}}),
    ),
)  # fmt: skip
