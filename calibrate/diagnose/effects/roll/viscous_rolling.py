"""Viscous rolling: the resistance to rolling grows with speed."""

import numpy as np

from calibrate.diagnose.effects.effect import Effect


def resistance(speed: np.ndarray, value: float) -> np.ndarray:
    """Over weight: k |v|, k = `value` [s/m], speed [m/s]."""
    return value * speed


EFFECT = Effect(
    name="viscous-rolling", sector="run-out", unit="s/m", meaning="slope of mu_r on speed", prior_sd=0.02, low=0.0, high=2.0,
    source="Brilliantov, Pöschel (1998), Europhys. Lett. 42, 511 (viscoelastic balls: mu_r grows as v)", twins=("drag",),
    separating="the same roll in still air with a screen's draught shut out, and from a longer incline: drag grows as the square "
    "of speed, and a heavier ball of the same size hardly feels it",
)  # fmt: skip
