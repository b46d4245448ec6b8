"""Perspective: the scale changes linearly with height, because the camera looks up or down or the fall is not square to it."""

import numpy as np

from calibrate.diagnose.effects.effect import Effect, View


def picture(places: np.ndarray, view: View, value: float) -> np.ndarray:
    """Off the middle, true place over 1 + `value` (z − z_ruler): mm per px grows by `value` [1/m] per metre.

    Lines that are upright lean in such a picture, but for the one along which seeds fall: there a plumb line hangs.
    """
    about = view.middle + np.array([view.fall, 0.0])
    return about + (places - about) / (1 + value * (places[:, 1:] - view.middle[1] - view.ruler * view.reach))


RULER = "perspective.ruler"  # acts through View.ruler, beside `perspective` only
WHERE = Effect(
    name=RULER, sector="measurement", unit="1", meaning="where the scale is as stated: height above the middle, in reaches",
    prior_sd=0.6, low=-2.0, high=2.0, source="a ruler stands on the plate, or hangs anywhere in the view", group="perspective",
)  # fmt: skip
EFFECT = Effect(
    name="perspective", sector="measurement", unit="1/m", meaning="relative change of scale per metre of height", prior_sd=0.03,
    low=-1.0, high=1.0, source="pinhole camera, first order", twins=("scale-error",),
    separating="a ruler in the plane of motion, read at the top and at the bottom", picture=picture,
)  # fmt: skip
