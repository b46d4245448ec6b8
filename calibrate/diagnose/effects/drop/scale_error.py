"""Scale error: mm per pixel is wrong beyond its stated uncertainty."""

import numpy as np

from calibrate.diagnose.effects.effect import Effect, View


def picture(places: np.ndarray, view: View, value: float) -> np.ndarray:
    """What is read with the stated scale: true place over 1 + `value`, about the middle of the view."""
    return view.middle + (places - view.middle) / (1 + value)


EFFECT = Effect(
    name="scale-error", sector="measurement", unit="1", meaning="true / stated - 1", prior_sd=0.02, low=-0.2, high=0.2,
    source="similarity; a ruler read to 1 mm on 100 mm gives 1 %", twins=("clock-error",),
    separating="a ruler in the plane of motion, or a fall from a measured height", picture=picture,
)  # fmt: skip
