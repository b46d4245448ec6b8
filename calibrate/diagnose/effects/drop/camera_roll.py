"""Camera roll: gravity in the picture is off beyond plumb_sd."""

import numpy as np

from calibrate.diagnose.effects.effect import Effect, View


def picture(places: np.ndarray, view: View, value: float) -> np.ndarray:
    """Places in axes along the stated plumb line when the true one is `value` [deg] further clockwise."""
    c, s = np.cos(np.radians(value)), np.sin(np.radians(value))
    x, z = (places - view.middle).T
    return view.middle + np.column_stack([x * c + z * s, z * c - x * s])


EFFECT = Effect(
    name="camera-roll", sector="measurement", unit="deg", meaning="true plumb - stated plumb, clockwise", prior_sd=1.0, low=-10.0,
    high=10.0, source="rotation of the picture", twins=("draught",), separating="a plumb line in the picture", picture=picture,
)  # fmt: skip
