"""Silhouette wobble: the tracked centre circles twice per turn of the seed."""

import numpy as np

from calibrate.diagnose.effects.effect import Effect, View


def along(places: np.ndarray, view: View, value: float) -> np.ndarray:
    """Adds `value` [mm] (cos 2θ, sin 2θ), θ the seed's angle in the picture."""
    return places + 1e-3 * value * np.column_stack([np.cos(2 * view.angle), np.sin(2 * view.angle)])


def across(places: np.ndarray, view: View, value: float) -> np.ndarray:
    """Adds `value` [mm] (−sin 2θ, cos 2θ): the other phase."""
    return places + 1e-3 * value * np.column_stack([-np.sin(2 * view.angle), np.cos(2 * view.angle)])


SOURCE = "a shadow or a lit side moves one edge by up to a pixel, so the centre by up to half of one, at 0.1 to 0.3 mm a pixel"
EFFECT = Effect(
    name="silhouette-wobble", sector="measurement", unit="mm", meaning="amplitude", prior_sd=0.05, low=-2.0, high=2.0,
    source=SOURCE, needs="spin", separating="a film with light from all sides", picture=along,
)  # fmt: skip
OTHER_PHASE = Effect(
    name="silhouette-wobble.other_phase", sector="measurement", unit="mm", meaning="amplitude a quarter turn on", prior_sd=0.05,
    low=-2.0, high=2.0, source=SOURCE, needs="spin", picture=across, group="silhouette-wobble",
)  # fmt: skip
